/* SPDX-License-Identifier: MIT */
#include "common/scene_relief.h"

static const struct scene_range strength_range = {0, 1e6, false};
static const struct scene_range height_range = {-1e6, 1e6, false};

/* An image has neighbours to compare with, and the directions of its sides; a checker has steps. */
static bool read_texture(const struct scene_params *p, const struct scene_at *value,
                         uint32_t *texture)
{
    struct scene_at name;
    if (!scene_at_member(value, "texture", &name) ||
        !scene_names_find(p->doc, &name, p->textures, texture))
        return false;
    return p->scene->textures[*texture].kind == TEXTURE_IMAGE ||
           scene_doc_expected(p->doc, &name, ERR_INPUT, "a texture of the type \"image\"");
}

static bool read_normal_map(const struct scene_params *p, const struct scene_at *value,
                            struct material_relief *r)
{
    static const struct scene_key keys[] = {{"texture", true}, {"scale", false}};
    double scale = 1;
    bool good = scene_doc_object(p->doc, value, "a normal map", keys, countof(keys));
    good &= scene_key_number(p->doc, value, "scale", strength_range, &scale);
    good &= read_texture(p, value, &r->normal_map);
    r->strength = (float)scale;
    struct scene_at name;
    if (good && p->scene->textures[r->normal_map].image.space != TEXTURE_LINEAR &&
        scene_at_member(value, "texture", &name))
        good = scene_doc_expected(p->doc, &name, ERR_INPUT,
                                  "a texture with \"color_space\": \"linear\": normals are no "
                                  "colors");
    return good;
}

static bool read_bump(const struct scene_params *p, const struct scene_at *value,
                      struct material_relief *r)
{
    static const struct scene_key keys[] = {
        {"texture", true}, {"scale", false}, {"channel", false}};
    double scale = 1;
    bool good = scene_doc_object(p->doc, value, "a bump", keys, countof(keys));
    good &= scene_key_number(p->doc, value, "scale", height_range, &scale);
    good &= scene_param_channel(p, value, &r->channel);
    good &= read_texture(p, value, &r->bump);
    r->height = (float)scale;
    return good;
}

static void add(const struct scene_params *p, const struct material_relief *r)
{
    struct scene *scene = p->scene;
    scene->reliefs =
        arena_grow(p->doc->arena, scene->reliefs, scene->relief_count, sizeof *scene->reliefs);
    scene->reliefs[scene->relief_count++] = *r;
}

void scene_relief_read(const struct scene_params *p, struct material *m)
{
    struct material_relief r = {.normal_map = SCENE_NO_TEXTURE, .bump = SCENE_NO_TEXTURE};
    struct scene_at map, bump;
    const bool has_map = scene_at_member(p->at, "normal_map", &map);
    const bool has_bump = scene_at_member(p->at, "bump", &bump);
    bool good = has_map || has_bump;
    good &= !has_map || read_normal_map(p, &map, &r);
    good &= !has_bump || read_bump(p, &bump, &r);
    if (!good)
        return;
    add(p, &r);
    m->relief = p->scene->relief_count;
    m->needs |= MATERIAL_NEEDS_UV;
}
