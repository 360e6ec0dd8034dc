/* Pilots: what methods make of the same few pixels, by their own samples. Blocks of 2 x 2 pixels
 * here and there, so that what errors are relative to is a mean of four.
 * SPDX-License-Identifier: MIT */
#include <string.h>

#include "common/trace/fmath.h"
#include "common/trace/render.h"
#include "common/trace/study_parts.h"
#include "common/trace/work.h"

enum {
    SALT = 4,
    BLOCK = 2,
    ROUGH_SPP = 8,
    FIRST_SPP = 16, /* of a pilot: where its slope begins */
    TAIL_PART = 50, /* one in so many pixels is of the tail */
    MOST_TAIL = 128,
    THIN = 3, /* of eight replicates, so few have found the light */
};

#define FLOOR 0.01 /* of the mean: relative to less than that no error counts (estimate.h) */

struct pixel {
    double replicate[FILM_REPLICATES][3]; /* means */
    double early[3];                      /* squared error of the mean after FIRST_SPP */
    double square[3];                     /* after all */
    double mean[3];
    double scale[3]; /* what squared errors are relative to */
};

struct shot {
    struct pixel *pixels;
    uint32_t count, blocks;
    uint32_t spp;
    struct film_work work;
    const struct stage *stage;
};

static uint32_t block_side(uint32_t begin, uint32_t end)
{
    return end - begin < BLOCK ? end - begin : BLOCK;
}

static struct tile_rect square_rect(const struct stage *s, uint32_t i)
{
    const struct scene_film *f = &s->film;
    const struct study_place at = study_place(s, i, SALT);
    const uint32_t w = block_side(f->crop_x_begin, f->crop_x_end);
    const uint32_t h = block_side(f->crop_y_begin, f->crop_y_end);
    const uint32_t x = min_u32(at.x_px, f->crop_x_end - w), y = min_u32(at.y_px, f->crop_y_end - h);
    return (struct tile_rect){x, y, x + w, y + h};
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
static void take(struct pixel *to, const struct film_samples *from)
{
    const uint32_t pixels = tile_rect_pixels(from->rect);
    for (uint32_t i = 0; i < pixels; i++)
        for (uint32_t r = 0; r < FILM_REPLICATES; r++)
            for (uint32_t c = 0; c < 3; c++)
                to[i].replicate[r][c] += (double)from->sums[i * FILM_CHANNELS + 3 * r + c];
}

static void render(const struct stage *s, struct film_samples *samples, struct tile_pass pass,
                   struct pixel *to)
{
    const size_t floats = (size_t)tile_rect_pixels(samples->rect) * FILM_CHANNELS;
    samples->pass = pass;
    memset(samples->sums, 0, floats * sizeof *samples->sums);
    render_tile(s, samples);
    take(to, samples);
}

static void shoot_block(struct shot *shot, struct film_samples *samples, uint32_t block)
{
    samples->rect = square_rect(shot->stage, block);
    const uint32_t pixels = tile_rect_pixels(samples->rect);
    struct pixel *to = shot->pixels + shot->count;
    memset(to, 0, pixels * sizeof *to);
    const uint32_t first = min_u32(FIRST_SPP, shot->spp);
    render(shot->stage, samples, (struct tile_pass){0, first}, to);
    for (uint32_t i = 0; i < pixels; i++)
        judge(to[i].replicate, first, to[i].early, to[i].mean);
    if (first < shot->spp)
        render(shot->stage, samples, (struct tile_pass){first, shot->spp}, to);
    for (uint32_t i = 0; i < pixels; i++) {
        judge(to[i].replicate, shot->spp, to[i].square, to[i].mean);
        for (int r = 0; r < FILM_REPLICATES; r++)
            for (int c = 0; c < 3; c++)
                to[i].replicate[r][c] *= (double)FILM_REPLICATES / shot->spp;
    }
    shot->count += pixels;
}

static bool shoot(const struct study *t, const struct stage *s, struct shot *shot,
                  struct arena *arena)
{
    const struct tile_rect most = {0, 0, BLOCK, BLOCK};
    struct film_samples samples = film_samples_make(most, (struct tile_pass){0, 1}, arena);
    shot->stage = s;
    shot->count = 0;
    if (!shot->pixels)
        shot->pixels = arena_new(arena, struct pixel, (size_t)shot->blocks * BLOCK * BLOCK);
    for (uint32_t i = 0; i < shot->blocks; i++) {
        if (study_is_halted(t))
            return false;
        shoot_block(shot, &samples, i);
    }
    shot->work = samples.work;
    return true;
}

/* --- what it says --- */

/* Blocks have the same pixels in both shots. */
static void set_scales(struct shot *shot)
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

static bool is_thin(const struct pixel *p)
{
    double sum = 0, square = 0;
    for (int r = 0; r < FILM_REPLICATES; r++) {
        const double light = p->replicate[r][0] + p->replicate[r][1] + p->replicate[r][2];
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
    if (!(early > 0) || !(late > 0) || spp <= FIRST_SPP)
        return -1;
    const double slope = fmath_log2(late / early) / fmath_log2((double)spp / FIRST_SPP);
    return slope > -1 ? -1 : slope < -1.5 ? -1.5 : slope;
}

/* Errors are relative to what `usual` has found. */
static struct plan_pilot sum_up(const struct shot *shot, const struct shot *usual)
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
        .variance = all / (3.0 * shot->count) * shot->spp,
        .slope = slope_of(early, all, shot->spp),
        .work = (double)work_units(shot->stage, &shot->work) / ((double)shot->count * shot->spp),
        .tail = all > 0 ? worst / all : 0,
        .thin = (double)thin / shot->count,
    };
}

/* The squared difference of two methods' means, less what it would be by their noise. They share
 * their random numbers, so that most of that is gone beforehand. */
static double bias_of(const struct shot *shot, const struct shot *usual)
{
    double sum = 0;
    for (uint32_t i = 0; i < shot->count; i++) {
        const struct pixel *a = &shot->pixels[i], *b = &usual->pixels[i];
        for (int c = 0; c < 3; c++) {
            double mean = 0, square = 0;
            for (int r = 0; r < FILM_REPLICATES; r++)
                mean += (a->replicate[r][c] - b->replicate[r][c]) / FILM_REPLICATES;
            for (int r = 0; r < FILM_REPLICATES; r++) {
                const double off = a->replicate[r][c] - b->replicate[r][c] - mean;
                square += off * off / (FILM_REPLICATES * (FILM_REPLICATES - 1));
            }
            sum += (mean * mean - square) / b->scale[c] / (3.0 * shot->count);
        }
    }
    return sum > 0 ? sum : 0;
}

/* Until the error is what is left of it beside the bias; a document without an error says itself
 * how many samples. */
static double spp_for(const struct plan *plan, const struct plan_pilot *p, uint32_t spp)
{
    const double left = plan->error * plan->error - p->bias;
    if (!plan->is_asked)
        return plan->spp;
    if (!(left > 0) || !(p->variance > 0))
        return left > 0 ? FILM_REPLICATES : plan->spp;
    const double doublings = fmath_log2(p->variance / spp / left) / -p->slope;
    const double n = spp * fmath_exp2(doublings < 40 ? doublings > -40 ? doublings : -40 : 40);
    return n < FILM_REPLICATES ? FILM_REPLICATES : n < plan->spp ? n : plan->spp;
}

/* --- the candidates --- */

static bool rough(struct study *t, struct arena *arena)
{
    struct shot shot = {.blocks = t->places / 4, .spp = ROUGH_SPP};
    if (!shoot(t, t->stage, &shot, arena))
        return false;
    set_scales(&shot);
    const struct plan_pilot p = sum_up(&shot, &shot);
    t->plan->rough_variance = p.variance;
    t->plan->rough_work = p.work;
    t->plan->rough_spp = spp_for(t->plan, &p, ROUGH_SPP);
    film_work_add(&t->work, &shot.work);
    return true;
}

static bool is_biased(enum plan_candidate_kind k)
{
    return k == PLAN_DIRECT || k == PLAN_WHITTED;
}

static bool pilot(struct study *t, struct stage *copy, enum plan_candidate_kind k,
                  struct shot *shot, const struct shot *usual, struct arena *arena)
{
    struct plan_candidate *c = &t->plan->candidates[k];
    study_set_method(copy, t->stage, plan_method_of(t->plan, k));
    if (!shoot(t, copy, shot, arena))
        return false;
    if (shot == usual)
        set_scales(shot);
    c->pilot = sum_up(shot, usual);
    c->pilot.bias = is_biased(k) ? bias_of(shot, usual) : 0;
    c->pilot.spp = spp_for(t->plan, &c->pilot, PLAN_PILOT_SPP);
    c->tried = true;
    t->plan->studied += (double)work_units(copy, &shot->work);
    return true;
}

bool study_pilots(struct study *t, struct arena *arena)
{
    struct plan *plan = t->plan;
    if (!rough(t, arena))
        return false;
    plan_consider(plan, t->stage->bytes <= STUDY_MOST_BYTES);
    if (plan->pilot_pixels == 0)
        return true;
    struct stage *copy = study_stage(t->stage, arena);
    const uint32_t blocks = plan->pilot_pixels / (BLOCK * BLOCK);
    struct shot usual = {.blocks = blocks, .spp = PLAN_PILOT_SPP}, shot = usual;
    if (!pilot(t, copy, PLAN_PATH_MIS, &usual, &usual, arena))
        return false;
    for (int k = 0; k < PLAN_REAL; k++)
        if (k != PLAN_PATH_MIS && plan_wants(plan, (enum plan_candidate_kind)k) &&
            !pilot(t, copy, (enum plan_candidate_kind)k, &shot, &usual, arena))
            return false;
    return true;
}
