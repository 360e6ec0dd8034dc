/* SPDX-License-Identifier: MIT */
#include "common/evidence.h"

#include <math.h>

enum { R = FILM_REPLICATES, PIXELS = BLOCK_PX * BLOCK_PX };

static const double rounding = 1e-6; /* of a mean: replicates' sums are floats */
static const double most_missed = .5, most_around = 1.5, least_held = .88;

/* Student's t, 3 degrees of freedom, times the sqrt 2 of a difference; squared. */
static const double reach = 2 * 3.182 * 3.182;

struct bars {      /* of a block's pixels, those that are not noisy left out of all but missed */
    double missed; /* mean over pixels of their mean less the median of their replicates */
    double errors[PIXELS]; /* standard errors, ascending */
    uint32_t noisy, tests, held;
};

static void sort_in(double values[], uint32_t count, double v)
{
    uint32_t at = count;
    for (; at > 0 && values[at - 1] > v; at--)
        values[at] = values[at - 1];
    values[at] = v;
}

static double luminances(const struct film *f, size_t pixel, double y[R])
{
    const float *sums = f->replicate + pixel * FILM_CHANNELS;
    double mean = 0;
    for (uint32_t r = 0; r < R; r++) {
        y[r] = (0.2126 * (double)sums[3 * r] + 0.7152 * (double)sums[3 * r + 1] +
                0.0722 * (double)sums[3 * r + 2]) /
               film_replicate_spp(f->spp[pixel], r);
        mean += y[r] / R;
    }
    return mean;
}

/* Whether the intervals of four replicates hold the mean of the other four. y: less the mean of
 * all, so that the sum of the others is -own; square: the sum of y^2. */
static void test_halves(const double y[R], double square, struct bars *b)
{
    /* Seven ways to halve eight, of which any two have two in common: a Hadamard matrix's rows. */
    static const uint8_t halves[][R / 2] = {{0, 1, 2, 3}, {0, 1, 4, 5}, {0, 1, 6, 7}, {0, 2, 4, 6},
                                            {0, 2, 5, 7}, {0, 3, 4, 7}, {0, 3, 5, 6}};
    for (size_t i = 0; i < countof(halves); i++) {
        const double y0 = y[halves[i][0]], y1 = y[halves[i][1]], y2 = y[halves[i][2]],
                     y3 = y[halves[i][3]], own = y0 + y1 + y2 + y3, off = own * own / 4,
                     squares = y0 * y0 + y1 * y1 + y2 * y2 + y3 * y3;
        b->held += off <= reach * (squares - off) / (3 * 4);
        b->held += off <= reach * (square - squares - off) / (3 * 4);
        b->tests += 2;
    }
}

static void look_at(const struct film *f, size_t pixel, struct bars *b)
{
    double y[R], sorted[R], square = 0;
    const double mean = luminances(f, pixel, y);
    for (uint32_t r = 0; r < R; r++) {
        y[r] -= mean;
        sort_in(sorted, r, y[r]);
        square += y[r] * y[r];
    }
    b->missed -= (sorted[R / 2 - 1] + sorted[R / 2]) / 2;
    if (sorted[R - 1] - sorted[0] <= rounding * mean)
        return;
    sort_in(b->errors, b->noisy++, sqrt(square / ((R - 1) * R)));
    test_halves(y, square, b);
}

static struct bars bars_of(const struct film *f, struct tile_rect block)
{
    const struct tile_rect w = f->window;
    struct bars b = {0};
    for (uint32_t y = block.y_begin; y < block.y_end; y++)
        for (uint32_t x = block.x_begin; x < block.x_end; x++) {
            const size_t pixel = (size_t)(y - w.y_begin) * (w.x_end - w.x_begin) + (x - w.x_begin);
            if (f->spp[pixel] < R)
                return (struct bars){0}; /* they have no end */
            look_at(f, pixel, &b);
        }
    b.missed /= tile_rect_pixels(block);
    return b;
}

/* ---- beside its neighbours ---- */

struct summary { /* of a block's bars */
    double missed, bar;
    bool noisy, hold;
};

static double missed_around(const struct tile_rect window, const struct summary all[], size_t i)
{
    const struct tile_rect r = block_around(window, i);
    double sum = 0;
    for (uint32_t y = r.y_begin; y < r.y_end; y++)
        for (uint32_t x = r.x_begin; x < r.x_end; x++)
            sum += all[(size_t)y * block_columns(window) + x].missed;
    return fabs(sum) / tile_rect_pixels(r);
}

void evidence_bars_judge(const struct film *f, struct evidence *e, struct arena *arena)
{
    const size_t count = (size_t)e->columns * e->rows;
    struct summary *all = arena_new(arena, struct summary, count);
    for (size_t i = 0; i < count; i++) {
        const struct bars b = bars_of(f, block_rect_of(f->window, i));
        const double bar = b.noisy ? b.errors[b.noisy / 2] : 0;
        all[i] =
            (struct summary){b.missed, bar, b.noisy > 0,
                             fabs(b.missed) <= most_missed * bar && b.held >= least_held * b.tests};
    }
    for (size_t i = 0; i < count; i++)
        if (e->blocks[i].verdict == EVIDENCE_TRUSTED && all[i].noisy &&
            !(all[i].hold && missed_around(f->window, all, i) <= most_around * all[i].bar))
            e->blocks[i].verdict = EVIDENCE_UNKNOWN;
}
