/* SPDX-License-Identifier: MIT */
#include "common/trace/study_shot.h"

#include <assert.h>
#include <string.h>

#include "common/trace/fmath.h"
#include "common/trace/render.h"

enum {
    SALT = 4,
    TAIL_PART = 50, /* one in so many pixels is of the tail */
    MOST_TAIL = 128,
    THIN = 3, /* of eight replicates, so few have found the light */
};

#define FLOOR 0.01 /* of the mean: relative to less than that no error counts (estimate.h) */

static uint32_t block_side(uint32_t begin, uint32_t end)
{
    return end - begin < STUDY_BLOCK ? end - begin : STUDY_BLOCK;
}

static struct tile_rect block_rect(const struct stage *s, uint32_t i)
{
    const struct scene_film *f = &s->film;
    const struct study_place at = study_place(s, i, SALT);
    const uint32_t w = block_side(f->crop_x_begin, f->crop_x_end);
    const uint32_t h = block_side(f->crop_y_begin, f->crop_y_end);
    const uint32_t x = min_u32(at.x_px, f->crop_x_end - w), y = min_u32(at.y_px, f->crop_y_end - h);
    return (struct tile_rect){x, y, x + w, y + h};
}

void study_shot_init(struct study_shot *shot, const struct stage *s, uint32_t most_blocks,
                     struct arena *arena)
{
    const struct tile_rect most = {0, 0, STUDY_BLOCK, STUDY_BLOCK};
    *shot = (struct study_shot){
        .stage = s,
        .pixels =
            arena_new(arena, struct study_pixel, (size_t)most_blocks * STUDY_BLOCK * STUDY_BLOCK),
        .samples = film_samples_make(most, (struct tile_pass){0, 1}, arena),
    };
}

/* Squared errors of the means of sums of so many samples, by the replicates. */
static void judge(double sums[FILM_REPLICATES][3], uint32_t spp, double square[3], double mean[3])
{
    const double n = (double)spp / FILM_REPLICATES;
    for (int c = 0; c < 3; c++) {
        mean[c] = square[c] = 0;
        for (int r = 0; r < FILM_REPLICATES; r++)
            mean[c] += sums[r][c] / n / FILM_REPLICATES;
        for (int r = 0; r < FILM_REPLICATES; r++) {
            const double off = sums[r][c] / n - mean[c];
            square[c] += off * off / (FILM_REPLICATES * (FILM_REPLICATES - 1));
        }
    }
}

/* The sums of a pass onto those of the pixels of its block. */
static void take(struct study_pixel *to, const struct film_samples *from)
{
    const uint32_t pixels = tile_rect_pixels(from->rect);
    for (uint32_t i = 0; i < pixels; i++)
        for (uint32_t r = 0; r < FILM_REPLICATES; r++)
            for (uint32_t c = 0; c < 3; c++)
                to[i].sums[r][c] += (double)from->sums[i * FILM_CHANNELS + 3 * r + c];
}

static void render(struct study_shot *shot, struct tile_pass pass, struct study_pixel *to)
{
    struct film_samples *samples = &shot->samples;
    const size_t floats = (size_t)tile_rect_pixels(samples->rect) * FILM_CHANNELS;
    samples->pass = pass;
    memset(samples->sums, 0, floats * sizeof *samples->sums);
    render_tile(shot->stage, samples);
    take(to, samples);
}

/* A block from `had` samples of a pixel to spp. Returns its pixels. */
static uint32_t shoot(struct study_shot *shot, uint32_t block, uint32_t had, uint32_t spp)
{
    shot->samples.rect = block_rect(shot->stage, block);
    const uint32_t pixels = tile_rect_pixels(shot->samples.rect);
    struct study_pixel *to = shot->pixels + (size_t)block * pixels;
    if (had == 0) {
        memset(to, 0, pixels * sizeof *to);
        render(shot, (struct tile_pass){0, STUDY_FIRST_SPP}, to);
        for (uint32_t i = 0; i < pixels; i++)
            judge(to[i].sums, STUDY_FIRST_SPP, to[i].early, to[i].mean);
        had = STUDY_FIRST_SPP;
    }
    if (had < spp)
        render(shot, (struct tile_pass){had, spp}, to);
    for (uint32_t i = 0; i < pixels; i++)
        judge(to[i].sums, spp, to[i].square, to[i].mean);
    return pixels;
}

bool study_shot_go(struct study_shot *shot, const struct study *t, uint32_t blocks, uint32_t spp)
{
    assert(blocks >= shot->blocks && spp >= shot->spp && spp >= STUDY_FIRST_SPP);
    for (uint32_t i = spp > shot->spp ? 0 : shot->blocks; i < blocks; i++) {
        if (study_is_halted(t))
            return false;
        shot->count = (i + 1) * shoot(shot, i, i < shot->blocks ? shot->spp : 0, spp);
    }
    shot->blocks = blocks;
    shot->spp = spp;
    shot->work = shot->samples.work;
    return true;
}

/* --- what it says --- */

void study_shot_scale(struct study_shot *shot)
{
    double mean = 0;
    for (uint32_t i = 0; i < shot->count; i++)
        for (int c = 0; c < 3; c++)
            mean += shot->pixels[i].mean[c] / (3.0 * shot->count);
    const uint32_t block = shot->count / shot->blocks;
    for (uint32_t i = 0; i < shot->count; i++)
        for (int c = 0; c < 3; c++) {
            double y = 0;
            for (uint32_t k = 0; k < block; k++)
                y += shot->pixels[i - i % block + k].mean[c] / block;
            const double scale = y * y + FLOOR * FLOOR * mean * mean;
            shot->pixels[i].scale[c] = scale > 0 ? scale : 1; /* all is black, errors are 0 */
        }
}

static double relative(const double square[3], const double scale[3])
{
    return square[0] / scale[0] + square[1] / scale[1] + square[2] / scale[2];
}

static bool is_thin(const struct study_pixel *p)
{
    double sum = 0, square = 0;
    for (int r = 0; r < FILM_REPLICATES; r++) {
        const double light = p->sums[r][0] + p->sums[r][1] + p->sums[r][2];
        sum += light;
        square += light * light;
    }
    return square > 0 && sum * sum < THIN * square;
}

struct tail { /* the largest of many numbers, the least first */
    double largest[MOST_TAIL];
    uint32_t count, most;
};

static void tail_note(struct tail *t, double v)
{
    uint32_t at = 0;
    if (t->count == t->most) {
        if (v <= t->largest[0])
            return;
        memmove(t->largest, t->largest + 1, (t->count - 1) * sizeof v);
        t->count--;
    }
    while (at < t->count && t->largest[at] < v)
        at++;
    memmove(t->largest + at + 1, t->largest + at, (t->count - at) * sizeof v);
    t->largest[at] = v;
    t->count++;
}

static double slope_of(double early, double late, uint32_t spp)
{
    if (!(early > 0) || !(late > 0) || spp <= STUDY_FIRST_SPP)
        return PLAN_SLOPE;
    const double measured = fmath_log2(late / early) / fmath_log2((double)spp / STUDY_FIRST_SPP);
    return PLAN_SLOPE + 0.5 * (measured - PLAN_SLOPE);
}

struct plan_pilot study_shot_sum(const struct study_shot *shot, const struct study_shot *usual)
{
    double all = 0, early = 0, worst = 0;
    uint32_t thin = 0;
    struct tail tail = {.most = min_u32(shot->count / TAIL_PART + 1, MOST_TAIL)};
    for (uint32_t i = 0; i < shot->count; i++) {
        const double e = relative(shot->pixels[i].square, usual->pixels[i].scale);
        all += e;
        early += relative(shot->pixels[i].early, usual->pixels[i].scale);
        thin += is_thin(&shot->pixels[i]);
        tail_note(&tail, e);
    }
    for (uint32_t i = 0; i < tail.count; i++)
        worst += tail.largest[i];
    return (struct plan_pilot){
        .pixels = shot->count,
        .spp = shot->spp,
        .variance = all / (3.0 * shot->count) * shot->spp,
        .slope = slope_of(early, all, shot->spp),
        .work = (double)shot->work.units / ((double)shot->count * shot->spp),
        .tail = all > 0 ? worst / all : 0,
        .thin = (double)thin / shot->count,
    };
}
