/* path.c, render.c: the integrator against the naive one, roulette, invariance, invalid samples,
 * accumulation, and the truth of the stated standard error.
 * SPDX-License-Identifier: MIT */
#include "common/trace/wave.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "common/estimate.h"
#include "common/trace/camera.h"
#include "common/trace/render.h"
#include "tests/dice.h"
#include "tests/naive_path.h"
#include "tests/scenes.h"
#include "tests/stat/means.h"
#include "tests/tap.h"

/* A room with coloured walls, a metal ball, a ball of glass or chalk, a mirror, a quad light, a
 * sphere light and a tube. */
static void mixed(struct scenes *s, uint32_t side_px, bool glass)
{
    scenes_init(s, side_px, side_px);
    scenes_look(s, vec3_make(0, 1, 3.4f), vec3_make(0, .8f, 0), .8);
    const uint32_t white = scenes_diffuse(s, rgb_gray(.7f));
    scenes_box(s, white, vec3_make(-1.5f, 0, -1.5f), vec3_make(1.5f, 2, 4), true);
    s->scene.shapes[0].material = scenes_diffuse(s, vec3_make(.6f, .1f, .1f));
    s->scene.shapes[4].material = scenes_mirror(s, vec3_make(.5f, .8f, .6f));
    const uint32_t metal =
        scenes_metal(s, vec3_make(.2f, .9f, 1.1f), vec3_make(3.9f, 2.4f, 2.2f), .15f);
    scenes_sphere(s, metal, vec3_make(-.7f, .5f, -.5f), .5f);
    scenes_sphere(s, glass ? scenes_glass(s, 1.5f) : white, vec3_make(.6f, .45f, .3f), .45f);
    scenes_quad(s, scenes_diffuse(s, rgb_gray(.1f)), vec3_make(-1.2f, 1.95f, -1.2f),
                vec3_make(2.4f, 0, 0), vec3_make(0, 0, 2.4f))
        ->emission = vec3_make(2, 2, 1.5f);
    scenes_sphere(s, white, vec3_make(1, 1.2f, -.9f), .25f)->emission = vec3_make(1, 2, 6);
    scenes_cylinder(s, metal, vec3_make(-1.2f, 1.5f, -.9f), vec3_make(.2f, .1f, .9f), .05f)
        ->emission = vec3_make(4, 1, 1);
}

/* --- against the oracle --- */

static void agrees_with_naive(float alpha, const char *name)
{
    struct scenes s;
    mixed(&s, 4, true);
    for (uint32_t i = 0; i < s.scene.material_count; i++)
        if (s.scene.materials[i].kind == MATERIAL_DIELECTRIC)
            s.scene.materials[i].dielectric.alpha = alpha;
    s.scene.settings.max_bounces = 32;
    const struct stage *stage = scenes_stage(&s);
    struct film film;
    scenes_render(stage, 4096 / STAT_SLOW, &film);
    struct dice dice = dice_make(77);
    struct stat_mean pixel[16][3] = {0}, image[3] = {0};
    const uint32_t n = 32000 / STAT_SLOW;
    for (uint32_t i = 0; i < n; i++) {
        double all[3] = {0, 0, 0};
        for (uint32_t p = 0; p < 16; p++) {
            double sum[3] = {0, 0, 0};
            naive_path_sample(stage, p % 4, p / 4, &dice, sum);
            for (int c = 0; c < 3; c++) {
                stat_add(&pixel[p][c], sum[c]);
                all[c] += sum[c] / 16;
            }
        }
        for (int c = 0; c < 3; c++)
            stat_add(&image[c], all[c]);
    }
    /* A replicate error has 7 degrees of freedom; beside the oracle's much larger one that is
     * hardly seen, so z limits hold. */
    const double limit = stat_z_limit(stat_sidak(0.01, 48));
    double worst = 0;
    for (size_t p = 0; p < 16; p++) {
        double mean[3], error[3];
        film_mean(&film, p, mean);
        estimate_pixel(&film, p, error);
        for (int c = 0; c < 3; c++)
            worst = fmax(worst, fabs(mean[c] - pixel[p][c].mean) /
                                    hypot(error[c], stat_error(&pixel[p][c])));
    }
    ok(worst < limit, "%s: each of 16 pixels agrees with the naive path tracer (z %.2f of %.2f)",
       name, worst, limit);
    for (int c = 0; c < 3; c++) {
        const struct scenes_mean m = scenes_mean(&film, c);
        const double error = hypot(m.error, stat_error(&image[c]));
        const double off = fabs(m.mean - image[c].mean);
        ok(off < 3.9 * error && error < (STAT_SLOW == 1 ? 0.004 : 0.04) * m.mean,
           "%s: channel %d agrees with the naive path tracer: %.5f, %.5f +- %.5f", name, c, m.mean,
           image[c].mean, error);
    }
    film_release(&film);
    scenes_release(&s);
}

static double luminance_along(const struct stage *stage, struct ray ray, const struct rng *rng,
                              uint32_t roulette_begin)
{
    struct wave_starts start;
    struct wave wave;
    rgb radiance;
    wave_begin(stage, 1, &ray, rng, &start);
    wave_init(&wave, stage, roulette_begin, NULL, &radiance);
    wave_put(&wave, 1, &start, rng, 0);
    wave_finish(&wave);
    return (double)rgb_luminance(radiance);
}

static void roulette_changes_nothing(void)
{
    enum { SIDE = 24 };
    const uint32_t spp = 256 / STAT_SLOW;
    struct scenes s;
    mixed(&s, SIDE, false);
    const struct stage *stage = scenes_stage(&s);
    /* With the same random numbers paths differ by what roulette does and nothing else. */
    struct stat_mean early = {0}, usual = {0}, none = {0};
    for (uint32_t i = 0; i < SIDE * SIDE; i++) {
        double mean[3] = {0, 0, 0};
        static const uint32_t begin[3] = {UINT32_MAX, PATH_ROULETTE_BEGIN, 0};
        for (int k = 0; k < 3; k++)
            for (uint32_t j = 0; j < spp; j++) {
                const struct rng rng = rng_make(5, i % SIDE, i / SIDE, j);
                const struct ray ray =
                    camera_ray(&stage->camera, (float)(i % SIDE) + .5f, (float)(i / SIDE) + .5f);
                mean[k] += luminance_along(stage, ray, &rng, begin[k]) / spp;
            }
        stat_add(&none, mean[0]);
        stat_add(&usual, mean[1] - mean[0]);
        stat_add(&early, mean[2] - mean[0]);
    }
    const struct means of_usual = means_from_truth(&usual, 0),
                       of_early = means_from_truth(&early, 0);
    const double margin = (STAT_SLOW == 1 ? 0.005 : 0.05) * none.mean;
    ok(means_unequal_p(&of_usual, margin) < 0.01,
       "F-04: roulette does not change the mean: equal within %.1f %% (could prove %.2f %%)",
       100 * margin / none.mean, 100 * means_provable(&of_usual, 0.01) / none.mean);
    ok(means_unequal_p(&of_early, 2 * margin) < 0.01,
       "F-04: nor does it from the first bounce on: equal within %.1f %% (could prove %.2f %%)",
       200 * margin / none.mean, 100 * means_provable(&of_early, 0.01) / none.mean);
    scenes_release(&s);
}

/* --- same pixels --- */

static bool same_sums(const struct film_samples *a, const struct film_samples *b)
{
    const size_t n = (size_t)tile_rect_pixels(a->rect) * FILM_CHANNELS;
    return memcmp(a->sums, b->sums, n * sizeof *a->sums) == 0;
}

static void pixels_do_not_depend_on_company(void)
{
    struct scenes s;
    mixed(&s, 12, true);
    const struct stage *stage = scenes_stage(&s);
    struct arena *a = &s.arena;
    const struct tile_rect all = {0, 0, 12, 12}, one = {5, 7, 6, 8};
    const struct tile_pass pass = {16, 48};
    struct film_samples whole = film_samples_make(all, pass, a);
    struct film_samples again = film_samples_make(all, pass, a);
    struct film_samples alone = film_samples_make(one, pass, a);
    render_tile(stage, &whole);
    for (uint32_t y = 12; y-- > 0;)
        render_row(stage, &again, y);
    render_tile(stage, &alone);
    ok(same_sums(&whole, &again), "rows in any order give the same bits");
    ok(memcmp(alone.sums, whole.sums + (7 * 12 + 5) * FILM_CHANNELS,
              FILM_CHANNELS * sizeof *alone.sums) == 0,
       "a pixel alone has the bits it has in a tile");

    double by_hand[FILM_CHANNELS] = {0}, split[FILM_CHANNELS] = {0}, off = 0, most = 0;
    for (uint32_t i = pass.s_begin; i < pass.s_end; i++) {
        const rgb c = render_sample(stage, 5, 7, i);
        for (uint32_t k = 0; k < 3; k++)
            by_hand[3 * (i % FILM_REPLICATES) + k] += (double)c[k];
        struct film_samples single = film_samples_make(one, (struct tile_pass){i, i + 1}, a);
        render_tile(stage, &single);
        for (int k = 0; k < FILM_CHANNELS; k++)
            split[k] += (double)single.sums[k];
    }
    bool same = true;
    for (int k = 0; k < FILM_CHANNELS; k++) {
        same &= alone.sums[k] == (float)by_hand[k];
        off = fmax(off, fabs(split[k] - (double)alone.sums[k]));
        most = fmax(most, split[k]);
    }
    ok(same, "its sums are those of its samples, in order, each alone");
    ok(off <= most * 0x1p-23, "one pass of 32 and 32 passes of one differ by rounding only");
    scenes_release(&s);
}

/* --- invalid samples --- */

static void invalid_samples_are_noted(void)
{
    struct scenes s;
    mixed(&s, 8, true);
    const struct stage *good = scenes_stage(&s);
    s.scene.shapes[s.scene.shape_count - 1].emission = rgb_gray(3e38f);
    const struct stage *bad = scenes_stage(&s);
    struct film clean, film;
    scenes_render(good, 16, &clean);
    scenes_render(bad, 16, &film);
    bool found = film.invalid_count > 0, finite = true;
    for (uint32_t i = 0; i < film.key_count; i++) {
        const struct film_key k = film.keys[i];
        found &= !(rgb_max(render_sample(bad, k.x_px, k.y_px, k.sample)) < 0x1p+102f);
    }
    for (size_t i = 0; i < 3 * (size_t)tile_rect_pixels(film.window); i++)
        finite &= isfinite(film.sum[i]) && film.sum[i] >= 0;
    ok(clean.invalid_count == 0, "an ordinary scene has no invalid sample");
    ok(found, "samples too bright for a float's sum are noted, and their keys show them again");
    ok(finite, "and count as black");
    film_release(&clean);
    film_release(&film);
    scenes_release(&s);
}

/* A material that is no number: what meets it is noted, every other sample stays as it was. */
static void not_a_number_stays_where_it_is(void)
{
    enum { SIDE = 8, SPP = 16 };
    struct scenes s;
    mixed(&s, SIDE, false);
    const uint32_t one_of_ours = scenes_diffuse(&s, rgb_gray(.5f));
    scenes_disc(&s, one_of_ours, vec3_make(.1f, .3f, 1), vec3_make(0, 0, 1), .2f);
    const struct stage *good = scenes_stage(&s);
    s.scene.materials[one_of_ours].diffuse.albedo = rgb_gray(NAN);
    const struct stage *bad = scenes_stage(&s);
    struct film film;
    scenes_render(bad, SPP, &film);
    uint32_t invalid = 0, other = 0, keys = 0;
    for (uint32_t i = 0; i < SIDE * SIDE * SPP; i++) {
        const uint32_t x = i / SPP % SIDE, y = i / SPP / SIDE, sample = i % SPP;
        const rgb a = render_sample(good, x, y, sample), b = render_sample(bad, x, y, sample);
        if (!isnan(b[0])) {
            other += a[0] != b[0] || a[1] != b[1] || a[2] != b[2];
            continue;
        }
        if (invalid++ < FILM_MAX_KEYS) {
            const struct film_key k = film.keys[invalid - 1];
            keys += k.x_px == x && k.y_px == y && k.sample == sample;
        }
    }
    ok(other == 0, "F-20: a material that is no number changes no sample that does not meet it");
    ok(invalid > FILM_MAX_KEYS && film.invalid_count == invalid && keys == FILM_MAX_KEYS,
       "F-20: the %u that do are counted, the first %u with their keys", invalid, keys);
    film_release(&film);
    scenes_release(&s);
}

/* --- accumulation: 1e8 samples of one pixel --- */

static void sums_stay_exact(void)
{
    const uint32_t count = 100000000 / STAT_SLOW, step = 256;
    struct film film[2];
    struct arena arena = {0};
    const struct tile_rect pixel = {0, 0, 1, 1};
    for (int i = 0; i < 2; i++)
        film_init(&film[i], pixel);
    struct dice dice = dice_make(19);
    for (uint32_t begin = 0; begin < count; begin += step) {
        const struct tile_pass pass = {begin, begin + step};
        struct film_samples half = film_samples_make(pixel, pass, &arena);
        struct film_samples any = film_samples_make(pixel, pass, &arena);
        double sum[FILM_REPLICATES] = {0};
        for (uint32_t i = 0; i < step; i += 2) { /* antithetic, so that chance plays no part */
            const double u = (double)dice_float(&dice);
            sum[i % FILM_REPLICATES] += u;
            sum[(i + 1) % FILM_REPLICATES] += 1 - u;
        }
        for (int k = 0; k < FILM_CHANNELS; k++) {
            half.sums[k] = 0.5f * (float)(step / FILM_REPLICATES);
            any.sums[k] = (float)sum[k / 3];
        }
        film_merge(&film[0], &half);
        film_merge(&film[1], &any);
        arena_reset(&arena);
    }
    for (int i = 0; i < 2; i++) {
        double mean[3];
        film_mean(&film[i], 0, mean);
        near(mean[1], 0.5, 1e-6, "F-19: mean of 1e8 samples: %s",
             i ? "uniform on [0, 1)" : "constant");
        film_release(&film[i]);
    }
    arena_release(&arena);
}

/* --- the error bar --- */

static void error_bars_cover(void)
{
    const uint32_t side = STAT_SLOW == 1 ? 40 : 16;
    struct scenes s;
    scenes_init(&s, side, side);
    const uint32_t wall = scenes_diffuse(&s, rgb_gray(.5f));
    scenes_box(&s, wall, vec3_make(-1, -1, -1), vec3_make(1, 1, 1), true);
    for (uint32_t i = 0; i < s.scene.shape_count; i++)
        s.scene.shapes[i].emission = rgb_gray(1);
    struct film film;
    scenes_render(scenes_stage(&s), 256, &film);
    const size_t pixels = tile_rect_pixels(film.window);
    double covered = 0;
    for (size_t i = 0; i < pixels; i++) {
        double mean[3], error[3];
        film_mean(&film, i, mean);
        estimate_pixel(&film, i, error);
        covered += fabs(mean[0] - 2) <= 2.365 * error[0];
    }
    near(covered / (double)pixels, 0.95, 0.025,
         "95 %% intervals cover the truth in %.1f %% of pixels", 100 * covered / (double)pixels);
    film_release(&film);
    scenes_release(&s);
}

/* Two images of the same scene with other seeds differ by as much as both bars say. Weighted as
 * relMSE is, so that not only the brightest pixels count. */
static void error_bars_are_true(uint32_t spp)
{
    enum { SIDE = 24 };
    const uint32_t pairs = STAT_SLOW == 1 ? 24 : 8;
    double apart = 0, said = 0;
    for (uint32_t k = 0; k < pairs; k++) {
        struct film film[2];
        for (uint32_t i = 0; i < 2; i++) {
            struct scenes s;
            mixed(&s, SIDE, false);
            s.scene.settings.seed = 2 * k + i;
            scenes_render(scenes_stage(&s), spp, &film[i]);
            scenes_release(&s);
        }
        for (size_t p = 0; p < SIDE * SIDE; p++) {
            double mean[2][3], error[2][3];
            for (int i = 0; i < 2; i++) {
                film_mean(&film[i], p, mean[i]);
                estimate_pixel(&film[i], p, error[i]);
            }
            for (int c = 0; c < 3; c++) {
                const double level = mean[0][c] + mean[1][c] + 0.01;
                const double off = (mean[0][c] - mean[1][c]) / level;
                const double bar = hypot(error[0][c], error[1][c]) / level;
                apart += off * off;
                said += bar * bar;
            }
        }
        for (int i = 0; i < 2; i++)
            film_release(&film[i]);
    }
    near(apart / said, 1, 0.1, "squared differences at %u spp over what the bars say of them", spp);
}

int main(void)
{
    agrees_with_naive(0, "smooth glass");
    agrees_with_naive(.3f, "rough glass");
    roulette_changes_nothing();
    pixels_do_not_depend_on_company();
    invalid_samples_are_noted();
    not_a_number_stays_where_it_is();
    sums_stay_exact();
    error_bars_cover();
    error_bars_are_true(16);
    error_bars_are_true(64);
    return tap_done();
}
