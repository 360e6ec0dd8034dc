/* Normals for meshes that are to look smooth: at each vertex the mean of the normals of the
 * triangles that meet there, each by its angle there, so that it does not matter how a face is cut
 * into triangles. G. Thürmer, C. Wüthrich, "Computing Vertex Normals from Polygonal Facets",
 * Journal of Graphics Tools 3(1), 1998. Vertices in the same place are one: a mesh that texture
 * coordinates have cut open has no seam. SPDX-License-Identifier: MIT */
#include "common/trace/prep_plan.h"

#include <string.h>

#include "common/trace/fmath.h"

/* Normals that cancel leave this little of the sum of the angles, or less: there is none. */
#define CANCELLED 1e-6

/* --- which vertices are in the same place --- */

static uint32_t place_bits(const struct mesh *mesh, uint32_t vertex, size_t axis)
{
    const float v = mesh->vertices[3 * (size_t)vertex + axis] + 0.0f; /* -0 is 0 */
    uint32_t bits;
    memcpy(&bits, &v, sizeof bits);
    return bits;
}

/* One step of a radix sort: by 8 bits of a coordinate. */
static void sort_step(const struct mesh *mesh, size_t axis, uint32_t shift, const uint32_t *from,
                      uint32_t *to)
{
    uint32_t begin[257] = {0};
    for (uint32_t i = 0; i < mesh->vertex_count; i++)
        begin[(place_bits(mesh, i, axis) >> shift & 255) + 1]++;
    for (int i = 1; i < 256; i++)
        begin[i] += begin[i - 1];
    for (uint32_t i = 0; i < mesh->vertex_count; i++)
        to[begin[place_bits(mesh, from[i], axis) >> shift & 255]++] = from[i];
}

static bool same_place(const struct mesh *mesh, uint32_t a, uint32_t b)
{
    return place_bits(mesh, a, 0) == place_bits(mesh, b, 0) &&
           place_bits(mesh, a, 1) == place_bits(mesh, b, 1) &&
           place_bits(mesh, a, 2) == place_bits(mesh, b, 2);
}

/* Of each vertex, the first one in its place. */
static const uint32_t *find_firsts(const struct mesh *mesh, struct arena *arena)
{
    const uint32_t count = mesh->vertex_count;
    uint32_t *order = arena_new(arena, uint32_t, count), *other = arena_new(arena, uint32_t, count);
    for (uint32_t i = 0; i < count; i++)
        order[i] = i;
    for (size_t axis = 0; axis < 3; axis++)
        for (uint32_t shift = 0; shift < 32; shift += 16) {
            sort_step(mesh, axis, shift, order, other);
            sort_step(mesh, axis, shift + 8, other, order);
        }
    uint32_t *first = other; /* no longer needed */
    for (uint32_t i = 0; i < count; i++)
        first[order[i]] =
            i && same_place(mesh, order[i - 1], order[i]) ? first[order[i - 1]] : order[i];
    return first;
}

/* --- what their triangles add --- */

struct sum {
    double n[3], angle;
};

struct edge { /* of a triangle */
    double unit[3], length;
};

static double dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static void cross(const double a[3], const double b[3], double out[3])
{
    for (int k = 0; k < 3; k++) {
        const int i = (k + 1) % 3, j = (k + 2) % 3;
        out[k] = a[i] * b[j] - a[j] * b[i];
    }
}

static struct edge edge_make(const float from[3], const float to[3])
{
    struct edge e;
    for (int k = 0; k < 3; k++)
        e.unit[k] = (double)to[k] - (double)from[k];
    e.length = __builtin_sqrt(dot(e.unit, e.unit));
    for (int k = 0; k < 3; k++)
        e.unit[k] /= e.length;
    return e;
}

/* What a corner adds to its place; e: the edges that leave it. A triangle without an area has no
 * normal. */
static void add_corner(const struct edge *e, const struct edge *f, struct sum *to)
{
    double n[3];
    cross(e->unit, f->unit, n);
    const double sine = __builtin_sqrt(dot(n, n));
    if (!(e->length > 0 && f->length > 0 && sine > 0))
        return;
    const double angle = (double)fmath_atan2((float)sine, (float)dot(e->unit, f->unit));
    for (int k = 0; k < 3; k++)
        to->n[k] += angle * n[k] / sine;
    to->angle += angle;
}

static void add_triangles(const struct mesh *mesh, const uint32_t *first, struct sum *sums)
{
    for (size_t t = 0; t < mesh->triangle_count; t++)
        for (size_t k = 0; k < 3; k++) {
            const uint32_t *v = mesh->indices + 3 * t;
            const float *at = mesh->vertices + 3 * (size_t)v[k];
            const struct edge e = edge_make(at, mesh->vertices + 3 * (size_t)v[(k + 1) % 3]);
            const struct edge f = edge_make(at, mesh->vertices + 3 * (size_t)v[(k + 2) % 3]);
            add_corner(&e, &f, &sums[first[v[k]]]);
        }
}

const float *prep_smooth_make(const struct mesh *mesh, struct arena *arena)
{
    const uint32_t *first = find_firsts(mesh, arena);
    struct sum *sums = arena_new(arena, struct sum, mesh->vertex_count);
    float *normals = arena_new(arena, float, 3 * (size_t)mesh->vertex_count);
    add_triangles(mesh, first, sums);
    for (uint32_t i = 0; i < mesh->vertex_count; i++) {
        const struct sum *s = &sums[first[i]];
        const double length = __builtin_sqrt(dot(s->n, s->n));
        for (int k = 0; k < 3 && length > CANCELLED * s->angle; k++)
            normals[3 * (size_t)i + (size_t)k] = (float)(s->n[k] / length);
    }
    return normals;
}
