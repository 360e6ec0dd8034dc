/* SPDX-License-Identifier: MIT */
#include "tests/stability/split.h"

#include <string.h>

enum { PARTS = 24, PIECES = PARTS * PARTS };

static bool is_flat_lamp(const struct scene *s, const struct shape *shape)
{
    return !rgb_is_black(shape->emission) &&
           (shape->kind == SHAPE_QUAD ||
            (shape->kind == SHAPE_MESH && s->meshes[shape->mesh.mesh].format == MESH_INLINE));
}

bool split_can(const struct scene *s)
{
    for (uint32_t i = 0; i < s->shape_count; i++)
        if (is_flat_lamp(s, &s->shapes[i]))
            return true;
    return false;
}

/* a + (b - a) i / PARTS + (c - a) k / PARTS */
static void put(float to[3], const float *const corner[3], uint32_t i, uint32_t k)
{
    for (int n = 0; n < 3; n++) {
        const double a = (double)corner[0][n], b = (double)corner[1][n], c = (double)corner[2][n];
        to[n] = (float)(a + ((b - a) * i + (c - a) * k) / PARTS);
    }
}

/* PIECES triangles that are the given one. */
static void cut(const float *const corner[3], float (*v)[3])
{
    for (uint32_t i = 0; i < PARTS; i++)
        for (uint32_t k = 0; i + k < PARTS; k++) {
            put(*v++, corner, i, k);
            put(*v++, corner, i + 1, k);
            put(*v++, corner, i, k + 1);
            if (i + k + 1 == PARTS)
                continue;
            put(*v++, corner, i + 1, k);
            put(*v++, corner, i + 1, k + 1);
            put(*v++, corner, i, k + 1);
        }
}

static struct mesh pieces_of(const struct scene *s, const struct shape *shape, struct arena *arena)
{
    static const uint32_t quad[2][3] = {{0, 1, 2}, {0, 2, 3}};
    const bool is_quad = shape->kind == SHAPE_QUAD;
    const struct mesh *m = is_quad ? NULL : &s->meshes[shape->mesh.mesh];
    const float *from = m ? m->vertices : shape->quad.vertices[0];
    const uint32_t *index = m ? m->indices : quad[0], count = m ? m->triangle_count : 2;
    const uint32_t all = 3 * PIECES * count;
    float(*v)[3] = arena_alloc(arena, all, sizeof *v, alignof(float));
    uint32_t *indices = arena_new(arena, uint32_t, all);
    for (uint32_t i = 0; i < all; i++)
        indices[i] = i;
    for (uint32_t t = 0; t < count; t++) {
        const float *const corner[3] = {from + 3 * index[3 * t], from + 3 * index[3 * t + 1],
                                        from + 3 * index[3 * t + 2]};
        cut(corner, v + (size_t)3 * PIECES * t);
    }
    return (struct mesh){.format = MESH_INLINE,
                         .vertices = v[0],
                         .indices = indices,
                         .vertex_count = all,
                         .triangle_count = PIECES * count};
}

void split_lamps(struct scene *s, struct arena *arena)
{
    struct shape *shapes = arena_new(arena, struct shape, s->shape_count);
    struct mesh *meshes = arena_new(arena, struct mesh, s->mesh_count + s->shape_count);
    memcpy(shapes, s->shapes, s->shape_count * sizeof *shapes);
    if (s->mesh_count)
        memcpy(meshes, s->meshes, s->mesh_count * sizeof *meshes);
    for (uint32_t i = 0; i < s->shape_count; i++) {
        if (!is_flat_lamp(s, &s->shapes[i]))
            continue;
        meshes[s->mesh_count] = pieces_of(s, &s->shapes[i], arena);
        shapes[i].kind = SHAPE_MESH;
        shapes[i].mesh.mesh = s->mesh_count++;
        shapes[i].mesh.normals = MESH_NORMALS_FLAT;
    }
    s->shapes = shapes;
    s->meshes = meshes;
}
