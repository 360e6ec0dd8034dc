/* sampler.h: numbers of every sampler are uniform, pure functions of their place, stratified as it
 * says; and how fast the mean of a smooth function converges with each.
 * SPDX-License-Identifier: MIT */
#include "common/trace/sampler.h"

#include <math.h>

#include "tests/stat/chi2.h"
#include "tests/stat/stat.h"
#include "tests/tap.h"

static const char *const names[] = {[SAMPLER_SOBOL] = "sobol",
                                    [SAMPLER_INDEPENDENT] = "independent",
                                    [SAMPLER_STRATIFIED] = "stratified"};

static struct scene_settings settings(int sampler, uint32_t points)
{
    return (struct scene_settings){.sampler = (enum sampler_kind)sampler,
                                   .target = {.spp = points * FILM_REPLICATES}};
}

/* The eight replicates of a pixel at a point of theirs. */
static struct rng8 at(uint32_t x_px, uint32_t index)
{
    struct rng r[FILM_REPLICATES];
    struct rng8 eight;
    for (uint32_t i = 0; i < FILM_REPLICATES; i++)
        r[i] = rng_make(5, x_px, 7, index * FILM_REPLICATES + i);
    rng8_make(&eight, r, FILM_REPLICATES);
    return eight;
}

/* Counts of a pair on a grid of 16 x 16, for one point of many pixels, and for pairs of a point's
 * single number and the next point's. */
static void is_uniform(int sampler)
{
    enum { SIDE = 16, CELLS = SIDE * SIDE };
    const uint32_t pixels = stat_tries(20000, 200000);
    const struct scene_settings s = settings(sampler, 16);
    uint32_t pairs[CELLS] = {0}, singles[CELLS] = {0}, dimensions[CELLS] = {0};
    double due[CELLS];
    for (int i = 0; i < CELLS; i++)
        due[i] = pixels * 8. / CELLS;
    bool inside = true;
    for (uint32_t x = 0; x < pixels; x++) {
        const struct rng8 a = at(x, x % 16), b = at(x, x % 16 ^ 1);
        const struct sobol8_square q = sampler_pair(&s, &a, 3);
        const f32x8 one = sampler_single(&s, &a, 4), next = sampler_single(&s, &b, 4);
        const f32x8 other = sampler_single(&s, &a, 9);
        for (int i = 0; i < 8; i++) {
            inside &=
                q.u[i] >= 0 && q.u[i] < 1 && q.v[i] >= 0 && q.v[i] < 1 && one[i] >= 0 && one[i] < 1;
            pairs[(int)(q.u[i] * SIDE) * SIDE + (int)(q.v[i] * SIDE)]++;
            singles[(int)(one[i] * SIDE) * SIDE + (int)(next[i] * SIDE)]++;
            dimensions[(int)(one[i] * SIDE) * SIDE + (int)(other[i] * SIDE)]++;
        }
    }
    const double level = stat_sidak(0.01, 9);
    const struct chi2 p = chi2_test(due, pairs, CELLS), d = chi2_test(due, dimensions, CELLS);
    ok(inside && p.p > level, "%s: pairs are uniform (p %.3f, detects %.3f rms)", names[sampler],
       p.p, chi2_detects(&p, pixels * 8., level));
    ok(d.p > level, "%s: dimensions do not know each other (p %.3f)", names[sampler], d.p);
    if (sampler == SAMPLER_INDEPENDENT)
        ok(chi2_test(due, singles, CELLS).p > level, "%s: neither do points", names[sampler]);
}

/* Points of a block, each in a cell of its own; also the elders', whose blocks have half as many.
 */
static void is_stratified(void)
{
    bool pairs = true, singles = true, elders = true;
    for (uint32_t points = 4; points <= 2048; points *= 2) {
        const struct scene_settings s = settings(SAMPLER_STRATIFIED, points);
        uint32_t k = 0;
        while (k < 5 && points >> (2 * k + 2))
            k++;
        const uint32_t side = 1u << k, cells = side * side;
        for (uint32_t block = 0; block < 2; block++) {
            unsigned char pair[1024] = {0}, single[1024] = {0};
            for (uint32_t i = block * cells; i < block * cells + cells; i++) {
                const struct rng8 r = at(1, i);
                const struct sobol8_square q = sampler_pair(&s, &r, 11);
                const f32x8 one = sampler_single(&s, &r, 12);
                const uint32_t cell =
                    (uint32_t)(q.u[3] * (float)side) * side + (uint32_t)(q.v[3] * (float)side);
                pairs &= !pair[cell]++;
                singles &= !single[(uint32_t)(one[3] * (float)cells)]++;
            }
        }
        if (points < 8)
            continue;
        const uint32_t half = points / 2 >> 2 * k ? side : side / 2;
        unsigned char pair[1024] = {0};
        struct rng_pixel p;
        rng_pixel_init(&p, 5, 1, 7);
        for (uint32_t i = 0; i < 2 * half * half; i++) {
            rng_pixel_go(&p, i);
            const struct sobol8_square q = sampler_filter(&s, &p);
            const uint32_t cell =
                (uint32_t)(q.u[3] * (float)half) * half + (uint32_t)(q.v[3] * (float)half);
            elders &= pair[cell]++ == i % 2; /* both siblings, one after the other */
        }
    }
    ok(pairs, "stratified: each cell of the grid has one point of each block");
    ok(singles, "stratified: so has each part of a single number");
    ok(elders, "stratified: the pairs that siblings share fill a grid of their own");
}

static void is_pure(void)
{
    bool same = true, lanes = true;
    for (int k = 1; k < 3; k++) {
        const struct scene_settings s = settings(k, 64);
        const struct rng8 a = at(3, 17), b = at(3, 17);
        struct rng r[2] = {rng_make(5, 3, 7, 17 * 8 + 6), rng_make(5, 3, 7, 17 * 8 + 2)};
        struct rng8 two;
        rng8_make(&two, r, 2);
        const struct sobol8_square q = sampler_pair(&s, &a, 5), p = sampler_pair(&s, &b, 5);
        const struct sobol8_square t = sampler_pair(&s, &two, 5);
        for (int i = 0; i < 8; i++)
            same &= q.u[i] == p.u[i] && q.v[i] == p.v[i];
        lanes &= t.u[0] == q.u[6] && t.v[0] == q.v[6] && t.u[1] == q.u[2] && t.v[1] == q.v[2];
    }
    ok(same && lanes, "numbers depend on their place alone, not on the lane");
}

/* --- convergence --- */

static double smooth(double u, double v)
{
    return exp(u) * (1 + .5 * sin(3 * v)) + u * v;
}

/* Variance of the mean of n points of a replicate, over many of them. */
static double variance(int sampler, uint32_t n, uint32_t pixels)
{
    const struct scene_settings s = settings(sampler, n);
    const double truth = (exp(1) - 1) * (1 + .5 * (1 - cos(3)) / 3) + .25;
    double square = 0;
    for (uint32_t x = 0; x < pixels; x++) {
        double mean[8] = {0};
        for (uint32_t i = 0; i < n; i++) {
            const struct rng8 r = at(x, i);
            const struct sobol8_square q = sampler_pair(&s, &r, 1);
            for (int k = 0; k < 8; k++)
                mean[k] += smooth((double)q.u[k], (double)q.v[k]) / n;
        }
        for (int k = 0; k < 8; k++)
            square += (mean[k] - truth) * (mean[k] - truth) / (8. * pixels);
    }
    return square;
}

static void converge(void)
{
    const uint32_t pixels = stat_tries(400, 20000);
    double slope[3], last[3];
    for (int sampler = 0; sampler < 3; sampler++) {
        const double first = variance(sampler, 16, pixels);
        last[sampler] = variance(sampler, 256, pixels);
        slope[sampler] = log(last[sampler] / first) / log(16);
        diag("%s: variance %.2e of 16 points, %.2e of 256: slope %.2f", names[sampler], first,
             last[sampler], slope[sampler]);
    }
    /* A variance of 8 pixels values has a relative error of sqrt(2 / (8 pixels)). */
    const double tolerance = 4 * sqrt(2 * 2 / (8. * pixels)) / log(16);
    near(slope[SAMPLER_INDEPENDENT], -1, tolerance, "independent: variance falls as 1 / n");
    near(slope[SAMPLER_STRATIFIED], -2, .05 + tolerance,
         "stratified: as 1 / n^2, of a smooth function of two numbers");
    ok(slope[SAMPLER_SOBOL] < -2.5, "sobol: faster still");
    ok(last[SAMPLER_SOBOL] < last[SAMPLER_STRATIFIED] &&
           last[SAMPLER_STRATIFIED] < .05 * last[SAMPLER_INDEPENDENT],
       "of 256 points, stratified ones have less than a twentieth of the variance, sobol's less");
}

int main(void)
{
    for (int sampler = 0; sampler < 3; sampler++)
        is_uniform(sampler);
    is_stratified();
    is_pure();
    converge();
    return tap_done();
}
