/* SPDX-License-Identifier: MIT */
#include "common/trace/texture.h"

#include "common/trace/half.h"

/* --- texels --- */

static float load_float(const unsigned char *at)
{
    float f;
    memcpy(&f, at, sizeof f);
    return f;
}

static uint16_t load_u16(const unsigned char *at)
{
    uint16_t v;
    memcpy(&v, at, sizeof v);
    return v;
}

/* Channel k of a texel. Alpha is never encoded. */
static float channel_of(const struct stage *s, const struct stage_pyramid *p,
                        enum stage_texels texels, const unsigned char *at, uint32_t k)
{
    const struct stage_bytes *decoded = stage_at(s, s->bytes8);
    switch (texels) {
    case STAGE_TEXELS_SRGB8:
        return k == 3 || (p->channels == 2 && k == 1) ? decoded->plain[at[k]]
                                                      : decoded->srgb[at[k]];
    case STAGE_TEXELS_U8:
        return decoded->plain[at[k]];
    case STAGE_TEXELS_U16:
        return (float)load_u16(at + 2 * k) / 65535;
    case STAGE_TEXELS_HALF:
        return half_load(load_u16(at + 2 * k));
    case STAGE_TEXELS_FLOAT:
        return load_float(at + 4 * k);
    }
    __builtin_unreachable();
}

vec3 texture_texel(const struct stage *s, const struct stage_pyramid *p, uint32_t level, uint32_t x,
                   uint32_t y)
{
    const enum stage_texels texels = level == 0 ? p->texels : p->coarse_texels;
    const size_t index = (size_t)y * texture_level_px(p->width_px, level) + x;
    const unsigned char *at = (const unsigned char *)stage_at(s, s->texels) + p->level_at[level] +
                              index * p->channels * stage_texel_bytes(texels);
    vec3 c = {0, 0, 0, 1};
    for (uint32_t k = 0; k < p->channels; k++)
        c[k] = channel_of(s, p, texels, at, k);
    if (p->channels <= 2)
        c = (vec3){c[0], c[0], c[0], p->channels == 2 ? c[1] : 1};
    return c;
}

/* --- wrapping --- */

/* Beyond, neighbouring floats are whole turns apart: there is no place within the image. */
#define FARTHEST 0x1p22f

static float within(float u, enum texture_wrap wrap)
{
    if (!(u > -FARTHEST && u < FARTHEST)) /* a NaN, too */
        return 0;
    switch (wrap) {
    case TEXTURE_REPEAT:
        return u - __builtin_floorf(u);
    case TEXTURE_CLAMP:
        return u < 0 ? 0 : u > 1 ? 1 : u;
    case TEXTURE_MIRROR: {
        const float turn = u - 2 * __builtin_floorf(u / 2);
        return turn > 1 ? 2 - turn : turn;
    }
    }
    __builtin_unreachable();
}

/* i is at most one beyond either edge. */
static uint32_t neighbour(int32_t i, uint32_t side_px, enum texture_wrap wrap)
{
    const int32_t last = (int32_t)side_px - 1;
    if (wrap == TEXTURE_REPEAT)
        return (uint32_t)(i < 0 ? last : i > last ? 0 : i);
    return (uint32_t)(i < 0 ? 0 : i > last ? last : i);
}

/* --- filters --- */

static vec3 mix(vec3 a, vec3 b, float t) /* a where both are the same */
{
    return a + t * (b - a);
}

static vec3 nearest(const struct stage *s, const struct stage_texture *t,
                    const struct stage_pyramid *p, float u, float v)
{
    const int32_t x = (int32_t)(u * (float)p->width_px), y = (int32_t)(v * (float)p->height_px);
    return texture_texel(s, p, 0, neighbour(x, p->width_px, t->wrap),
                         neighbour(y, p->height_px, t->wrap));
}

/* u from the left, v from the top, in [0, 1]. Texels are points in the middle of their squares. */
static vec3 bilinear(const struct stage *s, const struct stage_texture *t,
                     const struct stage_pyramid *p, uint32_t level, float u, float v)
{
    const uint32_t width = texture_level_px(p->width_px, level);
    const uint32_t height = texture_level_px(p->height_px, level);
    const float x = u * (float)width - 0.5f, y = v * (float)height - 0.5f;
    const float x_floor = __builtin_floorf(x), y_floor = __builtin_floorf(y);
    const uint32_t x0 = neighbour((int32_t)x_floor, width, t->wrap);
    const uint32_t x1 = neighbour((int32_t)x_floor + 1, width, t->wrap);
    const uint32_t y0 = neighbour((int32_t)y_floor, height, t->wrap);
    const uint32_t y1 = neighbour((int32_t)y_floor + 1, height, t->wrap);
    const vec3 top =
        mix(texture_texel(s, p, level, x0, y0), texture_texel(s, p, level, x1, y0), x - x_floor);
    const vec3 bottom =
        mix(texture_texel(s, p, level, x0, y1), texture_texel(s, p, level, x1, y1), x - x_floor);
    return mix(top, bottom, y - y_floor);
}

/* log2 of the footprint's width, in texels of level 0: its exponent, and within an octave the
 * straight line, which is off by at most .09 and needs no logarithm. */
static vec3 trilinear(const struct stage *s, const struct stage_texture *t,
                      const struct stage_pyramid *p, const float uv[2], float texels)
{
    const uint32_t last = p->level_count - 1;
    const float width = __builtin_sqrtf(texels);
    if (!(width > 1) || last == 0)
        return bilinear(s, t, p, 0, uv[0], uv[1]);
    if (width >= (float)(1u << last))
        return bilinear(s, t, p, last, uv[0], uv[1]);
    uint32_t bits;
    memcpy(&bits, &width, sizeof bits);
    const uint32_t level = (bits >> 23) - 127;
    const float along = width / (float)(1u << level) - 1;
    return mix(bilinear(s, t, p, level, uv[0], uv[1]), bilinear(s, t, p, level + 1, uv[0], uv[1]),
               along);
}

static vec3 image_at(const struct stage *s, const struct stage_texture *t,
                     const struct texture_point *at, const float uv[2])
{
    const struct stage_pyramid *p =
        (const struct stage_pyramid *)stage_at(s, s->pyramids) + t->pyramid;
    const float place[2] = {within(uv[0], t->wrap), 1 - within(uv[1], t->wrap)};
    switch (t->filter) {
    case TEXTURE_NEAREST:
        return nearest(s, t, p, place[0], place[1]);
    case TEXTURE_BILINEAR:
        return bilinear(s, t, p, 0, place[0], place[1]);
    case TEXTURE_TRILINEAR:
        return trilinear(s, t, p, place,
                         at->area * t->uv_area * (float)p->width_px * (float)p->height_px);
    }
    __builtin_unreachable();
}

/* Sampled at the point: the samples of a pixel are the filter. */
static rgb checker_at(const struct stage_texture *t, const float uv[2])
{
    const float u = within(uv[0] / 2, TEXTURE_REPEAT), v = within(uv[1] / 2, TEXTURE_REPEAT);
    return t->colors[(u >= 0.5f) != (v >= 0.5f)];
}

struct texture_value texture_at(const struct stage *s, uint32_t texture,
                                const struct texture_point *at)
{
    const struct stage_texture *t =
        (const struct stage_texture *)stage_at(s, s->textures) + texture;
    const float uv[2] = {at->u * t->uv_scale[0] + t->uv_offset[0],
                         at->v * t->uv_scale[1] + t->uv_offset[1]};
    switch (t->kind) {
    case TEXTURE_IMAGE: {
        const vec3 c = image_at(s, t, at, uv);
        return (struct texture_value){c, c[TEXTURE_ALPHA]};
    }
    case TEXTURE_CHECKER:
        return (struct texture_value){checker_at(t, uv), 1};
    case TEXTURE_VERTEX_COLOR:
        return (struct texture_value){at->color, 1};
    }
    __builtin_unreachable();
}

float texture_channel(const struct texture_value *t, enum material_channel channel)
{
    switch (channel) {
    case MATERIAL_CHANNEL_LUMINANCE:
        return rgb_luminance(t->color);
    case MATERIAL_CHANNEL_R:
        return t->color[0];
    case MATERIAL_CHANNEL_G:
        return t->color[1];
    case MATERIAL_CHANNEL_B:
        return t->color[2];
    case MATERIAL_CHANNEL_A:
        return t->alpha;
    }
    __builtin_unreachable();
}

/* Texels that the footprint is wide, of those of level 0: as trilinear looks at them. */
static float texels_wide(const struct stage_texture *t, const struct stage_pyramid *p,
                         const struct texture_point *at)
{
    const uint32_t side = p->width_px > p->height_px ? p->width_px : p->height_px;
    if (t->filter != TEXTURE_TRILINEAR)
        return 1;
    const float wide =
        __builtin_sqrtf(at->area * t->uv_area * (float)p->width_px * (float)p->height_px);
    return wide > (float)side ? (float)side : wide > 1 ? wide : 1;
}

struct texture_slope texture_slope(const struct stage *s, uint32_t texture,
                                   const struct texture_point *at, enum material_channel channel)
{
    const struct stage_texture *t =
        (const struct stage_texture *)stage_at(s, s->textures) + texture;
    const struct stage_pyramid *p =
        (const struct stage_pyramid *)stage_at(s, s->pyramids) + t->pyramid;
    const float side_px[2] = {(float)p->width_px, (float)p->height_px};
    float slope[2];
    for (int k = 0; k < 2; k++) {
        const float scale = t->uv_scale[k] < 0 ? -t->uv_scale[k] : t->uv_scale[k];
        const float half = 0.5f * texels_wide(t, p, at) / (side_px[k] * scale);
        struct texture_point before = *at, after = *at;
        *(k ? &before.v : &before.u) -= half;
        *(k ? &after.v : &after.u) += half;
        const struct texture_value a = texture_at(s, texture, &before);
        const struct texture_value b = texture_at(s, texture, &after);
        slope[k] = (texture_channel(&b, channel) - texture_channel(&a, channel)) / (2 * half);
    }
    return (struct texture_slope){slope[0], slope[1]};
}
