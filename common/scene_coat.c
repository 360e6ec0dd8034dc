/* SPDX-License-Identifier: MIT */
#include "common/scene_coat.h"

static const struct scene_range fraction = {0, 1, false};
static const struct scene_range fibres = {0.1, 1, false};
static const struct scene_range coat_ior = {1.1, 3, false};

void scene_coat_rough_diffuse(const struct scene_params *p, struct material *m)
{
    static const struct scene_key keys[] = {{"type", true}, {"albedo", true}, {"roughness", true}};
    scene_params_of(p, "a rough diffuse material", keys, countof(keys));
    scene_param_rgb(p, "albedo", fraction, &m->rough_diffuse.albedo);
    scene_param_number(p, "roughness", fraction, &m->rough_diffuse.roughness);
}

void scene_coat_retroreflector(const struct scene_params *p, struct material *m)
{
    static const struct scene_key keys[] = {
        {"type", true}, {"reflectance", false}, {"alpha", true}};
    m->retro.reflectance = rgb_gray(1);
    scene_params_of(p, "a retroreflector", keys, countof(keys));
    scene_param_rgb(p, "reflectance", fraction, &m->retro.reflectance);
    scene_param_number(p, "alpha", fraction, &m->retro.alpha);
}

void scene_coat_leaf(const struct scene_params *p, struct material *m)
{
    static const struct scene_key keys[] = {
        {"type", true}, {"reflectance", true}, {"transmittance", true}};
    const uint32_t slots = p->scene->slot_count;
    scene_params_of(p, "a leaf", keys, countof(keys));
    scene_param_rgb(p, "reflectance", fraction, &m->leaf.reflectance);
    scene_param_rgb(p, "transmittance", fraction, &m->leaf.transmittance);
    const rgb sum = m->leaf.reflectance + m->leaf.transmittance;
    if (p->scene->slot_count > slots) /* what textures say is scaled down where it is used */
        return;
    if (rgb_max(sum) > 1.000001f) /* .9 + .1 is more than 1 in float */
        scene_doc_fault(p->doc, p->at, ERR_INPUT,
                        "expected reflectance + transmittance of at most 1 in every channel, got "
                        "%g, %g, %g",
                        (double)sum[0], (double)sum[1], (double)sum[2]);
}

void scene_coat_plastic(const struct scene_params *p, struct material *m)
{
    static const struct scene_key keys[] = {
        {"type", true}, {"albedo", true}, {"ior", false}, {"alpha", false}};
    m->plastic.ior = 1.5f;
    scene_params_of(p, "a plastic", keys, countof(keys));
    scene_param_rgb(p, "albedo", fraction, &m->plastic.albedo);
    scene_param_number(p, "ior", coat_ior, &m->plastic.ior);
    scene_param_number(p, "alpha", fraction, &m->plastic.alpha);
}

void scene_coat_cloth(const struct scene_params *p, struct material *m)
{
    static const struct scene_key keys[] = {
        {"type", true}, {"albedo", true}, {"color", false}, {"roughness", false}};
    m->cloth.color = rgb_gray(1);
    m->cloth.roughness = 0.3f;
    scene_params_of(p, "a cloth", keys, countof(keys));
    scene_param_rgb(p, "albedo", fraction, &m->cloth.albedo);
    scene_param_rgb(p, "color", fraction, &m->cloth.color);
    scene_param_number(p, "roughness", fibres, &m->cloth.roughness);
}

void scene_coat_principled(const struct scene_params *p, struct material *m)
{
    static const struct scene_key keys[] = {{"type", true},         {"base_color", true},
                                            {"metallic", false},    {"roughness", false},
                                            {"ior", false},         {"transmission", false},
                                            {"clearcoat", false},   {"clearcoat_roughness", false},
                                            {"sheen_color", false}, {"sheen_roughness", false}};
    m->principled.roughness = 0.5f;
    m->principled.ior = 1.5f;
    m->principled.sheen_roughness = 0.3f;
    scene_params_of(p, "a principled material", keys, countof(keys));
    scene_param_rgb(p, "base_color", fraction, &m->principled.base_color);
    scene_param_number(p, "metallic", fraction, &m->principled.metallic);
    scene_param_number(p, "roughness", fraction, &m->principled.roughness);
    scene_param_number(p, "ior", coat_ior, &m->principled.ior);
    scene_param_number(p, "transmission", fraction, &m->principled.transmission);
    scene_param_number(p, "clearcoat", fraction, &m->principled.clearcoat);
    scene_param_number(p, "clearcoat_roughness", fraction, &m->principled.clearcoat_roughness);
    scene_param_rgb(p, "sheen_color", fraction, &m->principled.sheen_color);
    scene_param_number(p, "sheen_roughness", fibres, &m->principled.sheen_roughness);
}
