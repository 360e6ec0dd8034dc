/* SPDX-License-Identifier: MIT */
#include "tests/soup.h"

#include <math.h>
#include <stdlib.h>

#include "common/trace/bvh.h"
#include "tests/catalog.h"

float (*soup_vertices(struct scenes *s, uint32_t triangles))[3]
{
    return arena_alloc(&s->arena, 3 * (size_t)triangles, sizeof(float[3]), alignof(float));
}

struct shape *soup_mesh(struct scenes *s, uint32_t material, float (*v)[3], uint32_t triangles)
{
    if (s->scene.mesh_count == SCENES_MAX || s->scene.shape_count == SCENES_MAX_SHAPES)
        abort();
    uint32_t *indices = arena_new(&s->arena, uint32_t, 3 * (size_t)triangles);
    for (uint32_t i = 0; i < 3 * triangles; i++)
        indices[i] = i;
    struct shape *shape = &s->scene.shapes[s->scene.shape_count++];
    *shape = (struct shape){.kind = SHAPE_MESH, .material = material, .to_world = xform_identity()};
    shape->mesh.mesh = s->scene.mesh_count;
    s->scene.meshes[s->scene.mesh_count++] = (struct mesh){.format = MESH_INLINE,
                                                           .vertices = triangles ? v[0] : NULL,
                                                           .indices = indices,
                                                           .vertex_count = 3 * triangles,
                                                           .triangle_count = triangles};
    return shape;
}

vec3 soup_point(struct dice *d, double half_side)
{
    vec3 p = {0};
    for (int k = 0; k < 3; k++)
        p[k] = (float)dice_range(d, -half_side, half_side);
    return p;
}

vec3 soup_direction(struct dice *d)
{
    const double z = dice_range(d, -1, 1), r = sqrt(1 - z * z);
    const double phi = dice_range(d, 0, 6.283185307179586);
    return vec3_make((float)(r * cos(phi)), (float)(r * sin(phi)), (float)z);
}

vec3 soup_magnitudes(struct dice *d, double from, double to)
{
    vec3 p = {0};
    for (int k = 0; k < 3; k++) {
        const double size = pow(10, dice_range(d, from, to));
        p[k] = (float)(dice_bits(d) & 1 ? size : -size);
    }
    return p;
}

bool soup_closest(const struct stage *s, const struct ray *ray, struct ray_hit *hit)
{
    struct stage_id id;
    bool any = false;
    for (uint64_t at = 0; catalog_next(s, &at, &id);) {
        struct ray_hit found = {.prim = id.prim, .place = id.place, .instance = id.instance};
        if (!bvh_hit_prim(s, ray, &found))
            continue;
        if (!any || found.t < hit->t || (found.t == hit->t && found.prim < hit->prim))
            *hit = found;
        any = true;
    }
    return any;
}
