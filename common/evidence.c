/* SPDX-License-Identifier: MIT */
#include "common/evidence.h"

#include <assert.h>
#include <float.h>
#include <math.h>
#include <stdlib.h>

enum {
    REGION = 8,            /* blocks along its side, or more at the window's end */
    MOST_VALUES = 256,     /* the largest of a region that are looked at */
    VALUES_A_BLOCK = 4,    /* or so many a block in small windows: */
    LEAST_VALUES = 64,     /* fewer tell nothing */
    LEAST_LARGEST = 8,     /* nor do fewer of the very largest */
    SAMPLES_A_VALUE = 256, /* of so many samples: the tail is the last 1/256 */
};

static const double growth = 1.5, outlier = .1;

/* ---- one block ---- */

static double samples_of(const struct film *f, size_t i)
{
    return (double)film_block_spp(f, i) * tile_rect_pixels(block_rect_of(f->window, i));
}

static double neff(double sum, double square)
{
    return square > 0 ? sum * (sum / square) : 0;
}

/* One sample stands out of others that are many. */
static bool has_outlier(const struct block *b, double n)
{
    const double most = (double)b->top[0], sum = b->sum - most, square = b->square - most * most;
    return n >= SAMPLES_A_VALUE && most > outlier * b->sum && neff(sum, square) >= EVIDENCE_LEAST;
}

static bool has_grown(const float v[BLOCK_DOUBLINGS])
{
    bool grown = v[0] > 0;
    for (int i = 1; i < BLOCK_DOUBLINGS; i++)
        grown = grown && (double)v[i] > growth * (double)v[i - 1];
    return grown;
}

struct evidence_block evidence_block(const struct film *f, size_t i)
{
    const struct block *b = &f->blocks[i];
    const double n = samples_of(f, i);
    if (!(b->sum > 0)) { /* black: by chance, unless there is nothing */
        const bool dark = n > 0 && b->met == 0;
        return (struct evidence_block){dark ? (float)n : 0,
                                       dark ? EVIDENCE_TRUSTED : EVIDENCE_UNKNOWN};
    }
    const double effective = neff(b->sum, b->square);
    if (has_outlier(b, n) || has_grown(f->variance + i * BLOCK_DOUBLINGS))
        return (struct evidence_block){(float)effective, EVIDENCE_HEAVY};
    return (struct evidence_block){
        (float)effective, effective >= EVIDENCE_LEAST ? EVIDENCE_TRUSTED : EVIDENCE_UNKNOWN};
}

/* ---- a region's tail ---- */

/* Natural logarithm, within 1e-10, by +, -, *, / alone: with m in [1/sqrt 2, sqrt 2) and s = (m -
 * 1) / (m + 1), log m = 2 (s + s^3 / 3 + s^5 / 5 + ...). */
static double log_of(double x)
{
    int e;
    double m = frexp(x, &e);
    if (m < 0.70710678118654752) {
        m *= 2;
        e--;
    }
    const double s = (m - 1) / (m + 1), s2 = s * s;
    double series = 0;
    for (int k = 13; k >= 1; k -= 2)
        series = series * s2 + 1.0 / k;
    return 2 * s * series + e * 0.69314718055994531;
}

static int falling(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x < y) - (x > y);
}

double evidence_hill(const double *values, size_t k)
{
    assert(k > 0 && values[k] > 0);
    double sum = 0;
    for (size_t i = 0; i < k; i++)
        sum += log_of(values[i] / values[k]);
    return sum > 0 ? (double)k / sum : (double)INFINITY;
}

/* The index of the largest k, of half of them, and so on: k / a of a power law of index a is a sum
 * of k exponentials, so that the fewer they are the further it may be off. By chance alone .5 % of
 * tails of index 1.5 are above one of these, 3 % of index 1.8. */
static bool is_heavy(const double *values, size_t k)
{
    static const double least[] = {2.2, 2.45, 2.6, 2.8, 3.5, 5.5};
    bool heavy = true;
    for (size_t i = 0; heavy && i < countof(least) && k >> i >= LEAST_LARGEST; i++)
        heavy = evidence_hill(values, k >> i) < least[i];
    return heavy;
}

struct region { /* of blocks: columns and rows, half-open */
    uint32_t x_begin, y_begin, x_end, y_end;
};

struct tail {
    const bool *among; /* [block]: of these alone; NULL: of all */
    double *values;    /* the arena's, room for BLOCK_TOP of every block of a region */
    size_t count, blocks;
    double samples;
};

/* 1 / the mean of what is not among the largest, which those would hide in; 0: that is too little
 * to know it. */
static double scale_of(const struct block *b, double n)
{
    double sum = b->sum, square = b->square;
    for (int i = 0; i < BLOCK_TOP; i++) {
        const double x = (double)b->top[i];
        sum -= x;
        square -= x * x;
    }
    return sum > 0 && neff(sum, square) >= EVIDENCE_LEAST ? n / sum : 0;
}

static void gather(const struct film *f, uint32_t columns, const struct region *r, struct tail *t)
{
    t->count = t->blocks = 0;
    t->samples = 0;
    for (uint32_t y = r->y_begin; y < r->y_end; y++)
        for (uint32_t x = r->x_begin; x < r->x_end; x++) {
            const size_t at = (size_t)y * columns + x;
            const double n = samples_of(f, at), scale = scale_of(&f->blocks[at], n);
            if (scale == 0 || (t->among && !t->among[at]))
                continue;
            t->blocks++;
            t->samples += n;
            for (int i = 0; i < BLOCK_TOP; i++) {
                const double v = (double)f->blocks[at].top[i] * scale;
                if (v > 0 && v <= DBL_MAX) /* a worker may have lied */
                    t->values[t->count++] = v;
            }
        }
}

static void flag_from(const struct film *f, struct evidence *e, const struct region *r,
                      const struct tail *t, double least)
{
    for (uint32_t y = r->y_begin; y < r->y_end; y++)
        for (uint32_t x = r->x_begin; x < r->x_end; x++) {
            const size_t at = (size_t)y * e->columns + x;
            const struct block *b = &f->blocks[at];
            if (t->among && !t->among[at])
                continue;
            if ((double)b->top[0] * scale_of(b, samples_of(f, at)) > least)
                e->blocks[at].verdict = EVIDENCE_HEAVY;
        }
}

static void judge_region(const struct film *f, struct evidence *e, const struct region *r,
                         struct tail *t)
{
    gather(f, e->columns, r, t);
    const size_t k = min_size(MOST_VALUES, VALUES_A_BLOCK * t->blocks);
    if (k < LEAST_VALUES || t->count <= k || t->samples < (double)(k * SAMPLES_A_VALUE))
        return;
    qsort(t->values, t->count, sizeof *t->values, falling);
    if (is_heavy(t->values, k))
        flag_from(f, e, r, t, t->values[k]);
}

/* Part i of so many of n blocks: REGION each, the last ones a little more. */
static uint32_t part(uint32_t i, uint32_t n)
{
    const uint32_t parts = max_u32(n / REGION, 1);
    return (uint32_t)((uint64_t)i * n / parts);
}

static void judge_regions(const struct film *f, const bool *among, struct evidence *e,
                          struct arena *arena)
{
    enum { MOST_BLOCKS = 4 * REGION * REGION };
    struct tail t = {.among = among, .values = arena_new(arena, double, MOST_BLOCKS *BLOCK_TOP)};
    for (uint32_t j = 0; j < max_u32(e->rows / REGION, 1); j++)
        for (uint32_t i = 0; i < max_u32(e->columns / REGION, 1); i++) {
            const struct region r = {part(i, e->columns), part(j, e->rows), part(i + 1, e->columns),
                                     part(j + 1, e->rows)};
            judge_region(f, e, &r, &t);
        }
}

/* ---- all ---- */

static struct evidence begin(const struct film *f, const bool *among, struct arena *arena)
{
    const size_t count = block_count(f->window);
    struct evidence e = {.columns = block_columns(f->window),
                         .rows = block_rows(f->window),
                         .blocks = arena_new(arena, struct evidence_block, count)};
    for (size_t i = 0; i < count; i++)
        e.blocks[i] = evidence_block(f, i);
    judge_regions(f, among, &e, arena);
    return e;
}

static void sum_up(const struct film *f, struct evidence *e)
{
    double pixels[EVIDENCE_HEAVY + 1] = {0};
    for (size_t i = 0; i < block_count(f->window); i++) {
        const struct evidence_block *b = &e->blocks[i];
        const double here = tile_rect_pixels(block_rect_of(f->window, i));
        pixels[b->verdict] += here;
        if (b->verdict == EVIDENCE_UNKNOWN && !(b->neff >= EVIDENCE_LEAST))
            e->few += here / tile_rect_pixels(f->window);
    }
    e->unknown = pixels[EVIDENCE_UNKNOWN] / tile_rect_pixels(f->window);
    e->heavy = pixels[EVIDENCE_HEAVY] / tile_rect_pixels(f->window);
}

struct evidence evidence_among(const struct film *f, const bool *among, struct arena *arena)
{
    struct evidence e = begin(f, among, arena);
    sum_up(f, &e);
    return e;
}

struct evidence evidence_make(const struct film *f, struct arena *arena)
{
    struct evidence e = begin(f, NULL, arena);
    evidence_bars_judge(f, &e, arena);
    sum_up(f, &e);
    return e;
}
