/* SPDX-License-Identifier: MIT */
#include <assert.h>
#include <stdlib.h>

#include "bench/accel/accel.h"
#include "common/arena.h"
#include "common/trace/bvh.h"
#include "tests/scenes.h"

/* A scene of one mesh whose vertices are the caller's. */
static void add_mesh(struct scenes *s, struct accel_mesh mesh)
{
    const uint32_t material = scenes_diffuse(s, rgb_gray(0.5f)), corners = 3 * mesh.count;
    uint32_t *indices = arena_new(&s->arena, uint32_t, corners);
    for (uint32_t i = 0; i < corners; i++)
        indices[i] = i;
    s->scene.meshes[s->scene.mesh_count++] =
        (struct mesh){.format = MESH_INLINE,
                      .vertices = mesh.count ? mesh.v[0][0] : NULL,
                      .indices = indices,
                      .vertex_count = corners,
                      .triangle_count = mesh.count};
    s->scene.shapes[s->scene.shape_count++] =
        (struct shape){.kind = SHAPE_MESH, .material = material, .to_world = xform_identity()};
}

void ours_build(struct ours *o, struct accel_mesh mesh)
{
    o->scenes = arena_malloc(1, sizeof *o->scenes);
    scenes_init(o->scenes, 1, 1);
    add_mesh(o->scenes, mesh);
    o->stage = scenes_stage(o->scenes);
    assert(o->stage->prim_count == mesh.count); /* or the numbers would differ */
}

bool ours_hit(const struct ours *o, const struct ray *ray, struct ray_hit *hit)
{
    return bvh_hit_closest(o->stage, ray, hit);
}

uint64_t ours_bytes(const struct ours *o)
{
    return o->stage->bytes;
}

void ours_release(struct ours *o)
{
    scenes_release(o->scenes);
    free(o->scenes);
}
