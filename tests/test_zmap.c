/* stat/zmap.h: right images pass at the stated rate, wrong ones are found at the stated power.
 * SPDX-License-Identifier: MIT */
#include "tests/stat/zmap.h"

#include <math.h>

#include "common/estimate.h"
#include "tests/dice.h"
#include "tests/scenes.h"
#include "tests/tap.h"

enum { SIDE = 12, REPLICATES = 8, BIG = 64 };
static const double level = 0.01;

/* What is wrong with an image; lengths in standard errors of a pixel's mean. */
struct fault {
    double all;     /* every pixel is off by so much */
    double one;     /* one pixel */
    double common;  /* noise that all replicates of a pixel share */
    double learnt;  /* the "truth" is drawn towards the image by this share */
    double unknown; /* error of the truth, which the map is told */
};

static struct zmap noisy(struct dice *dice, const struct fault *f)
{
    static double mean[SIDE * SIDE * REPLICATES], truth[SIDE * SIDE], error[SIDE * SIDE];
    for (size_t i = 0; i < SIDE * SIDE; i++) {
        const double value = dice_unit(dice), sd = 0.01 + dice_unit(dice); /* of a replicate */
        const double unit = sd / sqrt(REPLICATES);
        double off = f->common * dice_normal(dice) * unit + f->all * unit, sum = 0;
        off += i == 37 ? f->one * unit : 0;
        for (size_t r = 0; r < REPLICATES; r++)
            sum += mean[i * REPLICATES + r] = value + off + sd * dice_normal(dice);
        error[i] = f->unknown * unit;
        truth[i] = value + dice_normal(dice) * error[i];
        truth[i] += f->learnt * (sum / REPLICATES - value);
    }
    const struct zmap_image im = {SIDE, SIDE, REPLICATES, mean, NULL, truth, error};
    return zmap_make(&im, level);
}

static uint32_t sets;

/* Three standard deviations of a rate near 1 or 99 %. */
static double slack(void)
{
    return 3 * sqrt(0.01 * 0.99 / sets);
}

static double failures(struct fault f)
{
    struct dice dice = dice_make(1);
    uint32_t failed = 0;
    for (uint32_t i = 0; i < sets; i++) {
        const struct zmap map = noisy(&dice, &f);
        failed += !zmap_passes(&map, level);
    }
    return (double)failed / sets;
}

static void rates(void)
{
    struct dice dice = dice_make(2);
    const struct zmap map = noisy(&dice, &(struct fault){0});
    ok(map.judged == SIDE * SIDE && map.blocks == 0 && map.unjudged == 0, "every pixel is judged");
    near(failures((struct fault){0}), level, slack(), "1 %% of %u right images fail", sets);
    ok(failures((struct fault){.unknown = 0.2}) <= level + slack() &&
           failures((struct fault){.unknown = 1}) <= level + slack(),
       "no more of those whose truth has an error, of a fifth of theirs or as much");
    const double all = zmap_detects_all(&map), one = zmap_detects_one(&map, REPLICATES, level);
    const double caught = STAT_POWER - slack();
    ok(failures((struct fault){.all = all}) >= caught,
       "a bias of every pixel by %.3f standard errors is found in 99 %%", all);
    near(failures((struct fault){.one = one}), STAT_POWER, slack(),
         "and of one of %zu pixels by %.1f", map.judged, one);
    ok(failures((struct fault){.common = 1.5}) >= caught,
       "replicates are found not to be independent when most of the noise is common");
    ok(failures((struct fault){.learnt = 0.5}) >= caught,
       "a truth that was half learnt from the image is found");
}

/* Samples of 100 with a chance of 1 in 100, else 0: what a light seen through a keyhole gives. */
static struct zmap rare(struct dice *dice, uint32_t spp, bool blocks)
{
    static double mean[BIG * BIG * REPLICATES], truth[BIG * BIG], n_eff[BIG * BIG];
    for (size_t i = 0; i < BIG * BIG; i++) {
        n_eff[i] = 0;
        truth[i] = 1;
        for (size_t r = 0; r < REPLICATES; r++) {
            int hits = 0;
            for (uint32_t s = 0; s < spp / REPLICATES; s++)
                hits += dice_unit(dice) < 0.01;
            mean[i * REPLICATES + r] = 100.0 * hits / (spp / REPLICATES);
            n_eff[i] += hits; /* (100 hits)^2 / (100^2 hits) */
        }
    }
    const struct zmap_image im = {BIG, BIG, REPLICATES, mean, blocks ? n_eff : NULL, truth, NULL};
    return zmap_make(&im, level);
}

static void rare_samples(void)
{
    struct dice dice = dice_make(3);
    uint32_t wrong = 0, right = 0, blocks = 0;
    const uint32_t images = 20;
    for (uint32_t i = 0; i < images; i++) {
        const struct zmap pixels = rare(&dice, 64, false), pooled = rare(&dice, 128, true);
        wrong += !zmap_passes(&pixels, level);
        right += zmap_passes(&pooled, level);
        blocks += pooled.blocks == BIG * BIG / 64;
    }
    ok(wrong == images, "rare samples: pixel by pixel right images fail");
    ok(blocks == images && right >= images - 1, "but pass by blocks of 8 x 8 (%u of %u)", right,
       images);
    const struct zmap dark = rare(&dice, 8, true);
    ok(dark.judged + dark.unjudged == BIG * BIG / 64 && dark.unjudged > 60 &&
           !zmap_passes(&dark, level),
       "and where blocks have less than 32 effective samples, nothing is judged, nothing passes");
}

static void corners(void)
{
    double mean[24 * 2], truth[24];
    for (size_t i = 0; i < 24; i++) {
        truth[i] = 1;
        mean[2 * i] = mean[2 * i + 1] = 1;
    }
    const struct zmap_image im = {24, 1, 2, mean, NULL, truth, NULL};
    const struct zmap quiet = zmap_make(&im, level);
    ok(quiet.exact == 24 && quiet.judged == 0, "pixels without noise that are true are told apart");
    struct dice dice = dice_make(4);
    for (size_t i = 0; i < 48; i++)
        mean[i] += dice_normal(&dice);
    const struct zmap fine = zmap_make(&im, level);
    mean[20] = (double)NAN;
    const struct zmap lost = zmap_make(&im, level);
    ok(zmap_passes(&fine, level) && !zmap_passes(&lost, level),
       "one pixel that is no number fails");
    mean[20] = mean[21] = 1.5;
    const struct zmap off = zmap_make(&im, level);
    ok(off.outside == 1 && !zmap_passes(&off, level), "and one without noise that is off");
}

/* --- a rendered image: inside of a white-hot cube every pixel is Le / (1 - albedo) --- */

enum { FILM = 40 };

static struct zmap rendered(const struct film *film, double truth, bool reused)
{
    static double mean[FILM * FILM * FILM_REPLICATES], truths[FILM * FILM];
    for (size_t i = 0; i < FILM * FILM; i++) {
        truths[i] = truth;
        for (size_t r = 0; r < FILM_REPLICATES; r++) {
            const size_t from = reused ? r / 2 : r; /* each seed twice */
            mean[i * FILM_REPLICATES + r] =
                (double)film->replicate[3 * (i * FILM_REPLICATES + from) + 1] /
                film_replicate_spp(film->spp[i], (uint32_t)from);
        }
    }
    const struct zmap_image im = {FILM, FILM, FILM_REPLICATES, mean, NULL, truths, NULL};
    return zmap_make(&im, level);
}

static void rendered_image(void)
{
    struct scenes s;
    scenes_init(&s, FILM, FILM);
    const uint32_t wall = scenes_diffuse(&s, rgb_gray(.5f));
    scenes_box(&s, wall, vec3_make(-1, -1, -1), vec3_make(1, 1, 1), true);
    for (uint32_t i = 0; i < s.scene.shape_count; i++)
        s.scene.shapes[i].emission = rgb_gray(1);
    s.scene.settings.max_bounces = 10000;
    struct film film;
    scenes_render(scenes_stage(&s), 256, &film);
    struct stat_mean error = {0};
    for (size_t i = 0; i < FILM * FILM; i++) {
        double e[3];
        estimate_pixel(&film, i, e);
        stat_add(&error, e[1]);
    }
    const struct zmap map = rendered(&film, 2, false);
    const double bias = zmap_detects_all(&map) * error.mean;
    ok(zmap_passes(&map, level),
       "a rendered furnace is right in every pixel: %zu outside, mean %.3f, variance %.3f, p %.3f",
       map.outside, map.mean, map.variance, map.ks_p);
    const struct zmap more = rendered(&film, 2 - bias, false);
    ok(!zmap_passes(&more, level), "and found to be wrong with a bias of %.3f %%", 50 * bias);
    const struct zmap reused = rendered(&film, 2, true);
    ok(!zmap_passes(&reused, level), "or when each seed is used for two replicates (variance %.2f)",
       reused.variance);
    film_release(&film);
    scenes_release(&s);
}

int main(void)
{
    sets = stat_tries(1000, 10000);
    rates();
    rare_samples();
    corners();
    rendered_image();
    return tap_done();
}
