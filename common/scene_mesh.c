/* A mesh in a document: its vertices and triangles themselves, or the name of the file or asset
 * they are in. SPDX-License-Identifier: MIT */
#include "common/scene_read.h"

#include <string.h>

#include "common/mesh.h"
#include "common/scene_check.h"

static const struct scene_range coordinate = {-SCENE_MAX_ABS, SCENE_MAX_ABS, false};

static void read_vertices(struct scene_doc *doc, const struct scene_at *at, struct mesh *mesh)
{
    if (!scene_doc_array(doc, at, "points", 3, SCENE_MAX_TRIANGLES))
        return;
    const size_t count = scene_at_count(at);
    float *vertices = arena_new(doc->arena, float, 3 * count);
    for (size_t i = 0; i < count; i++) {
        const struct scene_at item = scene_at_item(at, i);
        double p[3];
        if (!scene_doc_numbers(doc, &item, coordinate, p, 3))
            continue;
        for (size_t k = 0; k < 3; k++)
            vertices[3 * i + k] = (float)p[k];
    }
    mesh->vertices = vertices;
    mesh->vertex_count = (uint32_t)count;
}

static void read_triangles(struct scene_doc *doc, const struct scene_at *at, struct mesh *mesh)
{
    if (!scene_doc_array(doc, at, "triangles", 1, SCENE_MAX_TRIANGLES))
        return;
    const size_t count = scene_at_count(at);
    uint32_t *indices = arena_new(doc->arena, uint32_t, 3 * count);
    /* Without good vertices, any index that could be one passes. */
    const double last = mesh->vertex_count ? mesh->vertex_count - 1. : SCENE_MAX_TRIANGLES;
    for (size_t i = 0; i < count; i++) {
        const struct scene_at item = scene_at_item(at, i);
        if (scene_at_type(&item) != SCENE_ARRAY || scene_at_count(&item) != 3) {
            scene_doc_expected(doc, &item, ERR_INPUT, "an array of 3 vertex numbers");
            continue;
        }
        for (size_t k = 0; k < 3; k++) {
            const struct scene_at corner = scene_at_item(&item, k);
            uint64_t v = 0;
            scene_doc_integer(doc, &corner, (struct scene_range){0, last, false}, &v);
            indices[3 * i + k] = (uint32_t)v;
        }
    }
    mesh->indices = indices;
    mesh->triangle_count = (uint32_t)count;
}

/* What each vertex has beside its place, so many numbers each. */
struct per_vertex {
    const char *key;
    struct scene_range range;
    size_t numbers;
};

static const struct per_vertex normals_kind = {
    "normals", {-SCENE_MAX_ABS, SCENE_MAX_ABS, false}, 3};
static const struct per_vertex uvs_kind = {"uvs", {-MESH_MAX_UV, MESH_MAX_UV, false}, 2};
static const struct per_vertex colors_kind = {"colors", {0, SCENE_MAX_ABS, false}, 3};

static float *read_per_vertex(struct scene_doc *doc, const struct scene_at *at,
                              const struct mesh *mesh, const struct per_vertex *kind)
{
    if (!scene_doc_array(doc, at, kind->key, 0, SCENE_MAX_TRIANGLES))
        return NULL;
    const size_t count = scene_at_count(at);
    if (mesh->vertices && count != mesh->vertex_count) {
        scene_doc_fault(doc, at, ERR_INPUT, "expected %u %s, one of each vertex, got %zu",
                        mesh->vertex_count, kind->key, count);
        return NULL;
    }
    float *out = arena_new(doc->arena, float, kind->numbers *count);
    for (size_t i = 0; i < count; i++) {
        const struct scene_at item = scene_at_item(at, i);
        float *to = out + kind->numbers * i;
        double v[3];
        if (!scene_doc_numbers(doc, &item, kind->range, v, kind->numbers))
            continue;
        for (size_t k = 0; k < kind->numbers; k++)
            to[k] = (float)v[k];
        if (kind == &normals_kind)
            mesh_normal_make(v, to);
    }
    return out;
}

static void read_inline(struct scene_doc *doc, const struct scene_at *shape, struct mesh *mesh)
{
    struct scene_at member;
    if (scene_at_member(shape, "vertices", &member))
        read_vertices(doc, &member, mesh);
    if (scene_at_member(shape, "triangles", &member))
        read_triangles(doc, &member, mesh);
    if (scene_at_member(shape, "normals", &member) && scene_at_type(&member) == SCENE_ARRAY)
        mesh->normals = read_per_vertex(doc, &member, mesh, &normals_kind);
    if (scene_at_member(shape, "uvs", &member))
        mesh->uvs = read_per_vertex(doc, &member, mesh, &uvs_kind);
    if (scene_at_member(shape, "colors", &member))
        mesh->colors = read_per_vertex(doc, &member, mesh, &colors_kind);
}

/* Whose normals it is shaded with. A list of them is read with the vertices. */
static void read_normals(struct scene_doc *doc, const struct scene_at *shape, bool in_file,
                         enum mesh_normals *normals)
{
    static const char *const names[] = {[MESH_NORMALS_GIVEN] = "file",
                                        [MESH_NORMALS_FLAT] = "flat",
                                        [MESH_NORMALS_SMOOTH] = "smooth"};
    struct scene_at at;
    if (!scene_at_member(shape, "normals", &at) || (!in_file && scene_at_type(&at) == SCENE_ARRAY))
        return;
    for (size_t i = in_file ? 0 : 1; i < countof(names) && scene_at_type(&at) == SCENE_STRING; i++)
        if (!strcmp(scene_at_string(&at), names[i])) {
            *normals = (enum mesh_normals)i;
            return;
        }
    scene_doc_expected(doc, &at, ERR_INPUT,
                       in_file ? "\"file\", \"flat\" or \"smooth\""
                               : "\"flat\", \"smooth\" or an array of normals");
}

static void refuse_beside_file(struct scene_doc *doc, const struct scene_at *shape)
{
    const char *const keys[] = {uvs_kind.key, colors_kind.key};
    struct scene_at at;
    for (size_t i = 0; i < countof(keys); i++)
        if (scene_at_member(shape, keys[i], &at))
            scene_doc_fault(doc, &at, ERR_INPUT, "a mesh in a file has the %s of its file",
                            keys[i]);
}

static void read_file(struct scene_doc *doc, const struct scene_at *at, struct mesh *mesh)
{
    if (doc->source == SCENE_FROM_NET) {
        scene_doc_fault(doc, at, ERR_INPUT,
                        "a document that is sent names meshes by \"asset\" and \"format\", a "
                        "\"file\" can be named by a document on disk only");
        return;
    }
    if (scene_doc_text(doc, at, 1, 4096, &mesh->file) && !mesh_format_of(mesh->file, &mesh->format))
        scene_doc_expected(doc, at, ERR_INPUT, "a file name that ends in .ply or .obj");
}

static void read_asset(struct scene_doc *doc, const struct scene_at *asset,
                       const struct scene_at *format, struct mesh *mesh)
{
    static const char *const formats[] = {"ply", "obj"};
    static const enum mesh_format kinds[] = {MESH_PLY, MESH_OBJ};
    size_t chosen;
    if (scene_doc_choice(doc, format, formats, countof(formats), &chosen))
        mesh->format = kinds[chosen];
    if (scene_at_type(asset) != SCENE_STRING || !hash_is_hex(scene_at_string(asset)))
        scene_doc_expected(doc, asset, ERR_INPUT, "the SHA-256 of a file as 64 digits 0-9, a-f");
    else
        memcpy(mesh->asset, scene_at_string(asset), HASH_HEX);
}

void scene_read_mesh(struct scene_doc *doc, const struct scene_at *shape, struct mesh *mesh,
                     enum mesh_normals *normals)
{
    static const struct scene_key keys[] = {
        {"type", true},      {"material", true},   {"emission", false}, {"transform", false},
        {"vertices", false}, {"triangles", false}, {"file", false},     {"asset", false},
        {"format", false},   {"normals", false},   {"uvs", false},      {"colors", false}};
    struct scene_at vertices, triangles, file, asset, format;
    scene_doc_object(doc, shape, "a mesh", keys, countof(keys));
    const bool has_vertices = scene_at_member(shape, "vertices", &vertices);
    const bool has_triangles = scene_at_member(shape, "triangles", &triangles);
    const bool has_file = scene_at_member(shape, "file", &file);
    const bool has_asset = scene_at_member(shape, "asset", &asset);
    const bool has_format = scene_at_member(shape, "format", &format);
    const bool some_inline = has_vertices || has_triangles, some_asset = has_asset || has_format;
    if (some_inline + has_file + some_asset != 1 || has_vertices != has_triangles ||
        has_asset != has_format)
        scene_doc_fault(doc, shape, ERR_INPUT,
                        "a mesh needs either \"vertices\" and \"triangles\", or \"file\", or "
                        "\"asset\" and \"format\"");
    read_normals(doc, shape, !some_inline, normals);
    if (some_inline)
        read_inline(doc, shape, mesh);
    else
        refuse_beside_file(doc, shape);
    if (has_file)
        read_file(doc, &file, mesh);
    if (has_asset && has_format)
        read_asset(doc, &asset, &format, mesh);
}
