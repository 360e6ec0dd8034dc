/* SPDX-License-Identifier: MIT */
#include "common/film.h"

#include <assert.h>
#include <float.h>
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
        .blocks = arena_new(arena, struct block, block_count(rect)),
    };
}

void film_samples_add_layers(struct film_samples *s, uint32_t layers, struct arena *arena)
{
    const size_t channels = layers_channels(layers);
    s->layers = layers;
    if (channels)
        s->layer_sums = arena_new(arena, float, tile_rect_pixels(s->rect) * channels);
}

void film_samples_restrict(struct film_samples *s, const struct block_set *active)
{
    const struct block_set all = block_set_all(block_count(s->rect));
    assert(block_set_count(active) > 0 && block_set_within(active, &all));
    s->partial = !block_set_equal(active, &all);
    s->active = s->partial ? *active : (struct block_set){0};
}

bool film_samples_run(const struct film_samples *s, uint32_t y_px, uint32_t *x_begin,
                      uint32_t *x_end)
{
    const struct tile_rect r = s->rect;
    *x_end = r.x_end;
    if (!s->partial)
        return *x_begin < r.x_end;
    const uint32_t columns = block_columns(r), row = (y_px - r.y_begin) / BLOCK_PX * columns;
    uint32_t i = (*x_begin - r.x_begin + BLOCK_PX - 1) / BLOCK_PX;
    while (i < columns && !block_set_has(&s->active, row + i))
        i++;
    if (i == columns)
        return false;
    *x_begin = r.x_begin + i * BLOCK_PX;
    while (i < columns && block_set_has(&s->active, row + i))
        i++;
    *x_end = min_u32(r.x_begin + i * BLOCK_PX, r.x_end);
    return true;
}

uint32_t film_samples_pixels(const struct film_samples *s)
{
    uint32_t pixels = tile_rect_pixels(s->rect);
    for (size_t i = 0; s->partial && i < block_count(s->rect); i++)
        if (!block_set_has(&s->active, i))
            pixels -= tile_rect_pixels(block_rect_of(s->rect, i));
    return pixels;
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
        .blocks = arena_malloc(block_count(window), sizeof *f->blocks),
        .variance = arena_malloc(block_count(window), BLOCK_DOUBLINGS * sizeof *f->variance),
    };
}

void film_add_layers(struct film *f, uint32_t layers)
{
    assert(!f->layers);
    f->layers = layers;
    if (layers)
        f->layer =
            arena_malloc(tile_rect_pixels(f->window), layers_channels(layers) * sizeof *f->layer);
}

void film_release(struct film *f)
{
    free(f->layer);
    free(f->blocks);
    free(f->variance);
    free(f->sum);
    free(f->replicate);
    free(f->spp);
    *f = (struct film){0};
}

size_t film_bytes(const struct film *f)
{
    return (size_t)tile_rect_pixels(f->window) *
               (3 * sizeof *f->sum + FILM_CHANNELS * sizeof *f->replicate + sizeof *f->spp +
                layers_channels(f->layers) * sizeof *f->layer) +
           block_count(f->window) * (sizeof *f->blocks + BLOCK_DOUBLINGS * sizeof *f->variance);
}

void film_copy(struct film *to, const struct film *from)
{
    const size_t pixels = tile_rect_pixels(from->window), blocks = block_count(from->window);
    struct film copy;
    film_init(&copy, from->window);
    film_add_layers(&copy, from->layers);
    memcpy(copy.sum, from->sum, pixels * 3 * sizeof *copy.sum);
    memcpy(copy.replicate, from->replicate, pixels * FILM_CHANNELS * sizeof *copy.replicate);
    memcpy(copy.spp, from->spp, pixels * sizeof *copy.spp);
    memcpy(copy.blocks, from->blocks, blocks * sizeof *copy.blocks);
    memcpy(copy.variance, from->variance, blocks * BLOCK_DOUBLINGS * sizeof *copy.variance);
    if (from->layer)
        memcpy(copy.layer, from->layer,
               pixels * layers_channels(from->layers) * sizeof *copy.layer);
    copy.dropped = from->dropped;
    copy.work = from->work;
    copy.invalid_count = from->invalid_count;
    copy.key_count = from->key_count;
    memcpy(copy.keys, from->keys, sizeof copy.keys);
    *to = copy;
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

/* The doublings of a block's samples, 8 of each pixel being the first. */
static bool is_doubling(uint32_t spp)
{
    return spp >= FILM_REPLICATES && (spp & (spp - 1)) == 0;
}

static void merge_block(struct film *f, size_t at, const struct block *more, uint32_t spp)
{
    struct block *b = &f->blocks[at];
    block_merge(b, more);
    if (!is_doubling(spp))
        return;
    float *v = f->variance + at * BLOCK_DOUBLINGS;
    const double n = (double)tile_rect_pixels(block_rect_of(f->window, at)) * spp;
    memmove(v, v + 1, (BLOCK_DOUBLINGS - 1) * sizeof *v);
    const double now = block_variance(b, n);
    v[BLOCK_DOUBLINGS - 1] = now < (double)FLT_MAX ? (float)now : FLT_MAX;
}

static void merge_blocks(struct film *f, const struct film_samples *s)
{
    const struct tile_rect w = f->window, r = s->rect;
    const uint32_t x = r.x_begin - w.x_begin, y = r.y_begin - w.y_begin;
    assert(x % BLOCK_PX == 0 && y % BLOCK_PX == 0 && s->blocks);
    assert((r.x_end - w.x_begin) % BLOCK_PX == 0 || r.x_end == w.x_end);
    assert((r.y_end - w.y_begin) % BLOCK_PX == 0 || r.y_end == w.y_end);
    const uint32_t columns = block_columns(r), stride = block_columns(w);
    for (uint32_t j = 0; j < block_rows(r); j++)
        for (uint32_t i = 0; i < columns; i++)
            if (film_samples_has(s, (size_t)j * columns + i))
                merge_block(f, (size_t)(y / BLOCK_PX + j) * stride + x / BLOCK_PX + i,
                            &s->blocks[(size_t)j * columns + i], s->pass.s_end);
}

static bool key_before(struct film_key a, struct film_key b)
{
    if (a.y_px != b.y_px)
        return a.y_px < b.y_px;
    if (a.x_px != b.x_px)
        return a.x_px < b.x_px;
    return a.sample < b.sample;
}

/* Insertion sort into the smallest FILM_MAX_KEYS. Tile samples are cut in the same order, so the
 * list does not depend on tile size or order of arrival. */
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

/* Pixels [x_begin, x_end) of a row. */
static void merge_run(struct film *f, const struct film_samples *s, uint32_t y, uint32_t x_begin,
                      uint32_t x_end)
{
    const struct tile_rect w = f->window, r = s->rect;
    const uint32_t channels = layers_channels(s->layers);
    size_t to = (size_t)(y - w.y_begin) * (w.x_end - w.x_begin) + (x_begin - w.x_begin);
    size_t from = (size_t)(y - r.y_begin) * (r.x_end - r.x_begin) + (x_begin - r.x_begin);
    for (uint32_t x = x_begin; x < x_end; x++, to++, from++) {
        merge_pixel(f, to, s->sums + from * FILM_CHANNELS, s->pass);
        if (channels)
            merge_layers(f->layer + to * channels, s->layer_sums + from * channels, channels);
    }
}

void film_merge(struct film *f, const struct film_samples *s)
{
    const struct tile_rect w = f->window, r = s->rect;
    assert(r.x_begin >= w.x_begin && r.x_end <= w.x_end);
    assert(r.y_begin >= w.y_begin && r.y_end <= w.y_end);
    assert(s->layers == f->layers);
    for (uint32_t y = r.y_begin; y < r.y_end; y++)
        for (uint32_t x = r.x_begin, end; film_samples_run(s, y, &x, &end); x = end)
            merge_run(f, s, y, x, end);
    merge_blocks(f, s);
    film_work_add(&f->work, &s->work);
    f->dropped.degenerate = max_u32(f->dropped.degenerate, s->dropped.degenerate);
    f->dropped.nonfinite = max_u32(f->dropped.nonfinite, s->dropped.nonfinite);
    f->invalid_count += s->invalid_count;
    for (uint32_t i = 0; i < s->key_count; i++)
        keep_key(f, s->keys[i]);
}
