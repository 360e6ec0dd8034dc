/* SPDX-License-Identifier: MIT */
#include "common/mesh.h"

#include <assert.h>
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

bool mesh_build_triangle(struct mesh_build *b, uint32_t i, uint32_t j, uint32_t k, struct err *err)
{
    const uint32_t t[3] = {i, j, k};
    if (b->indices.size / sizeof t >= SCENE_MAX_TRIANGLES)
        return err_set(err, ERR_LIMIT, "expected at most %d triangles", SCENE_MAX_TRIANGLES);
    buf_append(&b->indices, t, sizeof t);
    return true;
}

static uint32_t corner(const struct mesh_build *b, size_t i)
{
    uint32_t v;
    memcpy(&v, b->polygon.data + i * sizeof v, sizeof v);
    return v;
}

bool mesh_build_polygon(struct mesh_build *b, struct err *err)
{
    const size_t corners = b->polygon.size / sizeof(uint32_t);
    if (corners < 3)
        return err_set(err, ERR_INPUT, "expected a face of at least 3 corners, got %zu", corners);
    for (size_t i = 2; i < corners; i++)
        if (!mesh_build_triangle(b, corner(b, 0), corner(b, i - 1), corner(b, i), err))
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

static const void *keep(const struct buf *b, size_t size, struct arena *arena)
{
    void *copy = arena_alloc(arena, b->size / size, size, size);
    return b->size ? memcpy(copy, b->data, b->size) : copy;
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
    if (good) {
        mesh->vertices = keep(&b.vertices, sizeof(float), arena);
        mesh->indices = keep(&b.indices, sizeof(uint32_t), arena);
        mesh->vertex_count = (uint32_t)mesh_build_vertices(&b);
        mesh->triangle_count = (uint32_t)(b.indices.size / (3 * sizeof(uint32_t)));
    }
    buf_release(&b.vertices);
    buf_release(&b.indices);
    buf_release(&b.polygon);
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
