/* Materials.
 * SPDX-License-Identifier: MIT */
#include "common/scene_param.h"
#include "common/scene_read.h"
#include "common/scene_specular.h"

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

static const char *const material_names[] = {
    [MATERIAL_DIFFUSE] = "diffuse",
    [MATERIAL_MIRROR] = "mirror",
    [MATERIAL_DIELECTRIC] = "dielectric",
    [MATERIAL_CONDUCTOR] = "conductor",
};
_Static_assert(countof(material_names) == MATERIAL_METAL, "kinds that have no name come last");

static void read_material(struct scene_doc *doc, const struct scene_at *at, struct material *m)
{
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
        scene_specular_conductor(&p, m);
        return;
    case MATERIAL_METAL:
        break;
    }
}

struct scene_names scene_read_materials(struct scene_doc *doc, const struct scene_at *at,
                                        struct scene *scene)
{
    struct scene_names names = {.one = "material"};
    if (!scene_names_open(doc, at, SCENE_MAX_MATERIALS, &names))
        return names;
    scene->materials = arena_new(doc->arena, struct material, names.count);
    scene->material_count = names.count;
    struct scene_at member = {0};
    for (uint32_t i = 0; scene_at_next(at, &member); i++) {
        scene->materials[i].name = scene_names_take(doc, &member, &names, i);
        read_material(doc, &member, &scene->materials[i]);
    }
    scene_names_close(&names);
    return names;
}
