/* SPDX-License-Identifier: MIT */
#include "common/image.h"

#include <string.h>

#include "common/estimate.h"

enum { CH_A, CH_B, CH_G, CH_R, CH_ERROR_B, CH_ERROR_G, CH_ERROR_R, CH_SAMPLES, CH_COUNT };

/* In strcmp order, which is also the order OpenEXR stores channels in. */
static const struct {
    const char *name;
    enum image_type type;
} layout[] = {
    [CH_A] = {"A", IMAGE_FLOAT32},
    [CH_B] = {"B", IMAGE_FLOAT32},
    [CH_G] = {"G", IMAGE_FLOAT32},
    [CH_R] = {"R", IMAGE_FLOAT32},
    [CH_ERROR_B] = {"error.B", IMAGE_FLOAT32},
    [CH_ERROR_G] = {"error.G", IMAGE_FLOAT32},
    [CH_ERROR_R] = {"error.R", IMAGE_FLOAT32},
    [CH_SAMPLES] = {"samples", IMAGE_UINT32},
};
_Static_assert(countof(layout) == CH_COUNT, "one row per channel");

struct image image_from_film(const struct film *film, uint32_t width_px, uint32_t height_px,
                             struct arena *arena)
{
    const size_t pixels = tile_rect_pixels(film->window);
    struct image image = {
        .window = film->window,
        .width_px = width_px,
        .height_px = height_px,
        .channels = arena_new(arena, struct image_channel, CH_COUNT),
        .channel_count = CH_COUNT,
    };
    float *plane[CH_COUNT] = {0};
    for (size_t c = 0; c < CH_COUNT; c++) {
        void *data = arena_new(arena, uint32_t, pixels);
        image.channels[c] = (struct image_channel){layout[c].name, layout[c].type, data};
        plane[c] = data;
    }
    for (size_t i = 0; i < pixels; i++) {
        double mean[3], error[3];
        film_mean(film, i, mean);
        estimate_pixel(film, i, error);
        plane[CH_A][i] = 1;
        for (size_t c = 0; c < 3; c++) {
            plane[CH_R - c][i] = (float)mean[c];
            plane[CH_ERROR_R - c][i] = (float)error[c];
        }
    }
    memcpy(image.channels[CH_SAMPLES].pixels, film->spp, pixels * sizeof *film->spp);
    return image;
}

const struct image_channel *image_find(const struct image *image, const char *name)
{
    for (size_t c = 0; c < image->channel_count; c++)
        if (!strcmp(image->channels[c].name, name))
            return &image->channels[c];
    return NULL;
}

static void add_u32(struct hash *h, uint32_t v)
{
    const unsigned char le[4] = {(unsigned char)v, (unsigned char)(v >> 8),
                                 (unsigned char)(v >> 16), (unsigned char)(v >> 24)};
    hash_add(h, le, sizeof le);
}

_Static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__, "pixels are hashed as they lie in memory");

void image_digest(const struct image *image, char hex[HASH_HEX])
{
    struct hash *h = hash_new();
    for (size_t c = 0; c < image->channel_count; c++) {
        hash_add(h, image->channels[c].name, strlen(image->channels[c].name) + 1);
        add_u32(h, image->channels[c].type);
    }
    add_u32(h, image->window.x_end - image->window.x_begin);
    add_u32(h, image->window.y_end - image->window.y_begin);
    for (size_t c = 0; c < image->channel_count; c++)
        hash_add(h, image->channels[c].pixels, (size_t)tile_rect_pixels(image->window) * 4);
    hash_finish(h, hex);
}
