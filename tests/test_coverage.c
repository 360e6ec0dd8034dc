/* Do error bars that are trusted hold the truth? (ACCURACY 5.2: 95 % intervals, at least 92 %.)
 *
 * A scene of the planner's corpus is rendered 64 times with other random numbers. Each pixel's
 * interval is held against the mean of all other repeats, at the most samples that there are: an
 * estimate of the same truth, without bias and independent of the bar. Its own noise makes the
 * interval wider by sqrt(1 + n / (63 MOST_SPP)), 0.2 and 0.8 %. Where all repeats say the same to
 * the last bits there is no noise, and nothing to cover: such pixels would make the figure look
 * better, and are not counted.
 *
 *     test_coverage               the quick tier, or with TEST_LONG=1 the long one
 *     test_coverage REPEATS N...  scenes N of the corpus
 *
 * SPDX-License-Identifier: MIT */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "bench/corpus.h"
#include "common/estimate.h"
#include "common/evidence.h"
#include "common/trace/render.h"
#include "tests/stat/stat.h"
#include "tests/tap.h"

enum { WIDTH_PX = 36, HEIGHT_PX = 28 };
enum { MOST_REPEATS = 64, MOST_SPP = 256, LEVELS = 2, VERDICTS = EVIDENCE_HEAVY + 1 };

static const uint32_t level_spp[LEVELS] = {64, MOST_SPP};

#define STUDENT  2.365 /* estimate.h */
#define ROUNDING 1e-6  /* of a mean: replicates' sums are floats */

struct look {                       /* at one repeat, when it has level_spp */
    float *mean, *error;            /* [pixel][rgb] */
    enum evidence_verdict *verdict; /* [pixel] */
    struct estimate_interval interval;
    double estimate;
};

struct repeats {
    struct arena arena;
    uint32_t count;
    size_t pixels;
    struct look look[LEVELS][MOST_REPEATS];
    double *total; /* [pixel][rgb]: of the last looks' means */
};

struct tally {
    double bars, held; /* not without noise; of them: that hold the truth */
};

struct found {
    struct tally bars[LEVELS][VERDICTS];
    double pixels[LEVELS][VERDICTS];            /* of all repeats */
    struct tally expected[LEVELS], own[LEVELS]; /* jobs' intervals that hold their true errors */
    double wide[LEVELS];      /* sum over jobs: half of the interval, in parts of the error */
    double estimated[LEVELS]; /* root of the mean of squared errors, in parts of the true one */
};

static void add_tally(struct tally *to, struct tally t)
{
    to->bars += t.bars;
    to->held += t.held;
}

/* --- repeats --- */

static void take(struct repeats *to, struct look *look, const struct film *f)
{
    struct arena scratch = {0};
    const struct evidence e = evidence_make(f, &scratch);
    look->mean = arena_new(&to->arena, float, 3 * to->pixels);
    look->error = arena_new(&to->arena, float, 3 * to->pixels);
    look->verdict = arena_new(&to->arena, enum evidence_verdict, to->pixels);
    for (size_t i = 0; i < to->pixels; i++) {
        double mean[3], error[3];
        film_mean(f, i, mean);
        estimate_pixel(f, i, error);
        for (size_t c = 0; c < 3; c++) {
            look->mean[3 * i + c] = (float)mean[c];
            look->error[3 * i + c] = (float)error[c];
        }
    }
    for (size_t b = 0; b < (size_t)e.columns * e.rows; b++) {
        const struct tile_rect r = block_rect_of(f->window, b);
        const uint32_t width = f->window.x_end - f->window.x_begin;
        for (uint32_t y = r.y_begin; y < r.y_end; y++)
            for (uint32_t x = r.x_begin; x < r.x_end; x++)
                look->verdict[(size_t)(y - f->window.y_begin) * width + x - f->window.x_begin] =
                    e.blocks[b].verdict;
    }
    look->interval = estimate_interval(f);
    look->estimate = estimate_error(f);
    arena_release(&scratch);
}

static void repeat(struct repeats *to, const struct stage *stage)
{
    const struct scene_film *w = &stage->film;
    const struct tile_rect window = {w->crop_x_begin, w->crop_y_begin, w->crop_x_end,
                                     w->crop_y_end};
    struct arena arena = {0};
    struct film f;
    film_init(&f, window);
    for (uint32_t p = 0, level = 0; level < LEVELS; p++) {
        struct film_samples s = film_samples_make(window, tile_pass_of(p, MOST_SPP), &arena);
        render_tile(stage, &s);
        film_merge(&f, &s);
        if (s.pass.s_end == level_spp[level])
            take(to, &to->look[level++][to->count], &f);
        arena_reset(&arena);
    }
    for (size_t i = 0; i < 3 * to->pixels; i++)
        to->total[i] += (double)to->look[LEVELS - 1][to->count].mean[i];
    to->count++;
    film_release(&f);
    arena_release(&arena);
}

/* A stage's seed may be set in a copy of it. */
static void repeat_all(struct repeats *to, const struct stage *stage, uint32_t count)
{
    struct arena arena = {0};
    struct stage *copy = arena_alloc(&arena, stage->bytes, 1, STAGE_ALIGN);
    memcpy(copy, stage, stage->bytes);
    *to = (struct repeats){.pixels = (size_t)stage->film.width_px * stage->film.height_px};
    to->total = arena_new(&to->arena, double, 3 * to->pixels);
    copy->settings.target.spp = MOST_SPP;
    for (uint32_t i = 0; i < count; i++) {
        copy->settings.seed = 1000 + i;
        repeat(to, copy);
    }
    arena_release(&arena);
}

/* --- judging --- */

/* All but repeat r. */
static double others(const struct repeats *s, uint32_t r, size_t at)
{
    return (s->total[at] - (double)s->look[LEVELS - 1][r].mean[at]) / (s->count - 1);
}

/* What the others' own noise adds to the square of a difference from them. */
static double wider(const struct repeats *s, uint32_t level)
{
    return 1 + (double)level_spp[level] / ((s->count - 1) * (double)MOST_SPP);
}

static bool is_noisy(const struct repeats *s, uint32_t level, size_t at)
{
    const double mean = s->total[at] / s->count;
    for (uint32_t r = 0; r < s->count; r++)
        if (fabs((double)s->look[level][r].mean[at] - mean) > ROUNDING * mean)
            return true;
    return false;
}

static void judge_bars(const struct repeats *s, uint32_t level, struct found *f)
{
    for (uint32_t r = 0; r < s->count; r++)
        for (size_t i = 0; i < s->pixels; i++)
            f->pixels[level][s->look[level][r].verdict[i]]++;
    for (size_t at = 0; at < 3 * s->pixels; at++)
        for (uint32_t r = 0; r < s->count && is_noisy(s, level, at); r++) {
            const struct look *l = &s->look[level][r];
            const double truth = others(s, r, at), off = fabs((double)l->mean[at] - truth);
            struct tally *t = &f->bars[level][l->verdict[at / 3]];
            t->bars++;
            t->held +=
                off <= STUDENT * sqrt(wider(s, level)) * (double)l->error[at] + ROUNDING * truth;
        }
}

/* A repeat's own relMSE, against the others'; the noise of these taken from it. */
static double relmse_of(const struct repeats *s, uint32_t level, uint32_t r)
{
    const double n = 3 * (double)s->pixels;
    double least = 0, sum = 0;
    for (size_t at = 0; at < 3 * s->pixels; at++)
        least += .01 * others(s, r, at) / n;
    for (size_t at = 0; at < 3 * s->pixels; at++) {
        const double y = others(s, r, at), off = (double)s->look[level][r].mean[at] - y;
        if (off != 0)
            sum += off * off / (y * y + least * least);
    }
    return sum / (wider(s, level) * n);
}

/* What the interval is of is the expected error: the root of the mean over all repeats. A repeat's
 * own is another number near it. */
static void judge_errors(const struct repeats *s, uint32_t level, struct found *f)
{
    double own[MOST_REPEATS], expected = 0, estimated = 0;
    for (uint32_t r = 0; r < s->count; r++) {
        own[r] = sqrt(relmse_of(s, level, r));
        expected += own[r] * own[r] / s->count;
    }
    expected = sqrt(expected);
    for (uint32_t r = 0; r < s->count; r++) {
        const struct look *l = &s->look[level][r];
        const struct estimate_interval e = l->interval;
        add_tally(&f->expected[level], (struct tally){1, e.low <= expected && expected <= e.high});
        add_tally(&f->own[level], (struct tally){1, e.low <= own[r] && own[r] <= e.high});
        f->wide[level] += (e.high - e.low) / (2 * l->estimate);
        estimated += l->estimate * l->estimate / s->count;
    }
    f->estimated[level] = sqrt(estimated) / expected;
}

/* --- what is said --- */

static double percent(struct tally t)
{
    return t.bars > 0 ? 100 * t.held / t.bars : (double)NAN;
}

static struct tally untrusted(const struct tally of[VERDICTS])
{
    const struct tally *a = &of[EVIDENCE_UNKNOWN], *b = &of[EVIDENCE_HEAVY];
    return (struct tally){a->bars + b->bars, a->held + b->held};
}

static void say(const char *name, const struct found *f, uint32_t l)
{
    const double pixels = f->pixels[l][0] + f->pixels[l][1] + f->pixels[l][2];
    diag("%-17s %3u spp: trusted %4.1f %% (%5.1f %% of the pixels), others %4.1f %%; jobs' errors "
         "+- %4.1f %%, holds what is expected in %3.0f %%, its own in %3.0f %%",
         name, level_spp[l], percent(f->bars[l][EVIDENCE_TRUSTED]),
         100 * f->pixels[l][EVIDENCE_TRUSTED] / pixels, percent(untrusted(f->bars[l])),
         100 * f->wide[l] / f->expected[l].bars, percent(f->expected[l]), percent(f->own[l]));
}

/* Where nearly nothing is trusted, the few that are may be the worst. */
static void judge_scene(const char *name, const struct found *f, uint32_t l)
{
    const struct tally trusted = f->bars[l][EVIDENCE_TRUSTED];
    if (trusted.bars >= .05 * (trusted.bars + untrusted(f->bars[l]).bars))
        ok(percent(trusted) >= 80,
           "%s, %u spp: %.1f %% of trusted bars hold, errors are %.2f of "
           "the true ones",
           name, level_spp[l], percent(trusted), f->estimated[l]);
}

static void add(struct found *to, const struct found *f)
{
    for (uint32_t l = 0; l < LEVELS; l++) {
        for (int v = 0; v < VERDICTS; v++) {
            add_tally(&to->bars[l][v], f->bars[l][v]);
            to->pixels[l][v] += f->pixels[l][v];
        }
        add_tally(&to->expected[l], f->expected[l]);
        add_tally(&to->own[l], f->own[l]);
        to->wide[l] += f->wide[l];
    }
}

static bool look_at(uint32_t scene, uint32_t repeats, struct found *f)
{
    struct scenes s;
    struct repeats all;
    *f = (struct found){0};
    if (!corpus_make(scene, &s)) {
        diag("%s: left out, its files are not here", corpus_name(scene));
        return false;
    }
    s.scene.film.width_px = s.scene.film.crop_x_end = WIDTH_PX;
    s.scene.film.height_px = s.scene.film.crop_y_end = HEIGHT_PX;
    repeat_all(&all, scenes_stage(&s), repeats);
    for (uint32_t l = 0; l < LEVELS; l++) {
        judge_bars(&all, l, f);
        judge_errors(&all, l, f);
        say(corpus_name(scene), f, l);
        judge_scene(corpus_name(scene), f, l);
    }
    arena_release(&all.arena);
    scenes_release(&s);
    return true;
}

static void judge(const struct found *sum)
{
    for (uint32_t l = 0; l < LEVELS; l++) {
        const double pixels = sum->pixels[l][0] + sum->pixels[l][1] + sum->pixels[l][2];
        const struct tally trusted = sum->bars[l][EVIDENCE_TRUSTED];
        ok(percent(trusted) >= 92, "%u spp: of the bars that are trusted %.1f %% hold the truth",
           level_spp[l], percent(trusted));
        ok(percent(untrusted(sum->bars[l])) < percent(trusted) - 5, "of the others %.1f %%",
           percent(untrusted(sum->bars[l])));
        ok(sum->pixels[l][EVIDENCE_TRUSTED] > .5 * pixels, "%.1f %% of the pixels are trusted",
           100 * sum->pixels[l][EVIDENCE_TRUSTED] / pixels);
    }
}

int main(int argc, char **argv)
{
    static const uint32_t quick[] = {1, 6, 7, 14}; /* a room, one with mirrors, a furnace, a sky */
    const uint32_t repeats = argc > 1 ? (uint32_t)atoi(argv[1]) : max_u32(stat_tries(6, 64), 4);
    struct found sum = {0}, f;
    if (repeats < 2 || repeats > MOST_REPEATS)
        return 2;
    for (uint32_t i = 0; i < corpus_count(); i++) {
        bool asked = stat_is_long() && argc < 3 && STAT_SLOW == 1;
        for (int k = 2; k < argc; k++)
            asked = asked || (uint32_t)atoi(argv[k]) == i;
        for (size_t k = 0; k < countof(quick); k++)
            asked = asked || (argc < 3 && quick[k] == i);
        if (asked && look_at(i, repeats, &f))
            add(&sum, &f);
    }
    say("all", &sum, 0);
    say("all", &sum, 1);
    judge(&sum);
    return tap_done();
}
