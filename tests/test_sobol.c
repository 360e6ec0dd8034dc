/* sobol.h, rng.h: each replicate's pair is a (0, 2)-sequence, and replicates, dimensions and
 * pixels are independent of each other.
 * SPDX-License-Identifier: MIT */
#include "common/trace/rng.h"

#include <math.h>
#include <string.h>

#include "tests/stat/chi2.h"
#include "tests/stat/stat.h"
#include "tests/tap.h"

enum { REPLICATES = FILM_REPLICATES };

/* The first 2^k points of the replicate: one in each box of 2^-a x 2^-(k-a), for all a. */
static bool is_net(uint64_t seed, uint32_t replicate, uint32_t dimension, uint32_t begin, int k)
{
    const uint32_t n = 1u << k;
    for (int a = 0; a <= k; a++) {
        unsigned char seen[1 << 10] = {0};
        for (uint32_t j = begin; j < begin + n; j++) {
            const struct rng r = rng_make(seed, 3, 4, j * REPLICATES + replicate);
            const struct square q = rng_pair(&r, dimension);
            const uint32_t x = (uint32_t)(q.u * (float)(1u << a));
            const uint32_t y = (uint32_t)(q.v * (float)(1u << (k - a)));
            if (seen[y << a | x]++)
                return false;
        }
    }
    return true;
}

static void pairs_are_nets(void)
{
    bool first = true, later = true;
    for (uint32_t r = 0; r < REPLICATES; r++)
        for (uint32_t d = 0; d < 12; d++)
            for (int k = 1; k <= 10; k++) {
                first &= is_net(d, r, d, 0, k);
                later &= is_net(d, r, d, 5u << k, k);
            }
    ok(first, "first 2^k points of each replicate and pair fill all elementary intervals");
    ok(later, "so do the points of any aligned block of 2^k");
}

static void singles_are_stratified(void)
{
    bool once = true;
    for (uint32_t d = 0; d < 12; d++) {
        unsigned char seen[256] = {0};
        for (uint32_t j = 0; j < 256; j++) {
            const struct rng r = rng_make(7, 0, 0, j * REPLICATES + d % REPLICATES);
            once &= seen[(int)(rng_single(&r, d) * 256)]++ == 0;
        }
    }
    ok(once, "256 single numbers of a replicate fall into 256 equal parts");
}

static void purposes_have_own_dimensions(void)
{
    static const enum rng_purpose all[] = {RNG_LIGHT, RNG_BSDF_DIRECTION, RNG_BSDF_LOBE,
                                           RNG_ROULETTE};
    enum { BOUNCES = 1000, DIMENSIONS = 1 + BOUNCES * countof(all) };
    static unsigned char seen[DIMENSIONS];
    bool own = true;
    seen[RNG_FILTER] = 1;
    for (uint32_t b = 0; b < BOUNCES; b++)
        for (size_t p = 0; p < countof(all); p++) {
            const uint32_t d = rng_dimension(b, all[p]);
            own &= d < DIMENSIONS && seen[d]++ == 0;
        }
    ok(own, "each purpose of each bounce has a dimension of its own");
}

/* p value of 16 x 16 cells for pairs (x, y). */
struct grid {
    uint32_t seen[256];
    uint32_t n;
};

static void grid_add(struct grid *g, float x, float y)
{
    g->seen[(int)(x * 16) * 16 + (int)(y * 16)]++;
    g->n++;
}

static double grid_p(const struct grid *g)
{
    double due[256];
    for (int i = 0; i < 256; i++)
        due[i] = g->n / 256.0;
    return chi2_test(due, g->seen, 256).p;
}

/* One point from each of many pixels: there only hashing is at work. */
static float of_pixel(uint32_t pixel, uint32_t sample, uint32_t dimension, bool second)
{
    const struct rng r = rng_make(42, pixel % 512, pixel / 512, sample);
    const struct square q = rng_pair(&r, dimension);
    return second ? q.v : q.u;
}

static void hashes_are_independent(void)
{
    const uint32_t pixels = 60000 / STAT_SLOW;
    double least = 1;
    int tests = 0;
    for (uint32_t d = 0; d < 8; d++)
        for (uint32_t e = d; e < 8; e++)
            for (uint32_t sample = 0; sample < 17; sample += 8) {
                struct grid g = {{0}, 0};
                for (uint32_t p = 0; p < pixels; p++)
                    grid_add(&g, of_pixel(p, sample, d, false), of_pixel(p, sample, e, true));
                least = fmin(least, grid_p(&g));
                tests++;
            }
    ok(least > stat_sidak(0.01, tests),
       "coordinates of dimensions 0 to 7 are pairwise independent"
       " over pixels: p %g",
       least);
    least = 1;
    for (uint32_t s = 1; s < 24; s++) {
        struct grid g = {{0}, 0}, h = {{0}, 0};
        for (uint32_t p = 0; p < pixels; p++) {
            grid_add(&g, of_pixel(p, 0, 0, false), of_pixel(p + 1, s, 0, false));
            if (s % REPLICATES) /* points of one replicate avoid each other on purpose */
                grid_add(&h, of_pixel(p, 0, 2, true), of_pixel(p, s, 2, true));
        }
        least = fmin(least, grid_p(&g));
        if (s % REPLICATES)
            least = fmin(least, grid_p(&h));
    }
    ok(least > stat_sidak(0.01, 44), "replicates and neighbours are independent over pixels: p %g",
       least);
}

/* Over bounces of one sample: a path's numbers. 200 dimensions deep nothing repeats. */
static void deep_dimensions_are_independent(void)
{
    double least = 1;
    for (uint32_t lag = 1; lag <= 10; lag++) {
        struct grid g = {{0}, 0};
        for (uint32_t p = 0; p < 200; p++)
            for (uint32_t d = 0; d < 300; d++)
                grid_add(&g, of_pixel(p, 0, d, false), of_pixel(p, 0, d + lag, false));
        least = fmin(least, grid_p(&g));
    }
    ok(least > stat_sidak(0.01, 10), "dimensions 0 to 300 of a sample are independent: p %g",
       least);
}

/* The mean of a smooth function: the error of Owen-scrambled nets falls far faster than 1/sqrt(n).
 */
static void smooth_integrals_converge(void)
{
    double square[2] = {0, 0};
    const uint32_t n[2] = {64, 1024};
    for (int i = 0; i < 2; i++)
        for (uint32_t p = 0; p < 256; p++) {
            double sum = 0;
            for (uint32_t j = 0; j < n[i]; j++) {
                const struct rng r = rng_make(9, p, 0, j * REPLICATES);
                const struct square q = rng_pair(&r, 1);
                sum += exp(-(double)q.u) * cos((double)q.v);
            }
            const double off = sum / n[i] - (1 - exp(-1)) * sin(1);
            square[i] += off * off / 256;
        }
    const double slope = log(square[1] / square[0]) / log(16);
    ok(slope < -2.5, "squared error of a smooth integrand falls as n^-2.5 or faster: %.2f", slope);
}

static void bits_are_fixed(void)
{
    uint32_t h = 1;
    for (uint32_t i = 0; i < 10000; i++) {
        const struct rng r = rng_make(i, i * 7, i * 13, i * 3);
        const struct square q = rng_pair(&r, i);
        const float f[3] = {q.u, q.v, rng_single(&r, i + 1)};
        uint32_t b[3];
        memcpy(b, f, sizeof b);
        h = ((h * 31 + b[0]) * 31 + b[1]) * 31 + b[2];
    }
    ok(h == 0x6f460316, "10000 points have the bits of every other build");
}

/* Sample 8 index + i of a pixel, in lane i. */
static void octets_are_the_same(void)
{
    int other = 0, stranger = 0;
    for (uint32_t p = 0; p < 2000; p++) {
        struct rng_pixel pixel;
        rng_pixel_init(&pixel, p, p * 7, p * 13);
        const uint32_t index = p * 977 % (1u << 21);
        rng_pixel_go(&pixel, index);
        const struct sobol8_square eight = rng_pixel_filter(&pixel);
        for (uint32_t i = 0; i < FILM_REPLICATES; i++) {
            const struct rng r = rng_make(p, p * 7, p * 13, index * FILM_REPLICATES + i);
            const struct rng elder = rng_elder(&r);
            const struct rng half = rng_make(p, p * 7, p * 13, index / 2 * FILM_REPLICATES + i);
            const struct square one = rng_pair(&elder, RNG_FILTER);
            other += pixel.replicate[i].key != r.key ||
                     pixel.replicate[i].index_reversed != r.index_reversed || eight.u[i] != one.u ||
                     eight.v[i] != one.v;
            stranger += half.key != elder.key || half.index_reversed != elder.index_reversed;
        }
    }
    ok(other == 0, "eight samples at once are the eight samples: %d differ", other);
    ok(stranger == 0, "point k of a replicate is the elder of 2 k and 2 k + 1: of %d it is not",
       stranger);
}

/* What a wave of paths draws. */
static void eights_are_the_same(void)
{
    int other = 0;
    for (uint32_t p = 0; p < 2000; p++) {
        struct rng r[8];
        struct rng8 eight;
        const uint32_t count = 1 + p % 8;
        for (uint32_t i = 0; i < count; i++)
            r[i] = rng_make(p, i, p, p * 31 + i * 8191);
        rng8_make(&eight, r, count);
        const struct sobol8_square pair = rng8_pair(&eight, p);
        const struct sobol8_bits bits = rng8_pair_bits(&eight, p + 1);
        const f32x8 single = rng8_single(&eight, p + 2);
        for (uint32_t i = 0; i < count; i++) {
            const struct square q = rng_pair(&r[i], p);
            const struct sobol_bits b = rng_pair_bits(&r[i], p + 1);
            other += q.u != pair.u[i] || q.v != pair.v[i] || b.u != bits.u[i] ||
                     b.v != bits.v[i] || rng_single(&r[i], p + 2) != single[i];
        }
    }
    ok(other == 0, "eight generators' numbers at once are each one's own: %d differ", other);
}

int main(void)
{
    pairs_are_nets();
    singles_are_stratified();
    purposes_have_own_dimensions();
    hashes_are_independent();
    deep_dimensions_are_independent();
    smooth_integrals_converge();
    bits_are_fixed();
    octets_are_the_same();
    eights_are_the_same();
    return tap_done();
}
