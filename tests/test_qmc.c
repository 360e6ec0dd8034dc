/* Row F-32 of docs/accuracy.md: spread points against independent ones, at any number of samples;
 * noise that has no pattern; numbers for any depth.
 * SPDX-License-Identifier: MIT */
#include <math.h>
#include <stdlib.h>

#include "common/trace/camera.h"
#include "common/trace/path.h"
#include "tests/scenes.h"
#include "tests/stat/chi2.h"
#include "tests/stat/stat.h"
#include "tests/tap.h"

enum { SIDE = 12, PIXELS = SIDE * SIDE };

/* --- scenes: what a pixel's noise is made of differs --- */

static void room(struct scenes *s)
{
    const uint32_t white = scenes_diffuse(s, rgb_gray(.7f));
    scenes_look(s, vec3_make(0, 1, 3.4f), vec3_make(0, .8f, 0), .8);
    scenes_box(s, white, vec3_make(-1.5f, 0, -1.5f), vec3_make(1.5f, 2, 4), true);
    scenes_sphere(s, scenes_metal(s, rgb_gray(.2f), rgb_gray(3.9f), .15f),
                  vec3_make(-.7f, .5f, -.5f), .5f);
    scenes_quad(s, white, vec3_make(-.5f, 1.95f, -.5f), vec3_make(1, 0, 0), vec3_make(0, 0, 1))
        ->emission = rgb_gray(5);
}

static void sky(struct scenes *s)
{
    const uint32_t ground = scenes_diffuse(s, rgb_gray(.5f));
    scenes_look(s, vec3_make(0, 2, 6), vec3_make(0, .5f, 0), .6);
    scenes_quad(s, ground, vec3_make(-9, 0, 9), vec3_make(18, 0, 0), vec3_make(0, 0, -18));
    scenes_ball(s, ground, vec3_make(0, 1, 0), 1, 8, .3f, false);
    scenes_sky(s, rgb_gray(1));
}

static void plates(struct scenes *s)
{
    scenes_look(s, vec3_make(0, 2, 4), vec3_make(0, .1f, 0), .5); /* the lights are out of sight */
    const uint32_t black = scenes_diffuse(s, rgb_gray(0));
    for (int i = 0; i < 4; i++) {
        const float z = 1.5f - (float)i;
        scenes_quad(s, scenes_metal(s, rgb_gray(.2f), rgb_gray(3.9f), .02f * powf(2, (float)i)),
                    vec3_make(-2, .1f * (float)i, z), vec3_make(4, 0, 0), vec3_make(0, .2f, -.8f));
        scenes_sphere(s, black, vec3_make((float)i - 1.5f, 2, -3), .1f * powf(1.8f, (float)i))
            ->emission = rgb_gray(powf(3, 3 - (float)i));
    }
    scenes_sky(s, rgb_gray(.05f));
}

static void glass(struct scenes *s)
{
    scenes_look(s, vec3_make(0, 1.5f, 4), vec3_make(0, .6f, 0), .7);
    const uint32_t white = scenes_diffuse(s, rgb_gray(.7f));
    scenes_quad(s, white, vec3_make(-9, 0, 9), vec3_make(18, 0, 0), vec3_make(0, 0, -18));
    scenes_sphere(s, scenes_glass(s, 1.5f), vec3_make(0, .7f, 0), .7f);
    scenes_quad(s, white, vec3_make(-1, 3, -1), vec3_make(2, 0, 0), vec3_make(0, 0, 2))->emission =
        rgb_gray(3);
    scenes_sky(s, rgb_gray(.3f));
}

/* --- variances --- */

/* Two samples of a pixel that share a camera ray, as siblings do, with numbers that no other has.
 */
static void two_alone(const struct stage *stage, uint32_t pixel, uint32_t i, double light[2])
{
    struct wave_starts starts;
    struct rng rngs[2];
    rgb radiance[2];
    for (uint32_t k = 0; k < 2; k++)
        rngs[k] = rng_make(1000 + pixel, i & 0xffff, i >> 16, k); /* replicates k */
    const struct square q = rng_pair(&rngs[0], RNG_FILTER);
    const struct ray ray =
        camera_ray(&stage->camera, (float)(pixel % SIDE) + q.u, (float)(pixel / SIDE) + q.v);
    const struct ray rays[2] = {ray, ray};
    wave_begin(stage, 3, rays, rngs, &starts);
    scenes_follow(stage, 3, &starts, rngs, PATH_ROULETTE_BEGIN, radiance);
    for (int k = 0; k < 2; k++)
        light[k] = (double)rgb_luminance(radiance[k]);
}

struct noise { /* of independent samples, and of independent pairs of them, by pixel */
    double mean[PIXELS], one[PIXELS], pair[PIXELS];
};

static void noise_make(struct noise *n, const struct stage *stage, uint32_t count)
{
    for (uint32_t pixel = 0; pixel < PIXELS; pixel++) {
        struct stat_mean one = {0}, pair = {0};
        for (uint32_t i = 0; i < count; i++) {
            double light[2];
            two_alone(stage, pixel, i, light);
            stat_add(&one, light[i % 2]);
            stat_add(&pair, 0.5 * (light[0] + light[1]));
        }
        n->mean[pixel] = pair.mean;
        n->one[pixel] = stat_variance(&one);
        n->pair[pixel] = stat_variance(&pair);
    }
}

/* Of the mean of so many samples, as many of them siblings as the sampler makes: samples 16 k + r
 * and 16 k + 8 + r (rng.h). */
static double independent(const struct noise *n, uint32_t pixel, uint32_t spp)
{
    const uint32_t rest = spp % 16, pairs = spp / 16 * 8 + (rest > 8 ? rest - 8 : 0);
    return (4.0 * pairs * n->pair[pixel] + (spp - 2.0 * pairs) * n->one[pixel]) / spp / spp;
}

struct images { /* of many seeds at one number of samples */
    struct stat_mean pixel[PIXELS];
    double *value; /* [image][pixel] */
};

static void render(struct scenes *s, uint32_t spp, uint32_t count, struct images *im)
{
    for (uint32_t k = 0; k < count; k++) {
        struct film film;
        s->scene.settings.seed = 50 + k;
        scenes_render(scenes_stage(s), spp, &film);
        for (uint32_t p = 0; p < PIXELS; p++) {
            double mean[3];
            film_mean(&film, p, mean);
            im->value[k * PIXELS + p] = .2126 * mean[0] + .7152 * mean[1] + .0722 * mean[2];
            stat_add(&im->pixel[p], im->value[k * PIXELS + p]);
        }
        film_release(&film);
    }
}

/* Correlation of the errors of pixels side by side. */
static double neighbours(const struct images *im, uint32_t count)
{
    double sum = 0;
    int n = 0;
    for (uint32_t p = 0; p < PIXELS; p++) {
        if (p % SIDE == SIDE - 1)
            continue;
        const struct stat_mean *a = &im->pixel[p], *b = &im->pixel[p + 1];
        const double scale = sqrt(a->square * b->square);
        double both = 0;
        for (uint32_t k = 0; k < count; k++)
            both +=
                (im->value[k * PIXELS + p] - a->mean) * (im->value[k * PIXELS + p + 1] - b->mean);
        if (scale > 0) {
            sum += both / scale;
            n++;
        }
    }
    return n ? sum / n : 0;
}

static void compare(void (*make)(struct scenes *), const char *name)
{
    static const uint32_t spp[] = {7, 16, 32, 100};
    const uint32_t seeds = max_u32(8, stat_tries(48, 320));
    struct scenes s;
    static struct noise noise;
    scenes_init(&s, SIDE, SIDE);
    make(&s);
    noise_make(&noise, scenes_stage(&s), stat_tries(3000, 20000));
    for (size_t i = 0; i < countof(spp); i++) {
        struct images im = {.value = calloc((size_t)seeds * PIXELS, sizeof *im.value)};
        render(&s, spp[i], seeds, &im);
        double spread = 0, alike = 0, alone = 0;
        for (uint32_t p = 0; p < PIXELS; p++) {
            const double level = noise.mean[p] * noise.mean[p] + 1e-4;
            spread += stat_variance(&im.pixel[p]) / level;
            alike += independent(&noise, p, spp[i]) / level;
            alone += noise.one[p] / spp[i] / level;
        }
        const double pattern = neighbours(&im, seeds);
        ok(spread <= (STAT_SLOW == 1 ? 1.05 : 2) * alike,
           "F-32: %s, %u spp: %.2f of the variance of independent numbers (with a camera ray for "
           "each "
           "sample: %.2f)",
           name, spp[i], spread / alike, spread / alone);
        ok(fabs(pattern) < (STAT_SLOW == 1 ? .05 : .3),
           "F-32: %s, %u spp: errors of neighbours correlate by %.3f", name, spp[i], pattern);
        free(im.value);
    }
    scenes_release(&s);
}

/* --- numbers for any depth --- */

/* Every pair of the dimensions 0 to 255, one point from each of many pixels. */
static void dimensions_in_pairs(void)
{
    enum { DIMENSIONS = 256, CELLS = 8, MOST_POINTS = 1 << 14 };
    static float u[MOST_POINTS][DIMENSIONS];
    static double due[CELLS * CELLS];
    const uint32_t points = stat_tries(1 << 11, MOST_POINTS);
    for (uint32_t i = 0; i < points; i++) {
        const struct rng r = rng_make(8, i & 0xff, i >> 8, i % FILM_REPLICATES);
        for (uint32_t d = 0; d < DIMENSIONS; d++)
            u[i][d] = rng_single(&r, d);
    }
    for (int k = 0; k < CELLS * CELLS; k++)
        due[k] = (double)points / (CELLS * CELLS);
    const double level = stat_sidak(0.01, DIMENSIONS * (DIMENSIONS - 1) / 2);
    double least = 1, detects = 0;
    for (uint32_t d = 0; d < DIMENSIONS; d++)
        for (uint32_t e = d + 1; e < DIMENSIONS; e++) {
            uint32_t seen[CELLS * CELLS] = {0};
            for (uint32_t i = 0; i < points; i++)
                seen[(int)(u[i][d] * CELLS) * CELLS + (int)(u[i][e] * CELLS)]++;
            const struct chi2 c = chi2_test(due, seen, CELLS * CELLS);
            least = fmin(least, c.p);
            detects = e == 1 ? chi2_detects(&c, points, level) : detects;
        }
    ok(least > level,
       "F-32: dimensions 0 to 255 are pairwise independent (least p %.2g of %.2g, detects %.2f "
       "rms)",
       least, level, detects);
}

/* 100 panes, 200 surfaces: a path of n of them uses dimension 4 n. Incoherent, without loss:
 * T = (1 - r) / (1 + (panes - 1) r), r = 2 F / (1 + F) of each. */
static void deep_glass(void)
{
    enum { PANES = 100 };
    struct scenes s;
    struct film film;
    scenes_init(&s, 8, 8);
    s.scene.settings.max_bounces = 10000;
    scenes_look(&s, vec3_make(0, 0, 1), vec3_make(0, 0, 0), 1e-3);
    const uint32_t glass_of = scenes_glass(&s, 1.5f);
    const vec3 x = vec3_make(40, 0, 0), y = vec3_make(0, 40, 0);
    for (int i = 0; i < PANES; i++) {
        const float z = -.1f * (float)i;
        scenes_quad(&s, glass_of, vec3_make(-20, -20, z), x, y);
        scenes_quad(&s, glass_of, vec3_make(-20, -20, z - .05f), y, x);
    }
    scenes_quad(&s, scenes_diffuse(&s, rgb_gray(0)), vec3_make(-20, -20, -11), x, y)->emission =
        rgb_gray(1);
    const double f = .04, r = 2 * f / (1 + f), truth = (1 - r) / (1 + (PANES - 1) * r);
    scenes_render(scenes_stage(&s), stat_tries(768, 20 * 768), &film);
    const struct scenes_mean m = scenes_mean(&film, 1);
    const double detects = 6.23 * m.error / truth;
    ok(fabs(m.mean - truth) < 3.9 * m.error && detects < (STAT_SLOW > 1    ? 1
                                                          : stat_is_long() ? .02
                                                                           : .1),
       "F-32: %d panes of glass let %.5f through: %.5f (detects %.1f %%)", PANES, truth, m.mean,
       100 * detects);
    ok(film.invalid_count == 0, "F-32: and no sample is invalid");
    film_release(&film);
    scenes_release(&s);
}

int main(void)
{
    compare(room, "room");
    compare(sky, "sky");
    compare(plates, "plates");
    compare(glass, "glass");
    dimensions_in_pairs();
    deep_glass();
    return tap_done();
}
