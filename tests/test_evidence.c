/* evidence.c, block.c: what few samples, heavy tails and outliers do to error bars, and what is
 * said of them. SPDX-License-Identifier: MIT */
#include "common/evidence.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "common/estimate.h"
#include "tests/dice.h"
#include "tests/local.h"
#include "tests/scenes.h"
#include "tests/stat/stat.h"
#include "tests/tap.h"

/* ---- laws whose moments are known ---- */

enum law { UNIFORM, EXPONENTIAL, PARETO_3, RARE_EXPONENTIAL, BERNOULLI, PARETO_1_5, PARETO_1_8 };

static const char *const law_names[] = {"uniform",         "exponential",    "Pareto 3",
                                        "5 % exponential", "Bernoulli 1e-3", "Pareto 1.5",
                                        "Pareto 1.8"};

static double draw(enum law law, struct dice *d)
{
    const double u = 1 - dice_unit(d);
    switch (law) {
    case UNIFORM:
        return u;
    case EXPONENTIAL:
        return -log(u);
    case PARETO_3:
        return pow(u, -1 / 3.);
    case RARE_EXPONENTIAL:
        return dice_unit(d) < .05 ? -log(u) : 0;
    case BERNOULLI:
        return u < 1e-3 ? 1 : 0;
    case PARETO_1_5:
        return pow(u, -1 / 1.5);
    case PARETO_1_8:
        return pow(u, -1 / 1.8);
    }
    __builtin_unreachable();
}

static double level_at(uint32_t x, uint32_t y)
{
    return 1 + x / 16 + y / 32;
}

/* A pass of samples of a law, gray, scaled by the pixel's place so that blocks differ. */
static void fill(struct film_samples *s, enum law law, struct dice *d)
{
    const struct tile_rect r = s->rect;
    float *sums = s->sums;
    for (uint32_t y = r.y_begin; y < r.y_end; y++)
        for (uint32_t x = r.x_begin; x < r.x_end; x++, sums += FILM_CHANNELS) {
            struct block *b = &s->blocks[(y - r.y_begin) / BLOCK_PX * block_columns(r) +
                                         (x - r.x_begin) / BLOCK_PX];
            const double level = level_at(x, y);
            b->met += s->pass.s_end - s->pass.s_begin;
            for (uint32_t i = s->pass.s_begin; i < s->pass.s_end; i++) {
                const float v = (float)(level * draw(law, d));
                block_add(b, v);
                for (uint32_t c = 0; c < 3; c++)
                    sums[i % FILM_REPLICATES * 3 + c] += v;
            }
        }
}

static void film_of(struct film *f, uint32_t side_px, uint32_t spp, enum law law, struct dice *d)
{
    struct arena arena = {0};
    film_init(f, (struct tile_rect){3, 5, 3 + side_px, 5 + side_px});
    for (uint32_t p = 0; p < tile_pass_count(spp); p++) {
        struct film_samples s = film_samples_make(f->window, tile_pass_of(p, spp), &arena);
        fill(&s, law, d);
        film_merge(f, &s);
        arena_reset(&arena);
    }
    arena_release(&arena);
}

static const double law_means[] = {.5, 1, 1.5, .05, 1e-3, 3, 1.8 / .8};

/* Tiles of 64 x 64 pixels: how many have a tenth of their pixels flagged, or are mostly unknown. */
struct verdicts {
    uint32_t tiles, flagged, unknown;
    double bars[2], held[2]; /* of pixels that are not trusted, that are: 95 % intervals, and
                              * those that hold the truth */
};

static void count_bars(const struct film *f, const struct evidence *e, enum law law,
                       struct verdicts *v)
{
    const struct tile_rect w = f->window;
    for (uint32_t y = w.y_begin; y < w.y_end; y++)
        for (uint32_t x = w.x_begin; x < w.x_end; x++) {
            const size_t pixel = (size_t)(y - w.y_begin) * (w.x_end - w.x_begin) + x - w.x_begin;
            const size_t block =
                (y - w.y_begin) / BLOCK_PX * e->columns + (x - w.x_begin) / BLOCK_PX;
            const bool trusted = e->blocks[block].verdict == EVIDENCE_TRUSTED;
            double mean[3], error[3];
            film_mean(f, pixel, mean);
            estimate_pixel(f, pixel, error);
            v->bars[trusted]++;
            v->held[trusted] += fabs(mean[0] - level_at(x, y) * law_means[law]) <= 2.365 * error[0];
        }
}

static struct verdicts verdicts_of(enum law law, uint32_t spp, uint32_t tiles)
{
    struct verdicts v = {.tiles = tiles};
    for (uint32_t i = 0; i < tiles; i++) {
        struct arena arena = {0};
        struct dice d = dice_make(1000 * (uint64_t)law + i);
        struct film f;
        film_of(&f, 64, spp, law, &d);
        const struct evidence e = evidence_make(&f, &arena);
        v.flagged += e.heavy > .1;
        v.unknown += e.unknown > .5;
        count_bars(&f, &e, law, &v);
        film_release(&f);
        arena_release(&arena);
    }
    return v;
}

static double percent(double part, double of)
{
    return of > 0 ? 100 * part / of : 0;
}

static void law_at(enum law law, uint32_t spp, uint32_t tiles)
{
    const struct verdicts v = verdicts_of(law, spp, tiles);
    diag(
        "%s, %u spp: %u of %u tiles flagged, %u unknown; %.0f %% of the bars are trusted, of which "
        "%.1f %% hold; of the others %.1f %%",
        law_names[law], spp, v.flagged, v.tiles, v.unknown,
        percent(v.bars[1], v.bars[0] + v.bars[1]), percent(v.held[1], v.bars[1]),
        percent(v.held[0], v.bars[0]));
    if (law >= PARETO_1_5) /* the nearer to 2, the less sure */
        ok(v.flagged >= (law == PARETO_1_5 || stat_is_long() ? .95 : .8) * v.tiles,
           "F-33: %s, %u spp: tiles without a variance are flagged", law_names[law], spp);
    else
        ok(v.flagged <= .05 * v.tiles, "F-33: %s, %u spp: tiles with one are not", law_names[law],
           spp);
    if (v.bars[1] > .05 * (v.bars[0] + v.bars[1]))
        ok(v.held[1] >= .91 * v.bars[1], "%s, %u spp: trusted bars hold", law_names[law], spp);
    if (law == BERNOULLI && spp == 16)
        ok(v.unknown == v.tiles, "what few samples bring is not known");
    if (law <= EXPONENTIAL && spp >= 64)
        ok(v.unknown == 0, "%s: what all samples bring is", law_names[law]);
}

static void laws(void)
{
    for (enum law law = UNIFORM; law <= PARETO_1_8; law++)
        for (uint32_t spp = 16; spp <= (law <= PARETO_3 ? 256 : 64); spp *= 4)
            law_at(law, spp, spp > 64 ? stat_tries(3, 15) : stat_tries(20, 60));
}

/* ---- Hill's estimate itself ---- */

static int falling(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x < y) - (x > y);
}

static void hill(void)
{
    enum { COUNT = 65536, KEPT = 256 };
    static double values[COUNT];
    struct dice d = dice_make(7);
    static const double indices[] = {1, 1.5, 2, 3, 5};
    for (size_t i = 0; i < countof(indices); i++) {
        for (size_t k = 0; k < COUNT; k++)
            values[k] = pow(1 - dice_unit(&d), -1 / indices[i]);
        qsort(values, COUNT, sizeof *values, falling);
        near(evidence_hill(values, KEPT) / indices[i], 1, .2,
             "Hill's estimate of a tail of index %g", indices[i]); /* 1 / sqrt 256, three times */
    }
    for (size_t k = 0; k < 10; k++)
        values[k] = .25;
    ok(isinf(evidence_hill(values, 5)), "equal values have no tail");
}

/* ---- single blocks ---- */

static struct evidence_block verdict_of(const struct block *b, uint32_t spp,
                                        const float variance[BLOCK_DOUBLINGS])
{
    struct arena arena = {0};
    struct film f;
    film_init(&f, (struct tile_rect){0, 0, 8, 8});
    for (size_t i = 0; i < 64; i++)
        f.spp[i] = spp;
    f.blocks[0] = *b;
    if (variance)
        memcpy(f.variance, variance, BLOCK_DOUBLINGS * sizeof *variance);
    const struct evidence_block v = evidence_make(&f, &arena).blocks[0];
    film_release(&f);
    arena_release(&arena);
    return v;
}

static void blocks(void)
{
    struct block b = {0};
    ok(verdict_of(&b, 8, NULL).verdict == EVIDENCE_TRUSTED, "where nothing is, black is black");
    b.met = 1;
    ok(verdict_of(&b, 8, NULL).verdict == EVIDENCE_UNKNOWN,
       "where something is, black may be chance");
    b = (struct block){.met = 512};
    for (int i = 0; i < 512; i++)
        block_add(&b, .75f);
    struct evidence_block v = verdict_of(&b, 8, NULL);
    ok(v.verdict == EVIDENCE_TRUSTED && v.neff == 512, "equal samples all count");
    struct block one = b;
    block_add(&one, 60);
    ok(verdict_of(&one, 8, NULL).verdict == EVIDENCE_HEAVY,
       "one that brings a tenth of all is flagged");
    b = (struct block){.met = 512};
    for (int i = 0; i < 31; i++)
        block_add(&b, 1);
    v = verdict_of(&b, 8, NULL);
    ok(v.verdict == EVIDENCE_UNKNOWN && v.neff == 31, "31 that count are too few");
    block_add(&b, 1);
    ok(verdict_of(&b, 8, NULL).verdict == EVIDENCE_TRUSTED, "32 are enough");
    static const float growing[] = {1, 1.6f, 2.5f, 4}, wavering[] = {1, 1.6f, 2.3f, 4};
    ok(verdict_of(&b, 64, growing).verdict == EVIDENCE_HEAVY,
       "three times grown by half is flagged");
    ok(verdict_of(&b, 64, wavering).verdict == EVIDENCE_TRUSTED, "a little less is not");
}

static void the_largest(void)
{
    struct dice d = dice_make(3);
    struct block all = {0}, parts[3] = {{0}}, merged = {0};
    float values[300];
    for (int i = 0; i < 300; i++) {
        values[i] = i % 7 ? dice_float(&d) : .5f;
        block_add(&all, values[i]);
        block_add(&parts[i / 100], values[i]);
    }
    for (int i = 0; i < 3; i++)
        block_merge(&merged, &parts[i]);
    ok(!memcmp(all.top, merged.top, sizeof all.top), "the largest of parts are the largest of all");
    bool right = true;
    for (uint32_t k = 0; k < BLOCK_TOP; k++) {
        uint32_t above = 0;
        for (int i = 0; i < 300; i++)
            above += values[i] > all.top[k];
        right &= above <= k && (k == 0 || all.top[k] <= all.top[k - 1]);
    }
    ok(right, "they are the largest, falling");
}

/* ---- rendered ---- */

/* A floor and a disc that shines and cuts it, upright or leaning over it, seen along the corner in
 * two regions of 64 x 64 pixels: by light sampling alone, which is by area on discs, the
 * contributions near the corner go like 1 / r^2, and have no variance; by MIS they do. */
static uint32_t corner_flagged(enum strategy_kind strategy, float lean, uint64_t seed, uint32_t spp)
{
    struct scenes s;
    scenes_init(&s, 128, 64);
    const uint32_t gray = scenes_diffuse(&s, rgb_gray(.7f));
    scenes_quad(&s, gray, (vec3){-4, 0, 4}, (vec3){8, 0, 0}, (vec3){0, 0, -4});
    scenes_disc(&s, gray, (vec3){0, 0, 0}, vec3_unit((vec3){0, -lean, 2}), 4)->emission =
        rgb_gray(1);
    s.scene.settings.strategy = strategy;
    s.scene.settings.seed = seed;
    scenes_look(&s, (vec3){0, 1.5f, 2}, (vec3){0, 0, .2f}, .6);
    struct film f;
    struct arena arena = {0};
    scenes_render(scenes_stage(&s), spp, &f);
    const struct evidence e = evidence_make(&f, &arena);
    uint32_t heavy[2] = {0, 0};
    for (uint32_t i = 0; i < e.columns * e.rows; i++)
        heavy[i % e.columns >= e.columns / 2] += e.blocks[i].verdict == EVIDENCE_HEAVY;
    film_release(&f);
    arena_release(&arena);
    scenes_release(&s);
    return (heavy[0] > 6) + (heavy[1] > 6); /* of 64 blocks; 8 touch the corner */
}

static void corners(void)
{
    const uint32_t seeds = stat_tries(2, 20);
    uint32_t bad = 0, good = 0;
    for (uint32_t seed = 1; seed <= seeds; seed++)
        for (int lean = 0; lean < 2; lean++) {
            bad += corner_flagged(STRATEGY_LIGHT, .5f * (float)lean, seed, 64);
            good += corner_flagged(STRATEGY_MIS, .5f * (float)lean, seed, 64);
        }
    ok(bad >= .95 * 4 * seeds, "F-33: lit corner, lights aimed at only: %u of %u tiles flagged",
       bad, 4 * seeds);
    ok(good <= .05 * 4 * seeds, "F-33: the same corner by MIS: %u of %u", good, 4 * seeds);
}

/* Of a window of two tiles, upper left at (x, y). */
static uint32_t window_flagged(struct local *l, uint32_t x, uint32_t y)
{
    struct scene_film *f = &l->disk.scene.film;
    struct arena arena = {0};
    struct film film;
    f->crop_x_begin = x;
    f->crop_y_begin = y;
    f->crop_x_end = x + 128;
    f->crop_y_end = y + 64;
    l->disk.scene.settings.target.spp = 64;
    local_render(l, 64, 2, &film);
    const struct evidence e = evidence_make(&film, &arena);
    uint32_t heavy[2] = {0, 0};
    for (uint32_t i = 0; i < e.columns * e.rows; i++)
        heavy[i % e.columns >= e.columns / 2] += e.blocks[i].verdict == EVIDENCE_HEAVY;
    film_release(&film);
    arena_release(&arena);
    return (heavy[0] > 6) + (heavy[1] > 6);
}

/* Scenes in which light comes by small lamps, mirrors and glass, but has a variance. */
static void controls(void)
{
    static const char *const scenes[] = {"scenes/cornell-box.json", "scenes/glass-and-metal.json",
                                         "scenes/many-lights.json"};
    const uint32_t rows = stat_tries(1, 4);
    uint32_t flagged = 0, tiles = 0;
    for (size_t i = 0; i < countof(scenes); i++) {
        struct local l;
        local_open(&l, scenes[i]);
        const struct scene_film f = l.disk.scene.film;
        for (uint32_t row = 0; row < max_u32(rows, 1); row++, tiles += 2)
            flagged += window_flagged(&l, (f.width_px - 128) / 2,
                                      (f.height_px - 64) * (row + 1) / (rows + 1));
        local_release(&l);
    }
    ok(flagged <= .05 * tiles, "F-33: example scenes: %u of %u tiles flagged", flagged, tiles);
}

/* ---- the job's error and its interval ---- */

/* The truth of a film of independent samples: its error is that of the law, pixel by pixel. */
static void interval(enum law law, double relative_variance, uint32_t spp)
{
    const uint32_t tries = max_u32(stat_tries(200, 1000), 200);
    uint32_t covered = 0;
    const double truth = sqrt(relative_variance / spp);
    double wide = 0;
    for (uint32_t i = 0; i < tries; i++) {
        struct dice d = dice_make(99 + i);
        struct film f;
        film_of(&f, 24, spp, law, &d);
        const struct estimate_interval e = estimate_interval(&f);
        const double error = estimate_error(&f);
        covered += e.low <= truth && truth <= e.high;
        wide += (e.high - e.low) / (2 * error * tries);
        if (!(e.low <= error && error <= e.high))
            ok(false, "the interval is around the estimate");
        film_release(&f);
    }
    ok(covered >= .95 * tries && wide < .06,
       "the interval of the error of %s samples, +- %.1f %%, holds in %.1f %%", law_names[law],
       100 * wide, 100.0 * covered / tries);
}

int main(void)
{
    hill();
    blocks();
    the_largest();
    laws();
    corners();
    controls();
    interval(UNIFORM, 1 / 3., 256);
    interval(EXPONENTIAL, 1, 256);
    return tap_done();
}
