/* SPDX-License-Identifier: MIT */
#include "common/film.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

void film_work_add(struct film_work *w, const struct film_work *more)
{
    w->camera_rays += more->camera_rays;
    w->bounce_rays += more->bounce_rays;
    w->shadow_rays += more->shadow_rays;
    w->plain_vertices += more->plain_vertices;
    w->other_vertices += more->other_vertices;
    w->units += more->units;
}

struct film_samples film_samples_make(struct tile_rect rect, struct tile_pass pass,
                                      struct arena *arena)
{
    assert(pass.s_begin < pass.s_end);
    return (struct film_samples){
        .rect = rect,
        .pass = pass,
        .sums = arena_new(arena, float, (size_t)tile_rect_pixels(rect) * FILM_CHANNELS),
    };
}

void film_samples_add_layers(struct film_samples *s, uint32_t layers, struct arena *arena)
{
    const size_t channels = layers_channels(layers);
    s->layers = layers;
    if (channels)
        s->layer_sums = arena_new(arena, float, tile_rect_pixels(s->rect) * channels);
}

void film_samples_note_invalid(struct film_samples *s, struct film_key key)
{
    s->invalid_count++;
    if (s->key_count < FILM_MAX_KEYS)
        s->keys[s->key_count++] = key;
}

void film_init(struct film *f, struct tile_rect window)
{
    const size_t pixels = tile_rect_pixels(window);
    *f = (struct film){
        .window = window,
        .sum = arena_malloc(pixels, 3 * sizeof *f->sum),
        .replicate = arena_malloc(pixels, FILM_CHANNELS * sizeof *f->replicate),
        .spp = arena_malloc(pixels, sizeof *f->spp),
    };
}

void film_add_layers(struct film *f, uint32_t layers)
{
    assert(!f->layers);
    f->layers = layers;
    if (layers)
        f->layer = arena_malloc(tile_rect_pixels(f->window),
                                layers_channels(layers) * sizeof *f->layer);
}

void film_release(struct film *f)
{
    free(f->layer);
    free(f->sum);
    free(f->replicate);
    free(f->spp);
    *f = (struct film){0};
}

size_t film_bytes(const struct film *f)
{
    return (size_t)tile_rect_pixels(f->window) *
           (3 * sizeof *f->sum + FILM_CHANNELS * sizeof *f->replicate + sizeof *f->spp +
            layers_channels(f->layers) * sizeof *f->layer);
}

static void merge_pixel(struct film *f, size_t at, const float *sums, struct tile_pass pass)
{
    assert(f->spp[at] == pass.s_begin);
    double total[3] = {0, 0, 0};
    for (int r = 0; r < FILM_REPLICATES; r++)
        for (int c = 0; c < 3; c++)
            total[c] += (double)sums[3 * r + c];
    for (size_t c = 0; c < 3; c++)
        f->sum[3 * at + c] += total[c];
    float *replicate = f->replicate + at * FILM_CHANNELS;
    for (int i = 0; i < FILM_CHANNELS; i++)
        replicate[i] += sums[i];
    f->spp[at] = pass.s_end;
}

static void merge_layers(double *to, const float *sums, uint32_t channels)
{
    for (uint32_t i = 0; i < channels; i++)
        to[i] += (double)sums[i];
}

static bool key_before(struct film_key a, struct film_key b)
{
    if (a.y_px != b.y_px)
        return a.y_px < b.y_px;
    if (a.x_px != b.x_px)
        return a.x_px < b.x_px;
    return a.sample < b.sample;
}

/* Insertion sort into the smallest FILM_MAX_KEYS. Tile samples are cut in the same order, so the list
 * does not depend on tile size or order of arrival. */
static void keep_key(struct film *f, struct film_key key)
{
    uint32_t at = f->key_count;
    while (at > 0 && key_before(key, f->keys[at - 1]))
        at--;
    if (at == FILM_MAX_KEYS)
        return;
    const uint32_t last = min_u32(f->key_count, FILM_MAX_KEYS - 1);
    memmove(f->keys + at + 1, f->keys + at, (last - at) * sizeof *f->keys);
    f->keys[at] = key;
    f->key_count = last + 1;
}

void film_merge(struct film *f, const struct film_samples *s)
{
    const struct tile_rect w = f->window, r = s->rect;
    assert(r.x_begin >= w.x_begin && r.x_end <= w.x_end);
    assert(r.y_begin >= w.y_begin && r.y_end <= w.y_end);
    assert(s->layers == f->layers);
    const size_t width = w.x_end - w.x_begin, channels = layers_channels(s->layers);
    const float *sums = s->sums, *layer = s->layer_sums;
    for (uint32_t y = r.y_begin; y < r.y_end; y++)
        for (uint32_t x = r.x_begin; x < r.x_end; x++, sums += FILM_CHANNELS) {
            const size_t at = (y - w.y_begin) * width + (x - w.x_begin);
            merge_pixel(f, at, sums, s->pass);
            if (!channels)
                continue;
            merge_layers(f->layer + at * channels, layer, (uint32_t)channels);
            layer += channels;
        }
    film_work_add(&f->work, &s->work);
    f->invalid_count += s->invalid_count;
    for (uint32_t i = 0; i < s->key_count; i++)
        keep_key(f, s->keys[i]);
}
