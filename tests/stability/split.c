/* SPDX-License-Identifier: MIT */
#include "tests/stability/split.h"

#include <math.h>
#include <string.h>

#include "common/vec.h"

enum { PARTS = 24, PIECES = PARTS * PARTS };

struct lamp { /* the triangles of a quad or a mesh */
    const float *vertices;
    const uint32_t *indices;
    uint32_t count; /* 0: it is no flat lamp */
};

static struct lamp lamp_of(const struct scene *s, const struct shape *shape)
{
    static const uint32_t quad[] = {0, 1, 2, 0, 2, 3};
    if (rgb_is_black(shape->emission))
        return (struct lamp){0};
    if (shape->kind == SHAPE_QUAD)
        return (struct lamp){shape->quad.vertices[0], quad, 2};
    if (shape->kind != SHAPE_MESH || s->meshes[shape->mesh.mesh].format != MESH_INLINE)
        return (struct lamp){0};
    const struct mesh *m = &s->meshes[shape->mesh.mesh];
    return (struct lamp){m->vertices, m->indices, m->triangle_count};
}

struct corners {
    const float *of[3];
};

static struct corners corners_of(const struct lamp *l, uint32_t triangle)
{
    const uint32_t *index = l->indices + 3 * (size_t)triangle;
    return (struct corners){{l->vertices + 3 * (size_t)index[0], l->vertices + 3 * (size_t)index[1],
                             l->vertices + 3 * (size_t)index[2]}};
}

/* So wide for where it is that its pieces, rounded to float, are its parts. */
static bool is_wide(const struct corners *t)
{
    const vec3 a = vec3_load(t->of[0]), b = vec3_load(t->of[1]), c = vec3_load(t->of[2]);
    const double longest = fmax((double)vec3_length(b - a),
                                fmax((double)vec3_length(c - a), (double)vec3_length(c - b)));
    const double away = fmax((double)vec3_length(a), (double)vec3_length(b));
    return (double)vec3_length(vec3_cross(b - a, c - a)) > 1e-3 * away * longest;
}

static uint32_t wide_ones(const struct lamp *l)
{
    uint32_t wide = 0;
    for (uint32_t i = 0; i < l->count; i++) {
        const struct corners t = corners_of(l, i);
        wide += is_wide(&t);
    }
    return wide;
}

bool split_can(const struct scene *s)
{
    for (uint32_t i = 0; i < s->shape_count; i++) {
        const struct lamp l = lamp_of(s, &s->shapes[i]);
        if (wide_ones(&l))
            return true;
    }
    return false;
}

/* a + (b - a) i / PARTS + (c - a) k / PARTS */
static void put(float to[3], const struct corners *t, uint32_t i, uint32_t k)
{
    for (int n = 0; n < 3; n++) {
        const double a = (double)t->of[0][n], b = (double)t->of[1][n], c = (double)t->of[2][n];
        to[n] = (float)(a + ((b - a) * i + (c - a) * k) / PARTS);
    }
}

/* PIECES triangles that are the given one, behind each other at v; returns where they end. */
static float (*cut(const struct corners *t, float (*v)[3]))[3]
{
    for (uint32_t i = 0; i < PARTS; i++)
        for (uint32_t k = 0; i + k < PARTS; k++) {
            put(*v++, t, i, k);
            put(*v++, t, i + 1, k);
            put(*v++, t, i, k + 1);
            if (i + k + 1 == PARTS)
                continue;
            put(*v++, t, i + 1, k);
            put(*v++, t, i + 1, k + 1);
            put(*v++, t, i, k + 1);
        }
    return v;
}

static struct mesh pieces_of(const struct lamp *l, struct arena *arena)
{
    const uint32_t wide = wide_ones(l), count = wide * PIECES + l->count - wide;
    float(*const v)[3] = arena_alloc(arena, 3 * (size_t)count, sizeof *v, alignof(float));
    float(*at)[3] = v;
    uint32_t *indices = arena_new(arena, uint32_t, 3 * (size_t)count);
    for (uint32_t i = 0; i < 3 * count; i++)
        indices[i] = i;
    for (uint32_t i = 0; i < l->count; i++) {
        const struct corners t = corners_of(l, i);
        if (is_wide(&t)) {
            at = cut(&t, at);
            continue;
        }
        for (int k = 0; k < 3; k++)
            memcpy(*at++, t.of[k], sizeof *v);
    }
    return (struct mesh){.format = MESH_INLINE,
                         .vertices = v[0],
                         .indices = indices,
                         .vertex_count = 3 * count,
                         .triangle_count = count};
}

void split_lamps(struct scene *s, struct arena *arena)
{
    struct shape *shapes = arena_new(arena, struct shape, s->shape_count);
    struct mesh *meshes = arena_new(arena, struct mesh, s->mesh_count + s->shape_count);
    memcpy(shapes, s->shapes, s->shape_count * sizeof *shapes);
    if (s->mesh_count)
        memcpy(meshes, s->meshes, s->mesh_count * sizeof *meshes);
    for (uint32_t i = 0; i < s->shape_count; i++) {
        const struct lamp l = lamp_of(s, &s->shapes[i]);
        if (!wide_ones(&l))
            continue;
        meshes[s->mesh_count] = pieces_of(&l, arena);
        shapes[i].kind = SHAPE_MESH;
        shapes[i].mesh.mesh = s->mesh_count++;
        shapes[i].mesh.normals = MESH_NORMALS_FLAT;
    }
    s->shapes = shapes;
    s->meshes = meshes;
}
