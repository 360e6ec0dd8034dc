/* The pyramids of the images that materials use. An image that several textures read alike is kept
 * once, and one of a single colour as one texel. What nobody uses is not kept.
 * SPDX-License-Identifier: MIT */
#include "common/trace/prep_plan.h"

#include <string.h>

#include "common/trace/camera.h"
#include "common/trace/half.h"
#include "common/trace/texture.h"

#define TEXELS_MAX_BYTES ((uint64_t)16 << 30)

struct prep_image { /* what a pyramid is made of */
    const struct image_asset *asset;
    bool encoded; /* as sRGB */
};

/* --- the plan --- */

static enum stage_texels texels_of(const struct prep_image *image)
{
    switch (image->asset->depth) {
    case IMAGE_DEPTH_U8:
        return image->encoded ? STAGE_TEXELS_SRGB8 : STAGE_TEXELS_U8;
    case IMAGE_DEPTH_U16:
        return image->encoded ? STAGE_TEXELS_HALF : STAGE_TEXELS_U16;
    case IMAGE_DEPTH_FLOAT:
        return image->asset->half ? STAGE_TEXELS_HALF : STAGE_TEXELS_FLOAT;
    }
    __builtin_unreachable();
}

/* Levels above the first hold means, which have more bits. */
static enum stage_texels coarse_texels_of(enum stage_texels texels)
{
    return texels == STAGE_TEXELS_U16 || texels == STAGE_TEXELS_FLOAT ? STAGE_TEXELS_FLOAT
                                                                      : STAGE_TEXELS_HALF;
}

static size_t asset_texel_bytes(const struct image_asset *a)
{
    static const size_t bytes[] = {
        [IMAGE_DEPTH_U8] = 1, [IMAGE_DEPTH_U16] = 2, [IMAGE_DEPTH_FLOAT] = sizeof(float)};
    return a->channels * bytes[a->depth];
}

/* Every texel is the one before it. */
static bool is_plain(const struct image_asset *a)
{
    const size_t step = asset_texel_bytes(a), all = step * a->width_px * a->height_px;
    const unsigned char *pixels = a->pixels;
    return memcmp(pixels, pixels + step, all - step) == 0;
}

static void lay_levels(struct stage_pyramid *p, uint64_t *bytes)
{
    for (uint32_t level = 0;; level++) {
        const uint64_t width = texture_level_px(p->width_px, level);
        const uint64_t height = texture_level_px(p->height_px, level);
        const enum stage_texels texels = level == 0 ? p->texels : p->coarse_texels;
        p->level_at[level] = *bytes;
        *bytes += (width * height * p->channels * stage_texel_bytes(texels) + STAGE_ALIGN - 1) /
                  STAGE_ALIGN * STAGE_ALIGN;
        if (width == 1 && height == 1) {
            p->level_count = level + 1;
            return;
        }
    }
}

static uint32_t pyramid_of(struct prep_plan *p, const struct prep_image *image)
{
    const uint32_t count = (uint32_t)p->head.pyramids.count;
    for (uint32_t i = 0; i < count; i++)
        if (p->pyramid_images[i].asset == image->asset &&
            p->pyramid_images[i].encoded == image->encoded)
            return i;
    const struct image_asset *a = image->asset;
    const bool plain = is_plain(a);
    const enum stage_texels texels = texels_of(image);
    p->pyramid_images[count] = *image;
    p->pyramids[count] = (struct stage_pyramid){
        .width_px = plain ? 1 : a->width_px,
        .height_px = plain ? 1 : a->height_px,
        .channels = a->channels,
        .texels = texels,
        .coarse_texels = coarse_texels_of(texels),
    };
    lay_levels(&p->pyramids[count], &p->head.texels.count);
    if (texels == STAGE_TEXELS_SRGB8 || texels == STAGE_TEXELS_U8)
        p->head.bytes8.count = 1;
    p->head.pyramids.count++;
    return count;
}

static struct stage_texture texture_of(struct prep_plan *p, const struct texture *t, bool used)
{
    struct stage_texture out = {.kind = t->kind, .pyramid = STAGE_NONE};
    memcpy(out.uv_scale, t->uv_scale, sizeof out.uv_scale);
    memcpy(out.uv_offset, t->uv_offset, sizeof out.uv_offset);
    const float area = t->uv_scale[0] * t->uv_scale[1];
    out.uv_area = area < 0 ? -area : area;
    switch (t->kind) {
    case TEXTURE_IMAGE: {
        const struct image_asset *a = &p->scene->images[t->image.image];
        const struct prep_image image = {a, t->image.space == TEXTURE_SRGB &&
                                                a->depth != IMAGE_DEPTH_FLOAT};
        out.wrap = t->image.wrap;
        out.filter = t->image.filter;
        if (used)
            out.pyramid = pyramid_of(p, &image);
        break;
    }
    case TEXTURE_CHECKER:
        memcpy(out.colors, t->checker.colors, sizeof out.colors);
        break;
    case TEXTURE_VERTEX_COLOR:
        break;
    }
    return out;
}

/* From the camera itself: its rays through two points half a pixel apart, about the middle. */
static void widen_cone(struct stage *head)
{
    const float x = (float)head->film.width_px / 2, y = (float)head->film.height_px / 2;
    const struct ray a = camera_ray(&head->camera, x, y);
    const struct ray b = camera_ray(&head->camera, x + 0.5f, y);
    head->cone_width = vec3_length(b.origin - a.origin);
    head->cone_spread = vec3_length(b.dir - a.dir);
}

bool prep_texture_plan(struct prep_plan *p, struct arena *scratch, struct err *err)
{
    const struct scene *scene = p->scene;
    bool *used = arena_new(scratch, bool, scene->texture_count);
    for (uint32_t i = 0; i < scene->slot_count; i++)
        used[scene->slots[i].texture] = true;
    for (uint32_t i = 0; i < scene->shape_count; i++)
        if (scene->shapes[i].glow)
            used[scene->shapes[i].glow - 1] = true;
    for (uint32_t i = 0; i < scene->relief_count; i++) {
        if (scene->reliefs[i].normal_map != SCENE_NO_TEXTURE)
            used[scene->reliefs[i].normal_map] = true;
        if (scene->reliefs[i].bump != SCENE_NO_TEXTURE)
            used[scene->reliefs[i].bump] = true;
    }
    p->textures = arena_new(scratch, struct stage_texture, scene->texture_count);
    p->pyramids = arena_new(scratch, struct stage_pyramid, scene->texture_count);
    p->pyramid_images = arena_new(scratch, struct prep_image, scene->texture_count);
    p->head.textures.count = scene->texture_count;
    p->head.slots.count = scene->slot_count;
    for (uint32_t i = 0; i < scene->texture_count; i++)
        p->textures[i] = texture_of(p, &scene->textures[i], used[i]);
    if (p->head.pyramids.count)
        widen_cone(&p->head);
    return p->head.texels.count <= TEXELS_MAX_BYTES ||
           err_set(err, ERR_LIMIT, "the textures take %llu MB, at most %llu are allowed",
                   (unsigned long long)(p->head.texels.count >> 20),
                   (unsigned long long)(TEXELS_MAX_BYTES >> 20));
}

/* --- the texels --- */

static void write_texel(unsigned char *to, enum stage_texels texels, uint32_t channels, vec3 c)
{
    if (channels == 2)
        c[1] = c[TEXTURE_ALPHA];
    for (uint32_t k = 0; k < channels; k++) {
        const float v = c[k];
        const uint16_t half = half_make(v);
        if (texels == STAGE_TEXELS_HALF)
            memcpy(to + 2 * k, &half, sizeof half);
        else
            memcpy(to + 4 * k, &v, sizeof v);
    }
}

/* Numbers of 16 bits become halves: linear ones, or floats that are halves already. */
static void write_halves(const struct prep_image *image, size_t values, unsigned char *to)
{
    const struct image_asset *a = image->asset;
    const uint32_t alpha = a->channels % 2 == 0 ? a->channels - 1 : UINT32_MAX;
    for (size_t i = 0; i < values; i++) {
        uint16_t half;
        if (a->depth == IMAGE_DEPTH_FLOAT) {
            half = half_make(((const float *)a->pixels)[i]);
        } else {
            const double v = ((const uint16_t *)a->pixels)[i] / 65535.;
            half = half_make((float)(i % a->channels == alpha ? v : srgb_linear(v)));
        }
        memcpy(to + 2 * i, &half, sizeof half);
    }
}

static void write_finest(const struct prep_image *image, const struct stage_pyramid *p,
                         unsigned char *to)
{
    const size_t values = (size_t)p->width_px * p->height_px * p->channels;
    if (p->texels == STAGE_TEXELS_HALF)
        write_halves(image, values, to);
    else
        memcpy(to, image->asset->pixels, values * stage_texel_bytes(p->texels));
}

struct reach { /* the texels of the finer level that a coarse one covers, in one direction */
    uint32_t begin, end;
    uint32_t fine, coarse; /* texels of the levels */
    uint32_t at;
};

static struct reach reach_of(uint32_t at, uint32_t fine, uint32_t coarse)
{
    return (struct reach){at * fine / coarse, ((at + 1) * fine + coarse - 1) / coarse, fine, coarse,
                          at};
}

/* How much of texel i is covered; the whole of it: `coarse`. All together: `fine`. */
static uint32_t covered(const struct reach *r, uint32_t i)
{
    const uint32_t begin = max_u32(r->at * r->fine, i * r->coarse);
    return min_u32((r->at + 1) * r->fine, (i + 1) * r->coarse) - begin;
}

/* Weights are whole numbers, whose products with floats are exact in double, and so are their sums:
 * the mean of equal texels is that texel. */
static vec3 mean(const struct stage *s, const struct stage_pyramid *p, uint32_t level,
                 const struct reach *across, const struct reach *down)
{
    f64x4 sum = {0};
    for (uint32_t y = down->begin; y < down->end; y++)
        for (uint32_t x = across->begin; x < across->end; x++) {
            const double weight = (double)covered(across, x) * covered(down, y);
            sum += weight * f64x4_of(texture_texel(s, p, level - 1, x, y));
        }
    return f64x4_round(sum / ((double)across->fine * down->fine));
}

static void write_coarse(const struct stage *s, const struct stage_pyramid *p, uint32_t level,
                         unsigned char *to)
{
    const uint32_t width = texture_level_px(p->width_px, level);
    const uint32_t height = texture_level_px(p->height_px, level);
    const size_t step = p->channels * stage_texel_bytes(p->coarse_texels);
    for (uint32_t y = 0; y < height; y++) {
        const struct reach down = reach_of(y, texture_level_px(p->height_px, level - 1), height);
        for (uint32_t x = 0; x < width; x++, to += step) {
            const struct reach across =
                reach_of(x, texture_level_px(p->width_px, level - 1), width);
            write_texel(to, p->coarse_texels, p->channels, mean(s, p, level, &across, &down));
        }
    }
}

void prep_texture_write(const struct prep_plan *p, unsigned char *block)
{
    const struct stage *s = (const struct stage *)(const void *)block;
    if (s->bytes8.count) {
        struct stage_bytes *decoded = (struct stage_bytes *)(void *)(block + s->bytes8.offset);
        for (int i = 0; i < 256; i++) {
            decoded->plain[i] = (float)(i / 255.);
            decoded->srgb[i] = (float)srgb_linear(i / 255.);
        }
    }
    for (uint32_t i = 0; i < s->pyramids.count; i++) {
        const struct stage_pyramid *pyramid = &p->pyramids[i];
        unsigned char *texels = block + s->texels.offset;
        write_finest(&p->pyramid_images[i], pyramid, texels + pyramid->level_at[0]);
        for (uint32_t level = 1; level < pyramid->level_count; level++)
            write_coarse(s, pyramid, level, texels + pyramid->level_at[level]);
    }
}
