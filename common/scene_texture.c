/* Textures.
 * SPDX-License-Identifier: MIT */
#include "common/scene_read.h"

static const struct scene_range uv_range = {-1e6, 1e6, false};

#define UV_KEYS                                                                                    \
    {"uv_scale", false},                                                                           \
    {                                                                                              \
        "uv_offset", false                                                                         \
    }

static void read_scale(struct scene_doc *doc, const struct scene_at *at, double scale[2])
{
    if (scene_at_type(at) == SCENE_NUMBER) {
        if (scene_doc_number(doc, at, uv_range, &scale[0]))
            scale[1] = scale[0];
    } else if (scene_at_type(at) != SCENE_ARRAY || scene_at_count(at) != 2) {
        scene_doc_expected(doc, at, ERR_INPUT, "a number or two");
    } else {
        scene_doc_numbers(doc, at, uv_range, scale, 2);
    }
    if (scale[0] == 0 || scale[1] == 0)
        scene_doc_fault(doc, at, ERR_INPUT, "expected a scale other than 0");
}

static void read_uv(struct scene_doc *doc, const struct scene_at *at, struct texture *t)
{
    double scale[2] = {1, 1}, offset[2] = {0, 0};
    struct scene_at member;
    if (scene_at_member(at, "uv_scale", &member))
        read_scale(doc, &member, scale);
    scene_key_numbers(doc, at, "uv_offset", uv_range, offset, 2);
    for (int i = 0; i < 2; i++) {
        t->uv_scale[i] = (float)scale[i];
        t->uv_offset[i] = (float)offset[i];
    }
}

static void read_space(struct scene_doc *doc, const struct scene_at *at, bool is_linear,
                       struct texture *t)
{
    static const char *const names[] = {[TEXTURE_SRGB] = "srgb", [TEXTURE_LINEAR] = "linear"};
    size_t space;
    struct scene_at member;
    t->image.space = is_linear ? TEXTURE_LINEAR : TEXTURE_SRGB;
    if (!scene_at_member(at, "color_space", &member) ||
        !scene_doc_choice(doc, &member, names, countof(names), &space))
        return;
    if (is_linear && space != TEXTURE_LINEAR)
        scene_doc_expected(doc, &member, ERR_INPUT, "\"linear\": OpenEXR files are");
    t->image.space = (enum texture_space)space;
}

static void read_image(struct scene_doc *doc, const struct scene_at *at, struct scene *scene,
                       struct texture *t)
{
    static const char *const wraps[] = {
        [TEXTURE_REPEAT] = "repeat", [TEXTURE_CLAMP] = "clamp", [TEXTURE_MIRROR] = "mirror"};
    static const char *const filters[] = {[TEXTURE_TRILINEAR] = "trilinear",
                                          [TEXTURE_BILINEAR] = "bilinear",
                                          [TEXTURE_NEAREST] = "nearest"};
    static const struct scene_key keys[] = {
        {"type", true},         {"file", false}, {"asset", false},  {"format", false},
        {"color_space", false}, {"wrap", false}, {"filter", false}, UV_KEYS};
    size_t wrap = TEXTURE_REPEAT, filter = TEXTURE_TRILINEAR;
    struct scene_at member;
    scene_doc_object(doc, at, "an image texture", keys, countof(keys));
    read_uv(doc, at, t);
    const bool named = scene_read_image(doc, at, "an image texture", scene, &t->image.image);
    read_space(doc, at, named && scene->images[t->image.image].format == IMAGE_FORMAT_EXR, t);
    if (scene_at_member(at, "wrap", &member))
        scene_doc_choice(doc, &member, wraps, countof(wraps), &wrap);
    if (scene_at_member(at, "filter", &member))
        scene_doc_choice(doc, &member, filters, countof(filters), &filter);
    t->image.wrap = (enum texture_wrap)wrap;
    t->image.filter = (enum texture_filter)filter;
}

static void read_checker(struct scene_doc *doc, const struct scene_at *at, struct texture *t)
{
    static const struct scene_key keys[] = {{"type", true}, {"colors", true}, UV_KEYS};
    static const struct scene_range range = {0, 1e18, false};
    struct scene_at colors;
    scene_doc_object(doc, at, "a checker texture", keys, countof(keys));
    read_uv(doc, at, t);
    if (!scene_at_member(at, "colors", &colors))
        return;
    if (scene_at_type(&colors) != SCENE_ARRAY || scene_at_count(&colors) != 2) {
        scene_doc_expected(doc, &colors, ERR_INPUT, "an array of 2 colors");
        return;
    }
    for (size_t i = 0; i < 2; i++) {
        const struct scene_at color = scene_at_item(&colors, i);
        scene_doc_rgb(doc, &color, range, &t->checker.colors[i]);
    }
}

static void read_vertex_color(struct scene_doc *doc, const struct scene_at *at, struct texture *t)
{
    static const struct scene_key keys[] = {{"type", true}};
    scene_doc_object(doc, at, "a vertex color texture", keys, countof(keys));
    t->uv_scale[0] = t->uv_scale[1] = 1;
}

static void read_texture(struct scene_doc *doc, const struct scene_at *at, struct scene *scene,
                         struct texture *t)
{
    static const char *const kinds[] = {[TEXTURE_IMAGE] = "image",
                                        [TEXTURE_CHECKER] = "checker",
                                        [TEXTURE_VERTEX_COLOR] = "vertex_color"};
    size_t kind;
    if (!scene_doc_kind(doc, at, "a texture", kinds, countof(kinds), &kind))
        return;
    t->kind = (enum texture_kind)kind;
    switch (t->kind) {
    case TEXTURE_IMAGE:
        read_image(doc, at, scene, t);
        return;
    case TEXTURE_CHECKER:
        read_checker(doc, at, t);
        return;
    case TEXTURE_VERTEX_COLOR:
        read_vertex_color(doc, at, t);
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
