/* SPDX-License-Identifier: MIT */
#include "common/mesh.h"

#include <assert.h>
#include <math.h>
#include <string.h>
#include <strings.h>

#include "common/mesh_build.h"
#include "common/scene_check.h"

bool mesh_build_vertex(struct mesh_build *b, const double p[3], struct err *err)
{
    float v[3];
    for (int k = 0; k < 3; k++) {
        if (!(p[k] >= -SCENE_MAX_ABS && p[k] <= SCENE_MAX_ABS)) /* refuses a NaN, too */
            return err_set(err, ERR_INPUT, "expected coordinates in [-1e18, 1e18], got %g", p[k]);
        v[k] = (float)p[k];
    }
    if (mesh_build_vertices(b) >= (size_t)3 * SCENE_MAX_TRIANGLES)
        return err_set(err, ERR_LIMIT, "expected at most %u vertices", 3u * SCENE_MAX_TRIANGLES);
    buf_append(&b->vertices, v, sizeof v);
    return true;
}

/* --- what vertices have beside their place --- */

void mesh_normal_make(const double n[3], float out[3])
{
    double greatest = 0, square = 0;
    for (int k = 0; k < 3; k++)
        greatest = fmax(greatest, fabs(n[k]));
    const double scale = greatest > 0 ? greatest : 1; /* so that no square leaves the range */
    for (int k = 0; k < 3; k++)
        square += n[k] / scale * (n[k] / scale);
    const double length = square > 0 ? sqrt(square) : 1;
    for (int k = 0; k < 3; k++)
        out[k] = (float)(n[k] / scale / length);
}

bool mesh_build_normal(struct mesh_build *b, const double n[3], struct err *err)
{
    float unit[3];
    for (int k = 0; k < 3; k++)
        if (!(n[k] >= -SCENE_MAX_ABS && n[k] <= SCENE_MAX_ABS))
            return err_set(err, ERR_INPUT, "expected a normal within [-1e18, 1e18], got %g", n[k]);
    mesh_normal_make(n, unit);
    buf_append(&b->normals, unit, sizeof unit);
    return true;
}

bool mesh_build_uv(struct mesh_build *b, const double uv[2], struct err *err)
{
    const float kept[2] = {(float)uv[0], (float)uv[1]};
    for (int k = 0; k < 2; k++)
        if (!(uv[k] >= -MESH_MAX_UV && uv[k] <= MESH_MAX_UV))
            return err_set(err, ERR_INPUT, "expected texture coordinates in [-1e6, 1e6], got %g",
                           uv[k]);
    buf_append(&b->uvs, kept, sizeof kept);
    return true;
}

static void whiten(struct mesh_build *b, size_t vertices)
{
    static const float white[3] = {1, 1, 1};
    while (b->colors.size / sizeof white < vertices)
        buf_append(&b->colors, white, sizeof white);
}

void mesh_build_whiten(struct mesh_build *b)
{
    if (b->colors.size)
        whiten(b, mesh_build_vertices(b));
}

bool mesh_build_color(struct mesh_build *b, const double c[3], double white, struct err *err)
{
    const double most = white > 0 ? white : SCENE_MAX_ABS;
    float linear[3];
    for (int k = 0; k < 3; k++) {
        if (!(c[k] >= 0 && c[k] <= most))
            return err_set(err, ERR_INPUT, "expected colors in [0, %g], got %g", most, c[k]);
        linear[k] = (float)(white > 0 ? srgb_linear(c[k] / white) : c[k]);
    }
    whiten(b, mesh_build_vertices(b) - 1);
    buf_append(&b->colors, linear, sizeof linear);
    return true;
}

/* --- faces --- */

/* Triangles so far, of which no corner has named anything, are caught up with. */
static void name_corners(struct mesh_build *b, const struct mesh_corner c[3])
{
    bool named = b->corners.size > 0;
    for (int k = 0; k < 3; k++)
        named |= c[k].uv != MESH_NONE || c[k].normal != MESH_NONE;
    if (!named)
        return;
    const uint32_t *indices = (const uint32_t *)(const void *)b->indices.data;
    for (size_t i = b->corners.size / sizeof *c; i < b->indices.size / sizeof *indices; i++)
        buf_append(&b->corners, &(struct mesh_corner){indices[i], MESH_NONE, MESH_NONE}, sizeof *c);
    buf_append(&b->corners, c, 3 * sizeof *c);
}

bool mesh_build_triangle(struct mesh_build *b, const struct mesh_corner c[3], struct err *err)
{
    const uint32_t t[3] = {c[0].vertex, c[1].vertex, c[2].vertex};
    if (b->indices.size / sizeof t >= SCENE_MAX_TRIANGLES)
        return err_set(err, ERR_LIMIT, "expected at most %d triangles", SCENE_MAX_TRIANGLES);
    name_corners(b, c);
    buf_append(&b->indices, t, sizeof t);
    return true;
}

bool mesh_build_polygon(struct mesh_build *b, struct err *err)
{
    const struct mesh_corner *corner = (const struct mesh_corner *)(const void *)b->polygon.data;
    const size_t corners = b->polygon.size / sizeof *corner;
    if (corners < 3)
        return err_set(err, ERR_INPUT, "expected a face of at least 3 corners, got %zu", corners);
    for (size_t i = 2; i < corners; i++)
        if (!mesh_build_triangle(b, (struct mesh_corner[3]){corner[0], corner[i - 1], corner[i]},
                                 err))
            return false;
    b->polygon.size = 0;
    return true;
}

static bool read_bytes(struct mesh_build *b, enum mesh_format format, struct mesh_span file,
                       struct err *err)
{
    switch (format) {
    case MESH_PLY:
        return mesh_ply_read(b, file, err);
    case MESH_OBJ:
        return mesh_obj_read(b, file, err);
    case MESH_INLINE:
        break;
    }
    __builtin_unreachable();
}

static const void *keep(const struct buf *b, struct arena *arena)
{
    return b->size ? memcpy(arena_alloc(arena, b->size, 1, alignof(float)), b->data, b->size)
                   : NULL;
}

static void keep_all(struct mesh_build *b, struct mesh *mesh, struct arena *arena)
{
    mesh_build_whiten(b);
    mesh->vertices = keep(&b->vertices, arena);
    mesh->indices = keep(&b->indices, arena);
    mesh->normals = keep(&b->normals, arena);
    mesh->uvs = keep(&b->uvs, arena);
    mesh->colors = keep(&b->colors, arena);
    mesh->vertex_count = (uint32_t)mesh_build_vertices(b);
    mesh->triangle_count = (uint32_t)(b->indices.size / (3 * sizeof(uint32_t)));
}

static void release(struct mesh_build *b)
{
    struct buf *const all[] = {&b->vertices, &b->indices, &b->polygon, &b->normals,
                               &b->uvs,      &b->colors,  &b->corners};
    for (size_t i = 0; i < countof(all); i++)
        buf_release(all[i]);
}

bool mesh_read(struct mesh *mesh, const void *data, size_t bytes, struct arena *arena,
               struct err *err)
{
    assert(mesh->format != MESH_INLINE);
    struct mesh_build b = {0};
    const char *text = data;
    bool good = read_bytes(&b, mesh->format, (struct mesh_span){text, text + bytes}, err);
    if (good && b.indices.size == 0)
        good = err_set(err, ERR_INPUT,
                       "expected a mesh with at least 1 face, got %zu vertices and no "
                       "face",
                       mesh_build_vertices(&b));
    if (good)
        keep_all(&b, mesh, arena);
    release(&b);
    return good;
}

bool mesh_format_of(const char *file, enum mesh_format *format)
{
    static const struct {
        const char *ending;
        enum mesh_format format;
    } known[] = {{".ply", MESH_PLY}, {".obj", MESH_OBJ}};
    const size_t n = strlen(file);
    for (size_t i = 0; i < countof(known); i++) {
        const size_t e = strlen(known[i].ending);
        if (n >= e && !strcasecmp(file + n - e, known[i].ending)) {
            *format = known[i].format;
            return true;
        }
    }
    return false;
}
