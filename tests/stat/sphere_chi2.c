/* SPDX-License-Identifier: MIT */
#include "tests/stat/sphere_chi2.h"

#include <math.h>

#include "common/arena.h"
#include "tests/dice.h"
#include "tests/stat/stat.h"

enum { ROWS = 51, COLUMNS = 102, CELLS = ROWS * COLUMNS };
enum { MAX_DEPTH = STAT_SLOW == 1 ? 6 : 4 }; /* fewer samples need no finer expectation */

static double pdf_at(const void *what, vec3 w)
{
    const struct sphere_chi2 *t = what;
    return (double)t->pdf_w(t->what, w);
}

static size_t cell_of(const struct sphere_chart *chart, vec3 w)
{
    const struct sphere_place p = sphere_chart_place(chart, w);
    const int row = (int)fmin(p.row * ROWS, ROWS - 1);
    const int column = (int)fmin(p.turn * COLUMNS, COLUMNS - 1);
    return (size_t)(row * COLUMNS + column);
}

static bool valid(vec3 w, float pdf_w)
{
    return fabsf(vec3_dot(w, w) - 1) < 1e-4f && pdf_w >= 0 && isfinite(pdf_w);
}

/* Fills the counts; returns how many samples were turned away. */
static uint32_t draw(const struct sphere_chi2 *t, const struct sphere_chart *chart,
                     uint32_t samples, uint64_t seed, uint32_t *observed,
                     struct sphere_chi2_result *r)
{
    struct dice dice = dice_make(seed);
    uint32_t away = 0;
    for (uint32_t i = 0; i < samples; i++) {
        struct square q;
        q.u = dice_float(&dice);
        q.v = dice_float(&dice);
        vec3 w;
        float pdf_w;
        if (!t->sample(t->what, q, &w, &pdf_w)) {
            away++;
            continue;
        }
        if (!valid(w, pdf_w)) {
            r->invalid++;
            continue;
        }
        observed[cell_of(chart, w)]++;
        if (t->pdf_most > 0 && pdf_w > t->pdf_most)
            continue;
        const double asked = (double)t->pdf_w(t->what, w);
        r->pdf_off = fmax(r->pdf_off, fabs((double)pdf_w / asked - 1));
    }
    return away;
}

/* Fills the expected counts; returns the integral of the pdf. */
static double expect(const struct sphere_chi2 *t, const struct sphere_chart *chart,
                     uint32_t samples, const uint32_t *observed, double *expected)
{
    struct sphere_integrand f = {.f = pdf_at, .what = t, .min_depth = t->min_depth};
    f.max_depth = MAX_DEPTH + t->more_depth;
    f.horizon = t->horizon;
    f.tolerance = t->tolerance > 0 ? t->tolerance : 1e-6;
    double mass = 0;
    for (int i = 0; i < CELLS; i++) {
        const int row = i / COLUMNS, column = i % COLUMNS;
        const struct sphere_place begin = {(double)row / ROWS, (double)column / COLUMNS};
        const struct sphere_place end = {(row + 1.0) / ROWS, (column + 1.0) / COLUMNS};
        f.trust_zero = observed[i] == 0;
        const double in_cell = sphere_chart_integral(chart, &f, begin, end);
        mass += in_cell;
        expected[i] = in_cell * samples;
    }
    return mass;
}

struct sphere_chi2_result sphere_chi2_run(const struct sphere_chi2 *t, uint32_t samples,
                                          uint64_t seed)
{
    struct arena arena = {0};
    double *expected = arena_new(&arena, double, CELLS);
    uint32_t *observed = arena_new(&arena, uint32_t, CELLS);
    struct sphere_chi2_result r = {0};
    const struct sphere_chart plain = sphere_chart_make(vec3_make(0, 0, 1), 0);
    const struct sphere_chart *chart = t->chart ? t->chart : &plain;
    const uint32_t away = draw(t, chart, samples, seed, observed, &r);
    const double mass = expect(t, chart, samples, observed, expected);
    r.chi2 = chi2_test(expected, observed, CELLS);
    const double share = (double)away / samples;
    r.mass_off = mass - 1 + share;
    r.mass_sd = sqrt(share * (1 - share) / samples);
    arena_release(&arena);
    return r;
}
