/* Textures.
 * SPDX-License-Identifier: MIT */
#include "common/scene_read.h"

static void read_image(struct scene_doc *doc, const struct scene_at *at, struct scene *scene,
                       struct texture *t)
{
    static const char *const spaces[] = {[TEXTURE_SRGB] = "srgb", [TEXTURE_LINEAR] = "linear"};
    static const char *const wraps[] = {
        [TEXTURE_REPEAT] = "repeat", [TEXTURE_CLAMP] = "clamp", [TEXTURE_MIRROR] = "mirror"};
    static const char *const filters[] = {[TEXTURE_TRILINEAR] = "trilinear",
                                          [TEXTURE_BILINEAR] = "bilinear",
                                          [TEXTURE_NEAREST] = "nearest"};
    static const struct scene_key keys[] = {
        {"type", true},         {"file", false}, {"asset", false}, {"format", false},
        {"color_space", false}, {"wrap", false}, {"filter", false}};
    size_t wrap = TEXTURE_REPEAT, filter = TEXTURE_TRILINEAR, space;
    struct scene_at member;
    scene_doc_object(doc, at, "an image texture", keys, countof(keys));
    const bool named = scene_read_image(doc, at, "an image texture", scene, &t->image.image);
    const bool linear = named && scene->images[t->image.image].format == IMAGE_FORMAT_EXR;
    t->image.space = linear ? TEXTURE_LINEAR : TEXTURE_SRGB;
    if (scene_at_member(at, "color_space", &member) &&
        scene_doc_choice(doc, &member, spaces, countof(spaces), &space)) {
        t->image.space = (enum texture_space)space;
        if (linear && t->image.space != TEXTURE_LINEAR)
            scene_doc_expected(doc, &member, ERR_INPUT, "\"linear\": OpenEXR files are");
    }
    if (scene_at_member(at, "wrap", &member))
        scene_doc_choice(doc, &member, wraps, countof(wraps), &wrap);
    if (scene_at_member(at, "filter", &member))
        scene_doc_choice(doc, &member, filters, countof(filters), &filter);
    t->image.wrap = (enum texture_wrap)wrap;
    t->image.filter = (enum texture_filter)filter;
}

static void read_texture(struct scene_doc *doc, const struct scene_at *at, struct scene *scene,
                         struct texture *t)
{
    static const char *const kinds[] = {[TEXTURE_IMAGE] = "image"};
    size_t kind;
    if (!scene_doc_kind(doc, at, "a texture", kinds, countof(kinds), &kind))
        return;
    t->kind = (enum texture_kind)kind;
    switch (t->kind) {
    case TEXTURE_IMAGE:
        read_image(doc, at, scene, t);
        return;
    }
}

struct scene_names scene_read_textures(struct scene_doc *doc, const struct scene_at *at,
                                       struct scene *scene)
{
    struct scene_names names = {.one = "texture"};
    if (!scene_names_open(doc, at, SCENE_MAX_TEXTURES, &names))
        return names;
    scene->textures = arena_new(doc->arena, struct texture, names.count);
    scene->texture_count = names.count;
    struct scene_at member = {0};
    for (uint32_t i = 0; scene_at_next(at, &member); i++) {
        scene->textures[i].name = scene_names_take(doc, &member, &names, i);
        read_texture(doc, &member, scene, &scene->textures[i]);
    }
    scene_names_close(&names);
    return names;
}
