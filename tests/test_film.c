/* film.c, estimate.c, image.c: sums, replicates, standard errors, digests.
 * SPDX-License-Identifier: MIT */
#include <math.h>
#include <string.h>

#include "common/estimate.h"
#include "common/film.h"
#include "common/image.h"
#include "tests/tap.h"

/* A small generator for test data only: xorshift64*, Marsaglia 2003 / Vigna 2016. */
static uint64_t state = 0x9e3779b97f4a7c15;
static double uniform(void)
{
    state ^= state >> 12;
    state ^= state << 25;
    state ^= state >> 27;
    return (double)(state * 2685821657736338717u >> 11) * 0x1p-53;
}

static const struct tile_rect window = {4, 2, 4 + 13, 2 + 9};

/* Every sample of the pass is `value` (+ noise in [0, noise)). */
static struct film_samples samples_of(struct tile_rect r, struct tile_pass pass, double value,
                                      double noise, struct arena *arena)
{
    struct film_samples s = film_samples_make(r, pass, arena);
    for (uint32_t px = 0; px < tile_rect_pixels(r); px++) {
        double sum[FILM_CHANNELS] = {0};
        for (uint32_t i = pass.s_begin; i < pass.s_end; i++)
            for (uint32_t c = 0; c < 3; c++)
                sum[i % FILM_REPLICATES * 3 + c] += value + noise * uniform();
        for (uint32_t k = 0; k < FILM_CHANNELS; k++)
            s.sums[px * FILM_CHANNELS + k] = (float)sum[k];
    }
    return s;
}

static void merge_all(struct film *f, uint32_t spp, uint32_t tile_px, double value, double noise)
{
    struct arena arena = {0};
    const struct tile_grid g = tile_grid_make(f->window, tile_px);
    for (uint32_t p = 0; p < tile_pass_count(spp); p++)
        for (uint32_t t = 0; t < tile_count(&g); t++) {
            const struct film_samples s =
                samples_of(tile_rect_of(&g, t), tile_pass_of(p, spp), value, noise, &arena);
            film_merge(f, &s);
            arena_reset(&arena);
        }
    arena_release(&arena);
}

static void constant_samples_have_their_mean_and_no_error(uint32_t spp)
{
    struct film f;
    film_init(&f, window);
    merge_all(&f, spp, 8, 0.5, 0);
    bool mean_right = true, error_zero = true;
    for (size_t i = 0; i < tile_rect_pixels(window); i++) {
        double m[3], s[3];
        film_mean(&f, i, m);
        estimate_pixel(&f, i, s);
        for (int c = 0; c < 3; c++) {
            mean_right &= m[c] == 0.5;
            error_zero &= spp < 8 ? isinf(s[c]) : s[c] == 0;
        }
        mean_right &= f.spp[i] == spp;
    }
    ok(mean_right, "%u constant samples: the mean is exact in every pixel", spp);
    ok(error_zero, "%u constant samples: the standard error is %s", spp,
       spp < 8 ? "unknown" : "zero");
    ok(spp < 8 ? isinf(estimate_error(&f)) : estimate_error(&f) == 0, "and so is the job's error");
    film_release(&f);
}

/* Uniform noise on [1, 3): mean 2, variance 1/3; the error of n samples is sqrt(1/(3 n)) / 2. */
static void error_estimate_is_true_for_independent_samples(uint32_t spp)
{
    struct film f;
    film_init(&f, (struct tile_rect){0, 0, 64, 64});
    merge_all(&f, spp, 64, 1, 2);
    const double truth = sqrt(1.0 / (3.0 * spp)) / 2;
    near(estimate_error(&f) / truth, 1, 0.02, "job error of uniform noise at %u spp", spp);

    uint32_t covered = 0, total = 0;
    for (size_t i = 0; i < tile_rect_pixels(f.window); i++) {
        double m[3], s[3];
        film_mean(&f, i, m);
        estimate_pixel(&f, i, s);
        for (int c = 0; c < 3; c++, total++)
            covered += fabs(m[c] - 2) <= 2.365 * s[c];
    }
    near((double)covered / total, 0.95, 0.01, "95 %% intervals at %u spp cover the truth", spp);
    film_release(&f);
}

/* F-19: a float sum of 1e8 samples of one half would give .084; of values that are no multiples of
 * a power of 2 a float film would lose a part with every pass. */
static void long_sums_keep_their_mean(double value)
{
    struct film f;
    film_init(&f, (struct tile_rect){0, 0, 1, 1});
    struct arena arena = {0};
    const uint32_t spp = 100000000;
    const uint32_t passes = tile_pass_count(spp);
    struct film_samples s = film_samples_make(f.window, tile_pass_of(0, spp), &arena);
    for (uint32_t p = 0; p < passes; p++) {
        s.pass = tile_pass_of(p, spp);
        for (uint32_t k = 0; k < FILM_CHANNELS; k++) {
            const uint32_t n =
                film_replicate_spp(s.pass.s_end, k / 3) - film_replicate_spp(s.pass.s_begin, k / 3);
            s.sums[k] = (float)(value * n);
        }
        film_merge(&f, &s);
    }
    double m[3];
    film_mean(&f, 0, m);
    near(m[0] / value, 1, 1e-6, "F-19: the mean of 1e8 samples of %g", value);
    arena_release(&arena);
    film_release(&f);
}

static void invalid_keys_do_not_depend_on_order(void)
{
    struct arena arena = {0};
    struct film a, b;
    film_init(&a, window);
    film_init(&b, window);
    const struct tile_grid g = tile_grid_make(window, 8);
    const uint32_t tiles = tile_count(&g);
    for (uint32_t i = 0; i < 2 * tiles; i++) {
        const uint32_t t = i < tiles ? i : 2 * tiles - 1 - i;
        struct film *f = i < tiles ? &a : &b;
        const struct tile_rect r = tile_rect_of(&g, t);
        struct film_samples s = samples_of(r, (struct tile_pass){0, 8}, 1, 0, &arena);
        for (uint32_t y = r.y_begin; y < r.y_end; y++)
            for (uint32_t x = r.x_begin; x < r.x_end; x++)
                film_samples_note_invalid(&s, (struct film_key){x, y, (x + y) % 8});
        film_merge(f, &s);
    }
    ok(a.invalid_count == tile_rect_pixels(window), "all invalid samples are counted");
    ok(a.key_count == FILM_MAX_KEYS && !memcmp(a.keys, b.keys, sizeof a.keys),
       "the first sixteen keys are the same in any order of tiles");
    ok(a.keys[0].x_px == window.x_begin && a.keys[FILM_MAX_KEYS - 1].y_px == window.y_begin + 1,
       "and they are the first ones from the top left");
    film_release(&a);
    film_release(&b);
    arena_release(&arena);
}

/* Blocks of noise, by pixel and sample; tiles of any size must add them up to the same bits. */
static void merge_noise(struct film *f, uint32_t tile_px, bool backwards)
{
    struct arena arena = {0};
    const struct tile_grid g = tile_grid_make(f->window, tile_px);
    film_init(f, f->window);
    for (uint32_t p = 0; p < tile_pass_count(64); p++)
        for (uint32_t n = 0; n < tile_count(&g); n++) {
            const uint32_t t = backwards ? tile_count(&g) - 1 - n : n;
            const struct tile_rect r = tile_rect_of(&g, t);
            struct film_samples s = film_samples_make(r, tile_pass_of(p, 64), &arena);
            for (uint32_t y = r.y_begin; y < r.y_end; y++)
                for (uint32_t x = r.x_begin; x < r.x_end; x++)
                    for (uint32_t i = s.pass.s_begin; i < s.pass.s_end; i++)
                        block_add(
                            &s.blocks[(y - r.y_begin) / BLOCK_PX * block_columns(r) +
                                      (x - r.x_begin) / BLOCK_PX],
                            (float)((x * 73856093u ^ y * 19349663u ^ i * 83492791u) % 100003) / 97);
            film_merge(f, &s);
            arena_reset(&arena);
        }
    arena_release(&arena);
}

static bool blocks_equal(const struct film *a, const struct film *b)
{
    const size_t n = block_count(a->window);
    return !memcmp(a->blocks, b->blocks, n * sizeof *a->blocks) &&
           !memcmp(a->variance, b->variance, n * BLOCK_DOUBLINGS * sizeof *a->variance);
}

static void blocks_do_not_depend_on_tiles(void)
{
    struct film want = {.window = {5, 3, 5 + 77, 3 + 50}};
    merge_noise(&want, 64, false);
    static const uint32_t sides[] = {8, 16, 24, 40, 256};
    for (size_t i = 0; i < countof(sides); i++) {
        struct film f = {.window = want.window};
        merge_noise(&f, sides[i], i % 2);
        ok(blocks_equal(&f, &want), "tiles of %u px: the same blocks", sides[i]);
        film_release(&f);
    }
    const float *v = want.variance;
    ok(v[3] > 0 && v[0] > 0 && v[3] != v[2], "four doublings of 8 leave four variances");
    struct film copy;
    film_copy(&copy, &want);
    ok(blocks_equal(&copy, &want), "a copy has them, too");
    film_release(&copy);
    film_release(&want);
}

static void digest_sees_every_pixel(void)
{
    struct arena arena = {0};
    struct film f;
    film_init(&f, window);
    merge_all(&f, 16, 8, 1, 1);
    struct image image = image_from_film(&f, 64, 48, &arena);
    char a[HASH_HEX], b[HASH_HEX];
    image_digest(&image, a);
    image_digest(&image, b);
    ok(!strcmp(a, b) && hash_is_hex(a), "a digest is a function of the image");
    float *red = image_find(&image, "R")->pixels;
    red[tile_rect_pixels(window) - 1] = nextafterf(red[tile_rect_pixels(window) - 1], 9);
    image_digest(&image, b);
    ok(strcmp(a, b) != 0, "one bit of the last pixel changes it");
    bool sorted = true;
    for (size_t c = 1; c < image.channel_count; c++)
        sorted &= strcmp(image.channels[c - 1].name, image.channels[c].name) < 0;
    ok(sorted && !image_find(&image, "Z"), "channels are sorted by name");
    image_digest(&image, a);
    ((float *)image_find(&image, "error.neff")->pixels)[0] += 1;
    ((uint32_t *)image_find(&image, "error.verdict")->pixels)[1] ^= 1;
    image_digest(&image, b);
    ok(!strcmp(a, b), "what is thought of the samples does not change it");
    film_release(&f);
    arena_release(&arena);
}

int main(void)
{
    static const uint32_t counts[] = {1, 7, 8, 9, 100, 256, 300};
    for (size_t i = 0; i < countof(counts); i++)
        constant_samples_have_their_mean_and_no_error(counts[i]);
    error_estimate_is_true_for_independent_samples(64);
    error_estimate_is_true_for_independent_samples(100);
    long_sums_keep_their_mean(.5);
    long_sums_keep_their_mean(.3);
    invalid_keys_do_not_depend_on_order();
    blocks_do_not_depend_on_tiles();
    digest_sees_every_pixel();
    return tap_done();
}
