/* Shapes and their transforms.
 * SPDX-License-Identifier: MIT */
#include "common/scene_read.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/scene_check.h"
#include "common/scene_wrap.h"

static const struct scene_range coordinate = {-SCENE_MAX_ABS, SCENE_MAX_ABS, false};
static const struct scene_range length_range = {SCENE_MIN_LENGTH, SCENE_MAX_ABS, false};

bool scene_read_matrix(struct scene_doc *doc, const struct scene_at *at, struct scene_xform *out)
{
    double v[16];
    if (!scene_doc_numbers(doc, at, coordinate, v, countof(v)))
        return false;
    if (v[12] != 0 || v[13] != 0 || v[14] != 0 || v[15] != 1)
        return scene_doc_fault(doc, at, ERR_INPUT,
                               "expected a matrix by rows whose last row is 0, 0, 0, 1, got "
                               "%g, %g, %g, %g",
                               v[12], v[13], v[14], v[15]);
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 4; j++)
            out->m[i][j] = v[4 * i + j];
    return true;
}

static bool read_rotate(struct scene_doc *doc, const struct scene_at *at, struct scene_xform *out)
{
    static const struct scene_key keys[] = {{"axis", true}, {"angle", true}};
    double axis[3], angle;
    bool good = scene_doc_object(doc, at, "rotate_deg", keys, countof(keys));
    good &= scene_key_numbers(doc, at, "axis", coordinate, axis, 3);
    good &= scene_key_number(doc, at, "angle", coordinate, &angle);
    if (!good)
        return false;
    if (!(scene_length(axis) > 0))
        return scene_doc_fault(doc, at, ERR_INPUT, "expected an axis with a length, got 0");
    *out = scene_xform_rotate(axis, angle);
    return true;
}

static bool read_scale(struct scene_doc *doc, const struct scene_at *at, struct scene_xform *out)
{
    double f[3];
    if (scene_at_type(at) == SCENE_NUMBER) {
        if (!scene_doc_number(doc, at, coordinate, &f[0]))
            return false;
        f[1] = f[2] = f[0];
    } else if (scene_at_type(at) != SCENE_ARRAY || scene_at_count(at) != 3) {
        return scene_doc_expected(doc, at, ERR_INPUT, "a number or three");
    } else if (!scene_doc_numbers(doc, at, coordinate, f, 3)) {
        return false;
    }
    if (f[0] == 0 || f[1] == 0 || f[2] == 0)
        return scene_doc_fault(doc, at, ERR_INPUT, "expected a scale other than 0");
    *out = scene_xform_scale(f);
    return true;
}

static bool read_step(struct scene_doc *doc, const struct scene_at *at, struct scene_xform *out)
{
    static const struct scene_key keys[] = {
        {"translate", false}, {"rotate_deg", false}, {"scale", false}};
    if (!scene_doc_object(doc, at, "a transform step", keys, countof(keys)))
        return false;
    if (scene_at_count(at) != 1)
        return scene_doc_fault(doc, at, ERR_INPUT,
                               "a transform step has one key of \"translate\", \"rotate_deg\" and "
                               "\"scale\", got %zu",
                               scene_at_count(at));
    struct scene_at value = {0};
    if (scene_at_member(at, "rotate_deg", &value))
        return read_rotate(doc, &value, out);
    if (scene_at_member(at, "scale", &value))
        return read_scale(doc, &value, out);
    double offset[3];
    if (!scene_key_numbers(doc, at, "translate", coordinate, offset, 3))
        return false;
    *out = scene_xform_translate(offset);
    return true;
}

static bool read_steps(struct scene_doc *doc, const struct scene_at *at, struct scene_xform *out)
{
    bool good = true;
    *out = scene_xform_identity();
    for (size_t i = 0; i < scene_at_count(at); i++) {
        const struct scene_at item = scene_at_item(at, i);
        struct scene_xform step;
        if (!read_step(doc, &item, &step))
            good = false;
        else
            *out = scene_xform_join(&step, out);
    }
    return good;
}

bool scene_read_transform(struct scene_doc *doc, const struct scene_at *at, struct scene_xform *out)
{
    if (scene_at_type(at) != SCENE_ARRAY)
        return scene_doc_expected(doc, at, ERR_INPUT,
                                  "16 numbers (a matrix by rows) or a list of steps");
    bool is_matrix = false;
    if (scene_at_count(at) > 0) {
        const struct scene_at first = scene_at_item(at, 0);
        is_matrix = scene_at_type(&first) == SCENE_NUMBER;
    }
    if (!(is_matrix ? scene_read_matrix(doc, at, out) : read_steps(doc, at, out)))
        return false;
    struct err err;
    return scene_check_affine(out, &err) || scene_doc_fault(doc, at, err.code, "%s", err.text);
}

/* What every shape has, beside its own keys. */
/* clang-format off */
#define COMMON_KEYS {"type", true}, {"material", true}, {"emission", false}, {"transform", false}
/* clang-format on */

/* Where a shape would end up is its transform's fault: its own values have been in range. */
static bool place_fault(struct scene_doc *doc, const struct scene_at *shape, const struct err *err)
{
    struct scene_at transform;
    const bool has = scene_at_member(shape, "transform", &transform);
    return scene_doc_fault(doc, has ? &transform : shape, err->code, "%s", err->text);
}

static bool place_check(struct scene_doc *doc, const struct scene_at *shape, const char *what,
                        const struct scene_xform *x, const double center[3], double radius)
{
    struct err err;
    return (scene_check_similarity(x, what, &err) && scene_check_world(x, center, &err) &&
            scene_check_length(x, "a radius", radius, &err)) ||
           place_fault(doc, shape, &err);
}

static bool read_sphere(struct scene_doc *doc, const struct scene_at *at, struct shape *s,
                        const struct scene_xform *x)
{
    static const struct scene_key keys[] = {COMMON_KEYS, {"center", true}, {"radius", true}};
    double center[3], radius;
    bool good = scene_doc_object(doc, at, "a sphere", keys, countof(keys));
    good &= scene_key_numbers(doc, at, "center", coordinate, center, 3);
    good &= scene_key_number(doc, at, "radius", length_range, &radius);
    if (!good || !x)
        return false;
    for (int i = 0; i < 3; i++)
        s->sphere.center[i] = (float)center[i];
    s->sphere.radius = (float)radius;
    return place_check(doc, at, "a sphere", x, center, radius);
}

static bool read_disc(struct scene_doc *doc, const struct scene_at *at, struct shape *s,
                      const struct scene_xform *x)
{
    static const struct scene_key keys[] = {
        COMMON_KEYS, {"center", true}, {"normal", true}, {"radius", true}};
    double center[3], normal[3], radius;
    bool good = scene_doc_object(doc, at, "a disc", keys, countof(keys));
    good &= scene_key_numbers(doc, at, "center", coordinate, center, 3);
    good &= scene_key_numbers(doc, at, "normal", coordinate, normal, 3);
    good &= scene_key_number(doc, at, "radius", length_range, &radius);
    if (!good)
        return false;
    const double length = scene_length(normal);
    struct scene_at member;
    if (!(length > 0))
        return scene_at_member(at, "normal", &member) &&
               scene_doc_fault(doc, &member, ERR_INPUT, "expected a direction, got [0, 0, 0]");
    for (int i = 0; i < 3; i++) {
        s->disc.center[i] = (float)center[i];
        s->disc.normal[i] = (float)(normal[i] / length);
    }
    s->disc.radius = (float)radius;
    return !x || place_check(doc, at, "a disc", x, center, radius);
}

/* The axis is taken before rounding, so that a short cylinder far from the origin keeps its
 * direction. */
static bool read_cylinder(struct scene_doc *doc, const struct scene_at *at, struct shape *s,
                          const struct scene_xform *x)
{
    static const struct scene_key keys[] = {
        COMMON_KEYS, {"from", true}, {"to", true}, {"radius", true}};
    double from[3], to[3], axis[3], radius;
    bool good = scene_doc_object(doc, at, "a cylinder", keys, countof(keys));
    good &= scene_key_numbers(doc, at, "from", coordinate, from, 3);
    good &= scene_key_numbers(doc, at, "to", coordinate, to, 3);
    good &= scene_key_number(doc, at, "radius", length_range, &radius);
    if (!good)
        return false;
    for (int i = 0; i < 3; i++)
        axis[i] = to[i] - from[i];
    const double length = scene_length(axis);
    struct scene_at member;
    if (!(length >= length_range.lo && length <= length_range.hi))
        return scene_at_member(at, "to", &member) &&
               scene_doc_fault(doc, &member, ERR_INPUT,
                               "expected a point 1e-18 to 1e18 m from \"from\", got one %g m away",
                               length);
    for (int i = 0; i < 3; i++) {
        s->cylinder.from[i] = (float)from[i];
        s->cylinder.axis[i] = (float)axis[i];
    }
    s->cylinder.radius = (float)radius;
    struct err err;
    return !x ||
           (place_check(doc, at, "a cylinder", x, from, radius) &&
            ((scene_check_world(x, to, &err) && scene_check_length(x, "a length", length, &err)) ||
             place_fault(doc, at, &err)));
}

static bool read_quad(struct scene_doc *doc, const struct scene_at *at, struct shape *s,
                      const struct scene_xform *x)
{
    static const struct scene_key keys[] = {COMMON_KEYS, {"vertices", true}};
    struct scene_at list;
    scene_doc_object(doc, at, "a quad", keys, countof(keys));
    if (!scene_at_member(at, "vertices", &list))
        return false;
    if (scene_at_type(&list) != SCENE_ARRAY || scene_at_count(&list) != 4)
        return scene_doc_expected(doc, &list, ERR_INPUT, "an array of 4 points");
    double v[4][3];
    struct err err;
    bool good = true;
    for (size_t i = 0; i < 4; i++) {
        const struct scene_at item = scene_at_item(&list, i);
        const bool read = scene_doc_numbers(doc, &item, coordinate, v[i], 3);
        if (read && x && !scene_check_world(x, v[i], &err))
            good = scene_doc_fault(doc, &item, err.code, "%s", err.text);
        good &= read;
        for (int k = 0; read && k < 3; k++)
            s->quad.vertices[i][k] = (float)v[i][k];
    }
    return good &&
           (scene_check_quad(v, &err) || scene_doc_fault(doc, &list, err.code, "%s", err.text));
}

/* Where a mesh's vertices go is known here only when they are in the document. */
static void check_mesh_world(struct scene_doc *doc, const struct scene_at *at,
                             const struct mesh *mesh, const struct scene_xform *x)
{
    struct scene_at list;
    if (!scene_at_member(at, "vertices", &list))
        return;
    for (uint32_t i = 0; i < mesh->vertex_count; i++) {
        const float *v = mesh->vertices + (size_t)3 * i;
        const double p[3] = {(double)v[0], (double)v[1], (double)v[2]};
        struct err err;
        if (!scene_check_world(x, p, &err)) {
            const struct scene_at item = scene_at_item(&list, i);
            scene_doc_fault(doc, &item, err.code, "%s", err.text);
        }
    }
}

/* Next-event estimation takes a lamp's whole surface for its light. */
static void check_shines(struct scene_doc *doc, const struct scene_at *at,
                         const struct scene *scene, const struct shape *s)
{
    struct scene_at member;
    if (!rgb_is_black(s->emission) && scene_wrap_has_mask(scene, s->material) &&
        scene_at_member(at, "emission", &member))
        scene_doc_expected(doc, &member, ERR_INPUT, "no emission where the material has a mask");
}

static void read_emission(struct scene_doc *doc, const struct scene_at *shape,
                          const struct scene_names *textures, struct shape *s)
{
    static const struct scene_key keys[] = {{"texture", true}, {"scale", false}};
    static const struct scene_range range = {0, SCENE_MAX_ABS, false};
    struct scene_at at, name;
    if (!scene_at_member(shape, "emission", &at))
        return;
    if (scene_at_type(&at) != SCENE_OBJECT) {
        scene_doc_rgb(doc, &at, range, &s->emission);
        return;
    }
    uint32_t texture;
    s->emission = rgb_gray(1);
    scene_doc_object(doc, &at, "a textured emission", keys, countof(keys));
    scene_key_rgb(doc, &at, "scale", range, &s->emission);
    if (scene_at_member(&at, "texture", &name) && scene_names_find(doc, &name, textures, &texture))
        s->glow = texture + 1;
}

static const char *const shape_names[] = {[SHAPE_SPHERE] = "sphere",
                                          [SHAPE_DISC] = "disc",
                                          [SHAPE_CYLINDER] = "cylinder",
                                          [SHAPE_QUAD] = "quad",
                                          [SHAPE_MESH] = "mesh"};

static void read_shape(struct scene_doc *doc, const struct scene_at *at,
                       const struct scene_known *names, struct scene *scene, struct shape *s)
{
    size_t kind;
    if (!scene_doc_kind(doc, at, "a shape", shape_names, countof(shape_names), &kind))
        return;
    s->kind = (enum shape_kind)kind;
    struct scene_at member;
    const bool found = scene_at_member(at, "material", &member) &&
                       scene_names_find(doc, &member, names->materials, &s->material);
    read_emission(doc, at, names->textures, s);
    if (found)
        check_shines(doc, at, scene, s);
    struct scene_xform x = scene_xform_identity();
    const bool placed =
        !scene_at_member(at, "transform", &member) || scene_read_transform(doc, &member, &x);
    s->to_world = scene_xform_round(&x);
    const struct scene_xform *known = placed ? &x : NULL;
    switch (s->kind) {
    case SHAPE_SPHERE:
        read_sphere(doc, at, s, known);
        return;
    case SHAPE_DISC:
        read_disc(doc, at, s, known);
        return;
    case SHAPE_CYLINDER:
        read_cylinder(doc, at, s, known);
        return;
    case SHAPE_QUAD:
        read_quad(doc, at, s, known);
        return;
    case SHAPE_MESH:
        s->mesh.mesh = scene->mesh_count++;
        scene_read_mesh(doc, at, &scene->meshes[s->mesh.mesh], &s->mesh.normals);
        if (placed)
            check_mesh_world(doc, at, &scene->meshes[s->mesh.mesh], &x);
        return;
    }
}

/* --- meshes that several shapes name --- */

struct naming {
    const char *name; /* file or asset */
    enum mesh_format format;
    uint32_t mesh;
};

static int naming_order(const void *a, const void *b)
{
    const struct naming *x = a, *y = b;
    const int names = strcmp(x->name, y->name);
    if (names || x->format != y->format)
        return names ? names : x->format < y->format ? -1 : 1;
    return x->mesh < y->mesh ? -1 : 1;
}

/* One mesh for each name: it is read once, and can be prepared as one. They stay in the order in
 * which they are first named. (No asset is named like a file, which ends in .ply or .obj.) */
static void unite_meshes(struct scene *scene, struct arena *arena)
{
    struct naming *by_name = arena_new(arena, struct naming, scene->mesh_count);
    uint32_t *becomes = arena_new(arena, uint32_t, scene->mesh_count);
    uint32_t named = 0, kept = 0;
    for (uint32_t i = 0; i < scene->mesh_count; i++) {
        const struct mesh *m = &scene->meshes[i];
        becomes[i] = i;
        if (m->format != MESH_INLINE)
            by_name[named++] = (struct naming){m->file ? m->file : m->asset, m->format, i};
    }
    if (named)
        qsort(by_name, named, sizeof *by_name, naming_order);
    for (uint32_t i = 1; i < named; i++)
        if (!strcmp(by_name[i].name, by_name[i - 1].name) &&
            by_name[i].format == by_name[i - 1].format)
            becomes[by_name[i].mesh] = becomes[by_name[i - 1].mesh];
    for (uint32_t i = 0; i < scene->mesh_count; i++) {
        if (becomes[i] == i) {
            scene->meshes[kept] = scene->meshes[i];
            becomes[i] = kept++;
        } else {
            becomes[i] = becomes[becomes[i]]; /* an earlier one, whose place is known */
        }
    }
    scene->mesh_count = kept;
    for (uint32_t i = 0; i < scene->shape_count; i++)
        if (scene->shapes[i].kind == SHAPE_MESH)
            scene->shapes[i].mesh.mesh = becomes[scene->shapes[i].mesh.mesh];
}

static size_t mesh_count(const struct scene_at *shapes)
{
    size_t count = 0;
    for (size_t i = 0; i < scene_at_count(shapes); i++) {
        const struct scene_at item = scene_at_item(shapes, i);
        struct scene_at type;
        count += scene_at_member(&item, "type", &type) && scene_at_type(&type) == SCENE_STRING &&
                 !strcmp(scene_at_string(&type), shape_names[SHAPE_MESH]);
    }
    return count;
}

void scene_read_shapes(struct scene_doc *doc, const struct scene_at *at,
                       const struct scene_known *names, struct scene *scene)
{
    if (!scene_doc_array(doc, at, "shapes", 0, SCENE_MAX_SHAPES))
        return;
    const size_t count = scene_at_count(at);
    scene->shapes = arena_new(doc->arena, struct shape, count);
    scene->meshes = arena_new(doc->arena, struct mesh, mesh_count(at));
    scene->shape_count = (uint32_t)count;
    for (size_t i = 0; i < count; i++) {
        const struct scene_at item = scene_at_item(at, i);
        read_shape(doc, &item, names, scene, &scene->shapes[i]);
    }
    unite_meshes(scene, doc->arena);
}
