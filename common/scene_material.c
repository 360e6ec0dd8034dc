/* Materials.
 * SPDX-License-Identifier: MIT */
#include "common/scene_coat.h"
#include "common/scene_param.h"
#include "common/scene_read.h"
#include "common/scene_relief.h"
#include "common/scene_share.h"
#include "common/scene_wrap.h"
#include "common/scene_specular.h"

static void read_diffuse(const struct scene_params *p, struct material *m)
{
    static const struct scene_key keys[] = {{"type", true}, {"albedo", true}};
    scene_params_of(p, "a diffuse material", keys, countof(keys));
    scene_share_rgb(p, "albedo", &m->diffuse.albedo);
}

static void read_mirror(const struct scene_params *p, struct material *m)
{
    static const struct scene_key keys[] = {{"type", true}, {"reflectance", false}};
    m->mirror.reflectance = rgb_gray(1);
    scene_params_of(p, "a mirror material", keys, countof(keys));
    scene_share_rgb(p, "reflectance", &m->mirror.reflectance);
}

static const char *const material_names[] = {
    [MATERIAL_DIFFUSE] = "diffuse",
    [MATERIAL_MIRROR] = "mirror",
    [MATERIAL_DIELECTRIC] = "dielectric",
    [MATERIAL_CONDUCTOR] = "conductor",
    [MATERIAL_ROUGH_DIFFUSE] = "rough_diffuse",
    [MATERIAL_RETROREFLECTOR] = "retroreflector",
    [MATERIAL_LEAF] = "leaf",
    [MATERIAL_PLASTIC] = "plastic",
    [MATERIAL_PRINCIPLED] = "principled",
    [MATERIAL_CLOTH] = "cloth",
    [MATERIAL_MIX] = "mix",
    [MATERIAL_MASK] = "mask",
    [MATERIAL_TWO_SIDED] = "two_sided",
    [MATERIAL_PANE] = "thin_dielectric",
};
_Static_assert(countof(material_names) == MATERIAL_METAL, "kinds that have no name come last");

static void read_material(const struct scene_params *p, struct material *m)
{
    size_t kind;
    if (!scene_doc_kind(p->doc, p->at, "a material", material_names, countof(material_names),
                        &kind))
        return;
    m->kind = (enum material_kind)kind;
    switch (m->kind) {
    case MATERIAL_DIFFUSE:
        read_diffuse(p, m);
        return;
    case MATERIAL_MIRROR:
        read_mirror(p, m);
        return;
    case MATERIAL_DIELECTRIC:
        scene_specular_dielectric(p, m);
        return;
    case MATERIAL_CONDUCTOR:
        scene_specular_conductor(p, m);
        return;
    case MATERIAL_ROUGH_DIFFUSE:
        scene_coat_rough_diffuse(p, m);
        return;
    case MATERIAL_RETROREFLECTOR:
        scene_coat_retroreflector(p, m);
        return;
    case MATERIAL_LEAF:
        scene_coat_leaf(p, m);
        return;
    case MATERIAL_PLASTIC:
        scene_coat_plastic(p, m);
        return;
    case MATERIAL_PRINCIPLED:
        scene_coat_principled(p, m);
        return;
    case MATERIAL_CLOTH:
        scene_coat_cloth(p, m);
        return;
    case MATERIAL_MIX:
        scene_wrap_mix(p, m);
        return;
    case MATERIAL_MASK:
        scene_wrap_mask(p, m);
        return;
    case MATERIAL_TWO_SIDED:
        scene_wrap_two_sided(p, m);
        return;
    case MATERIAL_PANE:
        scene_specular_pane(p, m);
        return;
    case MATERIAL_METAL:
        break;
    }
}

struct scene_names scene_read_materials(struct scene_doc *doc, const struct scene_at *at,
                                        const struct scene_names *textures, struct scene *scene)
{
    struct scene_names names = {.one = "material"};
    if (!scene_names_open(doc, at, SCENE_MAX_MATERIALS, &names))
        return names;
    scene->materials = arena_new(doc->arena, struct material, names.count);
    scene->material_count = names.count;
    struct scene_at member = {0};
    for (uint32_t i = 0; scene_at_next(at, &member); i++) {
        struct material *m = &scene->materials[i];
        m->name = scene_names_take(doc, &member, &names, i);
        const uint32_t slot_begin = scene->slot_count;
        const struct scene_params params = {doc, &member, scene, textures, m};
        read_material(&params, m);
        scene_relief_read(&params, m);
        m->slot_begin = slot_begin;
        m->slot_end = scene->slot_count;
    }
    scene_names_close(&names);
    scene_wrap_bind(doc, at, &names, scene);
    return names;
}
