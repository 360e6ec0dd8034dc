/* SPDX-License-Identifier: MIT */
#include "tests/textures.h"

#include <math.h>
#include <stdlib.h>

#include "tests/dice.h"

static struct texture *add(struct scenes *s, enum texture_kind kind)
{
    struct scene *scene = &s->scene;
    if (!scene->textures)
        scene->textures = arena_new(&s->arena, struct texture, TEXTURES_MAX);
    if (scene->texture_count == TEXTURES_MAX)
        abort();
    struct texture *t = &scene->textures[scene->texture_count++];
    *t = (struct texture){.name = "t", .kind = kind, .uv_scale = {1, 1}};
    return t;
}

struct texture *textures_image(struct scenes *s, enum image_depth depth, uint32_t width_px,
                               uint32_t height_px, uint32_t channels, const void *pixels)
{
    struct scene *scene = &s->scene;
    if (!scene->images)
        scene->images = arena_new(&s->arena, struct image_asset, TEXTURES_MAX);
    struct texture *t = add(s, TEXTURE_IMAGE);
    t->image.image = scene->image_count;
    t->image.space = TEXTURE_LINEAR;
    scene->images[scene->image_count++] = (struct image_asset){.depth = depth,
                                                               .width_px = width_px,
                                                               .height_px = height_px,
                                                               .channels = channels,
                                                               .pixels = pixels};
    return t;
}

struct texture *textures_checker(struct scenes *s, rgb a, rgb b, float scale)
{
    struct texture *t = add(s, TEXTURE_CHECKER);
    t->checker.colors[0] = a;
    t->checker.colors[1] = b;
    t->uv_scale[0] = t->uv_scale[1] = scale;
    return t;
}

struct texture *textures_vertex_color(struct scenes *s)
{
    return add(s, TEXTURE_VERTEX_COLOR);
}

struct material_slot *textures_drive(struct scenes *s, const void *member, bool is_rgb,
                                     const struct texture *t)
{
    struct scene *scene = &s->scene;
    struct material *m = &scene->materials[scene->material_count - 1];
    if (!scene->slots)
        scene->slots = arena_new(&s->arena, struct material_slot, TEXTURES_MAX);
    if (scene->slot_count == TEXTURES_MAX)
        abort();
    if (m->slot_begin == m->slot_end)
        m->slot_begin = scene->slot_count;
    m->needs |= t->kind == TEXTURE_VERTEX_COLOR ? MATERIAL_NEEDS_COLOR : MATERIAL_NEEDS_UV;
    struct material_slot *slot = &scene->slots[scene->slot_count++];
    *slot = (struct material_slot){
        .texture = textures_index(s, t),
        .member = (uint32_t)((const char *)member - (const char *)m),
        .is_rgb = is_rgb,
        .hi = 1,
        .scale = {1, 1, 1},
    };
    m->slot_end = scene->slot_count;
    return slot;
}

struct material_relief *textures_relief(struct scenes *s, uint32_t material)
{
    struct scene *scene = &s->scene;
    struct material *m = &scene->materials[material];
    if (!scene->reliefs)
        scene->reliefs = arena_new(&s->arena, struct material_relief, TEXTURES_MAX);
    if (!m->relief) {
        if (scene->relief_count == TEXTURES_MAX)
            abort();
        scene->reliefs[scene->relief_count++] = (struct material_relief){
            .normal_map = SCENE_NO_TEXTURE, .strength = 1, .bump = SCENE_NO_TEXTURE, .height = 1};
        m->relief = scene->relief_count;
        m->needs |= MATERIAL_NEEDS_UV;
    }
    return &scene->reliefs[m->relief - 1];
}

/* As a map holds it. */
static void store_normal(float *pixel, vec3 n)
{
    vec3_store(pixel, 0.5f * n + vec3_make(0.5f, 0.5f, 0.5f));
}

struct texture *textures_normal(struct scenes *s, vec3 normal)
{
    float *pixel = arena_new(&s->arena, float, 3);
    store_normal(pixel, normal);
    return textures_image(s, IMAGE_DEPTH_FLOAT, 1, 1, 3, pixel);
}

struct texture *textures_tilted(struct scenes *s, double angle_rad)
{
    enum { WIDTH = 16, HEIGHT = 8 };
    struct dice d = dice_make(9);
    float *pixels = arena_new(&s->arena, float, 3 * WIDTH * HEIGHT);
    for (size_t i = 0; i < (size_t)WIDTH * HEIGHT; i++) {
        const double turn = dice_range(&d, 0, 6.283185307179586);
        store_normal(pixels + 3 * i,
                     vec3_make((float)(sin(angle_rad) * cos(turn)),
                               (float)(sin(angle_rad) * sin(turn)), (float)cos(angle_rad)));
    }
    struct texture *t = textures_image(s, IMAGE_DEPTH_FLOAT, WIDTH, HEIGHT, 3, pixels);
    t->image.filter = TEXTURE_NEAREST;
    return t;
}

uint32_t textures_index(const struct scenes *s, const struct texture *t)
{
    return (uint32_t)(t - s->scene.textures);
}
