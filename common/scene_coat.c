/* SPDX-License-Identifier: MIT */
#include "common/scene_coat.h"

#include "common/scene_share.h"

static const struct scene_range fraction = {0, 1, false};
static const struct scene_range fibres = {0.1, 1, false};
static const struct scene_range coat_ior = {1.1, 3, false};

void scene_coat_rough_diffuse(const struct scene_params *p, struct material *m)
{
    static const struct scene_key keys[] = {{"type", true}, {"albedo", true}, {"roughness", true}};
    scene_params_of(p, "a rough diffuse material", keys, countof(keys));
    scene_share_rgb(p, "albedo", &m->rough_diffuse.albedo);
    scene_param_number(p, "roughness", fraction, &m->rough_diffuse.roughness);
}

void scene_coat_retroreflector(const struct scene_params *p, struct material *m)
{
    static const struct scene_key keys[] = {
        {"type", true}, {"reflectance", false}, {"alpha", true}};
    m->retro.reflectance = rgb_gray(1);
    scene_params_of(p, "a retroreflector", keys, countof(keys));
    scene_share_rgb(p, "reflectance", &m->retro.reflectance);
    scene_param_number(p, "alpha", fraction, &m->retro.alpha);
}

void scene_coat_leaf(const struct scene_params *p, struct material *m)
{
    static const struct scene_key keys[] = {
        {"type", true}, {"reflectance", true}, {"transmittance", true}};
    scene_params_of(p, "a leaf", keys, countof(keys));
    scene_share_pair(p, (struct scene_share){"reflectance", &m->leaf.reflectance},
                     (struct scene_share){"transmittance", &m->leaf.transmittance});
}

void scene_coat_plastic(const struct scene_params *p, struct material *m)
{
    static const struct scene_key keys[] = {
        {"type", true}, {"albedo", true}, {"ior", false}, {"alpha", false}};
    m->plastic.ior = 1.5f;
    scene_params_of(p, "a plastic", keys, countof(keys));
    scene_share_rgb(p, "albedo", &m->plastic.albedo);
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
    scene_share_rgb(p, "albedo", &m->cloth.albedo);
    scene_share_rgb(p, "color", &m->cloth.color);
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
    scene_share_rgb(p, "base_color", &m->principled.base_color);
    scene_param_number(p, "metallic", fraction, &m->principled.metallic);
    scene_param_number(p, "roughness", fraction, &m->principled.roughness);
    scene_param_number(p, "ior", coat_ior, &m->principled.ior);
    scene_param_number(p, "transmission", fraction, &m->principled.transmission);
    scene_param_number(p, "clearcoat", fraction, &m->principled.clearcoat);
    scene_param_number(p, "clearcoat_roughness", fraction, &m->principled.clearcoat_roughness);
    scene_share_rgb(p, "sheen_color", &m->principled.sheen_color);
    scene_param_number(p, "sheen_roughness", fibres, &m->principled.sheen_roughness);
}
