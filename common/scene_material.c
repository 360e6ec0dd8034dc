/* Materials and lights.
 * SPDX-License-Identifier: MIT */
#include "common/scene_read.h"

#include <stdlib.h>
#include <string.h>

#include "common/scene_check.h"

static const struct scene_range fraction = {0, 1, false};
static const struct scene_range brightness = {0, SCENE_MAX_ABS, false};
static const struct scene_range coordinate = {-SCENE_MAX_ABS, SCENE_MAX_ABS, false};

static void read_diffuse(struct scene_doc *doc, const struct scene_at *at, struct material *m)
{
    static const struct scene_key keys[] = {{"type", true}, {"albedo", true}};
    scene_doc_object(doc, at, "a diffuse material", keys, countof(keys));
    scene_key_rgb(doc, at, "albedo", fraction, &m->diffuse.albedo);
}

static void read_mirror(struct scene_doc *doc, const struct scene_at *at, struct material *m)
{
    static const struct scene_key keys[] = {{"type", true}, {"reflectance", false}};
    m->mirror.reflectance = rgb_gray(1);
    scene_doc_object(doc, at, "a mirror material", keys, countof(keys));
    scene_key_rgb(doc, at, "reflectance", fraction, &m->mirror.reflectance);
}

static void read_dielectric(struct scene_doc *doc, const struct scene_at *at, struct material *m)
{
    static const struct scene_key keys[] = {{"type", true}, {"ior", true}, {"alpha", false}};
    double ior = 1, alpha = 0;
    scene_doc_object(doc, at, "a dielectric material", keys, countof(keys));
    scene_key_number(doc, at, "ior", (struct scene_range){1, 4, false}, &ior);
    scene_key_number(doc, at, "alpha", fraction, &alpha);
    m->dielectric.ior = (float)ior;
    m->dielectric.alpha = (float)alpha;
}

static void read_conductor(struct scene_doc *doc, const struct scene_at *at, struct material *m)
{
    static const struct scene_key keys[] = {
        {"type", true}, {"eta", true}, {"k", true}, {"alpha", true}};
    double alpha = 0;
    scene_doc_object(doc, at, "a conductor material", keys, countof(keys));
    scene_key_rgb(doc, at, "eta", (struct scene_range){1e-3, 100, false}, &m->conductor.eta);
    scene_key_rgb(doc, at, "k", (struct scene_range){0, 100, false}, &m->conductor.k);
    scene_key_number(doc, at, "alpha", fraction, &alpha);
    m->conductor.alpha = (float)alpha;
}

static const char *const material_names[] = {
    [MATERIAL_DIFFUSE] = "diffuse",
    [MATERIAL_MIRROR] = "mirror",
    [MATERIAL_DIELECTRIC] = "dielectric",
    [MATERIAL_CONDUCTOR] = "conductor",
};

static void read_material(struct scene_doc *doc, const struct scene_at *at, struct material *m)
{
    m->name = arena_strdup(doc->arena, at->key);
    const size_t length = strlen(at->key);
    if (length < 1 || length > SCENE_MAX_NAME)
        scene_doc_fault(doc, at, length ? ERR_LIMIT : ERR_INPUT,
                        "expected a material name of 1 to %d bytes, got %zu", SCENE_MAX_NAME,
                        length);
    for (const char *c = at->key; *c; c++)
        if ((unsigned char)*c < 0x20 || *c == 0x7f) {
            scene_doc_fault(doc, at, ERR_INPUT,
                            "expected a material name without control characters");
            break;
        }
    size_t kind;
    if (!scene_doc_kind(doc, at, "a material", material_names, countof(material_names), &kind))
        return;
    m->kind = (enum material_kind)kind;
    switch (m->kind) {
    case MATERIAL_DIFFUSE:
        read_diffuse(doc, at, m);
        return;
    case MATERIAL_MIRROR:
        read_mirror(doc, at, m);
        return;
    case MATERIAL_DIELECTRIC:
        read_dielectric(doc, at, m);
        return;
    case MATERIAL_CONDUCTOR:
        read_conductor(doc, at, m);
        return;
    }
}

static int name_compare(const void *a, const void *b)
{
    return strcmp(((const struct scene_name *)a)->name, ((const struct scene_name *)b)->name);
}

struct scene_names scene_read_materials(struct scene_doc *doc, const struct scene_at *at,
                                        struct scene *scene)
{
    if (scene_at_type(at) != SCENE_OBJECT) {
        scene_doc_expected(doc, at, ERR_INPUT, "an object of materials by name");
        return (struct scene_names){0};
    }
    const size_t count = scene_at_count(at);
    if (count > SCENE_MAX_MATERIALS) {
        scene_doc_fault(doc, at, ERR_LIMIT, "expected at most %d materials, got %zu",
                        SCENE_MAX_MATERIALS, count);
        return (struct scene_names){0};
    }
    scene->materials = arena_new(doc->arena, struct material, count);
    scene->material_count = (uint32_t)count;
    struct scene_names names = {.sorted = arena_new(doc->arena, struct scene_name, count),
                                .count = (uint32_t)count,
                                .known = true};
    struct scene_at member = {0};
    for (uint32_t i = 0; scene_at_next(at, &member); i++) {
        read_material(doc, &member, &scene->materials[i]);
        names.sorted[i] = (struct scene_name){scene->materials[i].name, i};
    }
    qsort(names.sorted, count, sizeof *names.sorted, name_compare);
    return names;
}

static bool read_direction(struct scene_doc *doc, const struct scene_at *at, const char *key,
                           float out[3])
{
    double v[3] = {0, 0, 1};
    if (!scene_key_numbers(doc, at, key, coordinate, v, 3))
        return false;
    const double length = scene_length(v);
    if (!(length > 0)) {
        struct scene_at member;
        return scene_at_member(at, key, &member) &&
               scene_doc_fault(doc, &member, ERR_INPUT, "expected a direction, got [0, 0, 0]");
    }
    for (int i = 0; i < 3; i++)
        out[i] = (float)(v[i] / length);
    return true;
}

static void read_light(struct scene_doc *doc, const struct scene_at *at, struct light *l)
{
    static const char *const kinds[] = {
        [LIGHT_SKY] = "sky", [LIGHT_POINT] = "point", [LIGHT_DISTANT] = "distant"};
    static const struct scene_key sky[] = {{"type", true}, {"radiance", true}};
    static const struct scene_key point[] = {
        {"type", true}, {"position", true}, {"intensity", true}};
    static const struct scene_key distant[] = {
        {"type", true}, {"direction", true}, {"irradiance", true}};
    size_t kind;
    double p[3] = {0};
    if (!scene_doc_kind(doc, at, "a light", kinds, countof(kinds), &kind))
        return;
    l->kind = (enum light_kind)kind;
    switch (l->kind) {
    case LIGHT_SKY:
        scene_doc_object(doc, at, "a sky light", sky, countof(sky));
        scene_key_rgb(doc, at, "radiance", brightness, &l->sky.radiance);
        return;
    case LIGHT_POINT:
        scene_doc_object(doc, at, "a point light", point, countof(point));
        scene_key_numbers(doc, at, "position", coordinate, p, 3);
        for (int i = 0; i < 3; i++)
            l->point.position[i] = (float)p[i];
        scene_key_rgb(doc, at, "intensity", brightness, &l->point.intensity);
        return;
    case LIGHT_DISTANT:
        scene_doc_object(doc, at, "a distant light", distant, countof(distant));
        read_direction(doc, at, "direction", l->distant.direction);
        scene_key_rgb(doc, at, "irradiance", brightness, &l->distant.irradiance);
        return;
    }
}

void scene_read_lights(struct scene_doc *doc, const struct scene_at *at, struct scene *scene)
{
    if (!scene_doc_array(doc, at, "lights", 0, SCENE_MAX_LIGHTS))
        return;
    const size_t count = scene_at_count(at);
    scene->lights = arena_new(doc->arena, struct light, count);
    scene->light_count = (uint32_t)count;
    for (size_t i = 0; i < count; i++) {
        const struct scene_at item = scene_at_item(at, i);
        read_light(doc, &item, &scene->lights[i]);
    }
}
