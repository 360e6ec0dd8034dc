/* Materials.
 * SPDX-License-Identifier: MIT */
#include "common/scene_param.h"
#include "common/scene_read.h"

#include <stdlib.h>
#include <string.h>

static const struct scene_range fraction = {0, 1, false};

static void read_diffuse(const struct scene_params *p, struct material *m)
{
    static const struct scene_key keys[] = {{"type", true}, {"albedo", true}};
    scene_params_of(p, "a diffuse material", keys, countof(keys));
    scene_param_rgb(p, "albedo", fraction, &m->diffuse.albedo);
}

static void read_mirror(const struct scene_params *p, struct material *m)
{
    static const struct scene_key keys[] = {{"type", true}, {"reflectance", false}};
    m->mirror.reflectance = rgb_gray(1);
    scene_params_of(p, "a mirror material", keys, countof(keys));
    scene_param_rgb(p, "reflectance", fraction, &m->mirror.reflectance);
}

static void read_dielectric(const struct scene_params *p, struct material *m)
{
    static const struct scene_key keys[] = {{"type", true}, {"ior", true}, {"alpha", false}};
    m->dielectric.ior = 1;
    scene_params_of(p, "a dielectric material", keys, countof(keys));
    scene_param_number(p, "ior", (struct scene_range){1, 4, false}, &m->dielectric.ior);
    scene_param_number(p, "alpha", fraction, &m->dielectric.alpha);
}

static void read_conductor(const struct scene_params *p, struct material *m)
{
    static const struct scene_key keys[] = {
        {"type", true}, {"eta", true}, {"k", true}, {"alpha", true}};
    scene_params_of(p, "a conductor material", keys, countof(keys));
    scene_param_rgb(p, "eta", (struct scene_range){1e-3, 100, false}, &m->conductor.eta);
    scene_param_rgb(p, "k", (struct scene_range){0, 100, false}, &m->conductor.k);
    scene_param_number(p, "alpha", fraction, &m->conductor.alpha);
}

static void read_rough_diffuse(const struct scene_params *p, struct material *m)
{
    static const struct scene_key keys[] = {{"type", true}, {"albedo", true}, {"roughness", true}};
    scene_params_of(p, "a rough diffuse material", keys, countof(keys));
    scene_param_rgb(p, "albedo", fraction, &m->rough_diffuse.albedo);
    scene_param_number(p, "roughness", fraction, &m->rough_diffuse.roughness);
}

static void read_retroreflector(const struct scene_params *p, struct material *m)
{
    static const struct scene_key keys[] = {
        {"type", true}, {"reflectance", false}, {"alpha", true}};
    m->retro.reflectance = rgb_gray(1);
    scene_params_of(p, "a retroreflector", keys, countof(keys));
    scene_param_rgb(p, "reflectance", fraction, &m->retro.reflectance);
    scene_param_number(p, "alpha", fraction, &m->retro.alpha);
}

static void read_leaf(const struct scene_params *p, struct material *m)
{
    static const struct scene_key keys[] = {
        {"type", true}, {"reflectance", true}, {"transmittance", true}};
    scene_params_of(p, "a leaf", keys, countof(keys));
    scene_param_rgb(p, "reflectance", fraction, &m->leaf.reflectance);
    scene_param_rgb(p, "transmittance", fraction, &m->leaf.transmittance);
    const rgb sum = m->leaf.reflectance + m->leaf.transmittance;
    if (rgb_max(sum) > 1.000001f) /* .9 + .1 is more than 1 in float */
        scene_doc_fault(p->doc, p->at, ERR_INPUT,
                        "expected reflectance + transmittance of at most 1 in every channel, got "
                        "%g, %g, %g",
                        (double)sum[0], (double)sum[1], (double)sum[2]);
}

static const char *const material_names[] = {
    [MATERIAL_DIFFUSE] = "diffuse",
    [MATERIAL_MIRROR] = "mirror",
    [MATERIAL_DIELECTRIC] = "dielectric",
    [MATERIAL_CONDUCTOR] = "conductor",
    [MATERIAL_ROUGH_DIFFUSE] = "rough_diffuse",
    [MATERIAL_RETROREFLECTOR] = "retroreflector",
    [MATERIAL_LEAF] = "leaf",
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
    const struct scene_params p = {doc, at};
    switch (m->kind) {
    case MATERIAL_DIFFUSE:
        read_diffuse(&p, m);
        return;
    case MATERIAL_MIRROR:
        read_mirror(&p, m);
        return;
    case MATERIAL_DIELECTRIC:
        read_dielectric(&p, m);
        return;
    case MATERIAL_CONDUCTOR:
        read_conductor(&p, m);
        return;
    case MATERIAL_ROUGH_DIFFUSE:
        read_rough_diffuse(&p, m);
        return;
    case MATERIAL_RETROREFLECTOR:
        read_retroreflector(&p, m);
        return;
    case MATERIAL_LEAF:
        read_leaf(&p, m);
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
