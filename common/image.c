/* SPDX-License-Identifier: MIT */
#include "common/image.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "common/estimate.h"
#include "common/evidence.h"

enum { IMAGE_CHANNELS = 10, MOST_CHANNELS = IMAGE_CHANNELS + LAYERS_MAX_CHANNELS };

/* Channels are added as they come and sorted in the end. */
struct builder {
    struct image *image;
    struct arena *arena;
    size_t pixels;
};

static void *add_channel(struct builder *b, const char *name, enum image_type type)
{
    void *data = arena_new(b->arena, uint32_t, b->pixels);
    assert(b->image->channel_count < MOST_CHANNELS);
    b->image->channels[b->image->channel_count++] = (struct image_channel){name, type, data};
    return data;
}

/* NAME.R, NAME.G, NAME.B or the like: names[i] is the last letter of the i-th. */
static void add_three(struct builder *b, const char *name, const char letters[3], float *planes[3])
{
    for (int i = 0; i < 3; i++)
        planes[i] = add_channel(
            b, arena_printf(b->arena, "%s%s%c", name, *name ? "." : "", letters[i]), IMAGE_FLOAT32);
}

static void add_image(struct builder *b, const struct film *film)
{
    float *color[3], *error[3];
    add_three(b, "", "RGB", color);
    add_three(b, "error", "RGB", error);
    float *alpha = add_channel(b, "A", IMAGE_FLOAT32);
    for (size_t i = 0; i < b->pixels; i++) {
        double mean[3], deviation[3];
        film_mean(film, i, mean);
        estimate_pixel(film, i, deviation);
        alpha[i] = 1;
        for (size_t c = 0; c < 3; c++) {
            color[c][i] = (float)mean[c];
            error[c][i] = (float)deviation[c];
        }
    }
    memcpy(add_channel(b, "samples", IMAGE_UINT32), film->spp, b->pixels * sizeof *film->spp);
}

static const char neff_name[] = "error.neff", verdict_name[] = "error.verdict";

static void add_evidence(struct builder *b, const struct film *film)
{
    const struct evidence e = evidence_make(film, b->arena);
    const struct tile_rect w = film->window;
    float *neff = add_channel(b, neff_name, IMAGE_FLOAT32);
    uint32_t *verdict = add_channel(b, verdict_name, IMAGE_UINT32);
    for (uint32_t y = 0; y < w.y_end - w.y_begin; y++)
        for (uint32_t x = 0; x < w.x_end - w.x_begin; x++) {
            const struct evidence_block *at =
                &e.blocks[(size_t)(y / BLOCK_PX) * e.columns + x / BLOCK_PX];
            *neff++ = at->neff;
            *verdict++ = at->verdict;
        }
}

/* ---- layers ---- */

static const double *layer_of(const struct film *f, size_t pixel)
{
    return f->layer + pixel * layers_channels(f->layers);
}

static double samples_of(const struct film *f, size_t pixel)
{
    return f->spp[pixel] ? f->spp[pixel] : 1;
}

/* Three channels from `at` on, as means over all samples. */
static void add_means(struct builder *b, const struct film *f, const char *name,
                      const char letters[3], uint32_t at)
{
    float *planes[3];
    add_three(b, name, letters, planes);
    for (size_t i = 0; i < b->pixels; i++)
        for (uint32_t c = 0; c < 3; c++)
            planes[c][i] = (float)(layer_of(f, i)[at + c] / samples_of(f, i));
}

/* Over those that met a surface: x / 0 would be no number. */
static float mean_of_hits(const struct film *f, size_t pixel, uint32_t at)
{
    const double *layer = layer_of(f, pixel);
    return layer[0] > 0 ? (float)(layer[at] / layer[0]) : INFINITY;
}

static void add_surface(struct builder *b, const struct film *f)
{
    const uint32_t layers = f->layers;
    if (layers & LAYER_ALBEDO)
        add_means(b, f, "albedo", "RGB", layers_at(layers, LAYER_ALBEDO));
    if (layers & LAYER_NORMAL)
        add_means(b, f, "normal", "XYZ", layers_at(layers, LAYER_NORMAL));
    if (layers & LAYER_DEPTH) {
        float *depth = add_channel(b, "Z", IMAGE_FLOAT32);
        for (size_t i = 0; i < b->pixels; i++)
            depth[i] = mean_of_hits(f, i, layers_at(layers, LAYER_DEPTH));
    }
    if (layers & LAYER_POSITION) {
        float *planes[3];
        add_three(b, "position", "XYZ", planes);
        for (size_t i = 0; i < b->pixels; i++)
            for (uint32_t c = 0; c < 3; c++)
                planes[c][i] = mean_of_hits(f, i, layers_at(layers, LAYER_POSITION) + c);
    }
    if (layers & LAYER_MATERIAL) {
        uint32_t *material = add_channel(b, "material", IMAGE_UINT32);
        for (size_t i = 0; i < b->pixels; i++)
            material[i] = (uint32_t)layer_of(f, i)[layers_at(layers, LAYER_MATERIAL)];
    }
}

static void add_bounces(struct builder *b, const struct film *f)
{
    const uint32_t bounces = layers_bounces(f->layers), at = layers_bounces_at(f->layers);
    for (uint32_t k = 0; k < bounces; k++)
        add_means(b, f, arena_printf(b->arena, "bounce%u", k), "RGB", at + 3 * k);
    if (bounces)
        add_means(b, f, "rest", "RGB", at + 3 * bounces);
}

static int by_name(const void *a, const void *b)
{
    return strcmp(((const struct image_channel *)a)->name, ((const struct image_channel *)b)->name);
}

struct image image_from_film(const struct film *film, uint32_t width_px, uint32_t height_px,
                             struct arena *arena)
{
    struct image image = {
        .window = film->window,
        .width_px = width_px,
        .height_px = height_px,
        .channels = arena_new(arena, struct image_channel, MOST_CHANNELS),
    };
    struct builder b = {&image, arena, tile_rect_pixels(film->window)};
    add_image(&b, film);
    add_evidence(&b, film);
    add_surface(&b, film);
    add_bounces(&b, film);
    qsort(image.channels, image.channel_count, sizeof *image.channels, by_name);
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

_Static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__,
               "pixels are hashed as they lie in memory");

static bool is_hashed(const struct image_channel *c)
{
    return strcmp(c->name, neff_name) != 0 && strcmp(c->name, verdict_name) != 0;
}

void image_digest(const struct image *image, char hex[HASH_HEX])
{
    struct hash *h = hash_new();
    for (size_t c = 0; c < image->channel_count; c++) {
        if (!is_hashed(&image->channels[c]))
            continue;
        hash_add(h, image->channels[c].name, strlen(image->channels[c].name) + 1);
        add_u32(h, image->channels[c].type);
    }
    add_u32(h, image->window.x_end - image->window.x_begin);
    add_u32(h, image->window.y_end - image->window.y_begin);
    for (size_t c = 0; c < image->channel_count; c++)
        if (is_hashed(&image->channels[c]))
            hash_add(h, image->channels[c].pixels, (size_t)tile_rect_pixels(image->window) * 4);
    hash_finish(h, hex);
}
