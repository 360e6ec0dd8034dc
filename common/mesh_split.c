/* Corners that name normals and texture coordinates of their own: vertices are made, one for each
 * different choice of a vertex's corners. The first has the vertex's number, the others come behind
 * all that there were, in their order: the bytes of the file alone decide.
 * SPDX-License-Identifier: MIT */
#include "common/mesh_build.h"

#include <stdlib.h>
#include <string.h>

#include "common/arena.h"

struct choice { /* of a corner */
    uint32_t uv, normal;
    uint32_t at; /* its place among all corners */
};

static int choice_order(const void *a, const void *b)
{
    const struct choice *x = a, *y = b;
    if (x->uv != y->uv)
        return x->uv < y->uv ? -1 : 1;
    if (x->normal != y->normal)
        return x->normal < y->normal ? -1 : 1;
    return x->at < y->at ? -1 : 1;
}

/* The choices of vertex v are sorted[end[v - 1]] to sorted[end[v]], of the first one from 0 on. By
 * counting: a sort of all corners at once takes several times as long. */
static void sort_choices(const struct mesh_corner *corners, size_t count, size_t vertices,
                         struct choice *sorted, uint32_t *end)
{
    for (size_t i = 0; i < count; i++)
        if (corners[i].vertex + 1 < vertices)
            end[corners[i].vertex + 1]++;
    for (size_t v = 1; v < vertices; v++)
        end[v] += end[v - 1];
    for (size_t i = 0; i < count; i++)
        sorted[end[corners[i].vertex]++] =
            (struct choice){corners[i].uv, corners[i].normal, (uint32_t)i};
    for (size_t v = 0, begin = 0; v < vertices; begin = end[v++])
        if (end[v] - begin > 1)
            qsort(sorted + begin, end[v] - begin, sizeof *sorted, choice_order);
}

/* What each vertex is to be made of, the old ones first; the triangles get their numbers. */
static void number_choices(const struct choice *sorted, const uint32_t *end, size_t vertices,
                           uint32_t *indices, struct buf *made)
{
    for (size_t v = 0; v < vertices; v++)
        buf_append(made, &(struct mesh_corner){(uint32_t)v, MESH_NONE, MESH_NONE},
                   sizeof(struct mesh_corner));
    for (size_t v = 0, i = 0; v < vertices; v++) {
        size_t number = v;
        for (const size_t begin = i; i < end[v]; i++) {
            const struct mesh_corner c = {(uint32_t)v, sorted[i].uv, sorted[i].normal};
            if (i == begin) {
                memcpy(made->data + v * sizeof c, &c, sizeof c);
            } else if (c.uv != sorted[i - 1].uv || c.normal != sorted[i - 1].normal) {
                number = made->size / sizeof c;
                buf_append(made, &c, sizeof c);
            }
            indices[sorted[i].at] = (uint32_t)number;
        }
    }
}

/* Element `at` of a list whose elements have so many bytes; 0 where there is none. */
static void copy_element(struct buf *to, const struct buf *from, uint32_t at, size_t bytes)
{
    unsigned char *copy = buf_grow(to, bytes);
    if (at == MESH_NONE)
        memset(copy, 0, bytes);
    else
        memcpy(copy, from->data + at * bytes, bytes);
}

static void make_vertices(struct mesh_build *b, const struct mesh_corner *made, size_t count)
{
    const size_t before = mesh_build_vertices(b), colored = b->colors.size / (3 * sizeof(float));
    struct buf normals = {0}, uvs = {0};
    bool has_normals = false, has_uvs = false;
    for (size_t i = 0; i < count; i++) {
        has_normals |= made[i].normal != MESH_NONE;
        has_uvs |= made[i].uv != MESH_NONE;
    }
    for (size_t i = 0; i < count; i++) {
        if (has_normals)
            copy_element(&normals, &b->normals, made[i].normal, 3 * sizeof(float));
        if (has_uvs)
            copy_element(&uvs, &b->uvs, made[i].uv, 2 * sizeof(float));
    }
    for (size_t i = before; i < count; i++) {
        float p[3], c[3] = {1, 1, 1};
        memcpy(p, b->vertices.data + made[i].vertex * sizeof p, sizeof p);
        buf_append(&b->vertices, p, sizeof p);
        if (made[i].vertex < colored)
            memcpy(c, b->colors.data + made[i].vertex * sizeof c, sizeof c);
        if (colored)
            buf_append(&b->colors, c, sizeof c);
    }
    buf_release(&b->normals);
    buf_release(&b->uvs);
    b->normals = normals;
    b->uvs = uvs;
}

void mesh_build_split(struct mesh_build *b)
{
    const size_t vertices = mesh_build_vertices(b);
    const size_t count = b->corners.size / sizeof(struct mesh_corner);
    const struct mesh_corner *corners = (const struct mesh_corner *)(const void *)b->corners.data;
    struct buf made = {0};
    if (count) {
        struct choice *sorted = arena_malloc(count, sizeof *sorted);
        uint32_t *end = arena_malloc(vertices, sizeof *end);
        sort_choices(corners, count, vertices, sorted, end);
        number_choices(sorted, end, vertices, (uint32_t *)(void *)b->indices.data, &made);
        free(sorted);
        free(end);
    }
    mesh_build_whiten(b);
    make_vertices(b, (const struct mesh_corner *)(const void *)made.data,
                  made.size / sizeof(struct mesh_corner));
    buf_release(&made);
}
