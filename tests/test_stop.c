/* stop.c: an error target ends a job neither by luck nor never.
 * SPDX-License-Identifier: MIT */
#include "common/stop.h"

#include <math.h>
#include <string.h>

#include "common/estimate.h"
#include "tests/dice.h"
#include "tests/stat/stat.h"
#include "tests/tap.h"

/* A gray sample; the film's pass sees it with its evidence. */
static void add(struct film_samples *s, size_t pixel, uint32_t sample, double x)
{
    const struct tile_rect r = s->rect;
    const uint32_t width = r.x_end - r.x_begin;
    const size_t block = pixel / width / BLOCK_PX * block_columns(r) + pixel % width / BLOCK_PX;
    block_add(&s->blocks[block], (float)x);
    s->blocks[block].met++;
    for (uint32_t c = 0; c < 3; c++)
        s->sums[pixel * FILM_CHANNELS + sample % FILM_REPLICATES * 3 + c] += (float)x;
}

/* Whole rounds of samples until the target is met, or spp; returns the spp. */
static uint32_t run(struct film *f, uint32_t side_px, double target, uint32_t spp,
                    double (*sample)(struct dice *), struct dice *d)
{
    struct arena arena = {0};
    uint32_t done = 0;
    film_init(f, (struct tile_rect){0, 0, side_px, side_px});
    for (uint32_t p = 0; p < tile_pass_count(spp) && !(p && stop_is_due(f, target)); p++) {
        struct film_samples s = film_samples_make(f->window, tile_pass_of(p, spp), &arena);
        for (size_t i = 0; i < tile_rect_pixels(f->window); i++)
            for (uint32_t k = s.pass.s_begin; k < s.pass.s_end; k++)
                add(&s, i, k, sample(d));
        film_merge(f, &s);
        done = s.pass.s_end;
        arena_reset(&arena);
    }
    arena_release(&arena);
    return done;
}

static double mean_of(const struct film *f)
{
    double sum = 0;
    for (size_t i = 0; i < tile_rect_pixels(f->window); i++)
        sum += f->sum[3 * i] / f->spp[i];
    return sum / tile_rect_pixels(f->window);
}

static double rare(struct dice *d)
{
    return dice_unit(d) < 1 / 200. ? 200 : 0;
}

static double even(struct dice *d)
{
    return 1 + .5 * (dice_unit(d) - .5);
}

static double black(struct dice *d)
{
    (void)d;
    return 0;
}

/* One pixel, and 8 x 8 of them. The laxest target there is: it is met as soon as it may be. */
static void rare_light(uint32_t side_px, uint32_t repeats)
{
    struct stat_mean mean = {0}, spp = {0};
    for (uint32_t i = 0; i < repeats; i++) {
        struct dice d = dice_make(i + 1);
        struct film f;
        stat_add(&spp, run(&f, side_px, 1, 1 << 20, rare, &d));
        stat_add(&mean, mean_of(&f));
        film_release(&f);
    }
    near(mean.mean, 1, .01 + 3 * stat_error(&mean),
         "F-35: light of one sample in 200, %u px: the mean of %u jobs, which took %.0f spp",
         side_px * side_px, repeats, spp.mean);
    near(mean.mean, 1, .01, "F-35: within 1 %%");
}

static void quiet(void)
{
    struct dice d = dice_make(5);
    struct film f;
    ok(run(&f, 16, .5, 1 << 20, even, &d) == 8, "what is quiet ends after the first round");
    film_release(&f);
    const uint32_t spp = run(&f, 16, .005, 1 << 20, even, &d); /* sqrt(1/48 / n) = .005: n = 833 */
    ok(spp >= 768 && spp <= 1280, "and a strict target with as many as it takes: %u", spp);
    ok(estimate_error(&f) <= .005, "the target is met");
    film_release(&f);
}

static void darkness(void)
{
    struct dice d = dice_make(6);
    struct film f;
    ok(run(&f, 8, .1, 1 << 20, black, &d) == STOP_DARK_SPP, "black may be chance for a while");
    for (size_t i = 0; i < block_count(f.window); i++)
        f.blocks[i].met = 0;
    for (size_t i = 0; i < tile_rect_pixels(f.window); i++)
        f.spp[i] = 8;
    ok(stop_is_due(&f, .1), "but not where there is nothing");
    film_release(&f);
    ok(run(&f, 8, .1, 64, black, &d) == 64, "the cap holds");
    film_release(&f);
}

int main(void)
{
    rare_light(8, 1024);
    rare_light(1, 1024);
    quiet();
    darkness();
    return tap_done();
}
