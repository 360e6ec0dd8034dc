/* Do error bars that are trusted hold the truth? (ACCURACY 5.2: 95 % intervals, at least 92 %.)
 *
 * A scene of the planner's corpus is rendered 64 times with other random numbers. Each pixel's
 * interval is held against the mean of all other repeats, at the most samples that there are: an
 * estimate of the same truth, without bias and independent of the bar. Its own noise makes the
 * interval wider by sqrt(1 + n / (63 x 256)), 0.2 and 0.8 %. Where all repeats say the same to
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
#include "tests/repeats.h"
#include "tests/stat/stat.h"
#include "tests/tap.h"

enum { WIDTH_PX = 36, HEIGHT_PX = 28 };
enum { LEVELS = 2 };

static const uint32_t level_spp[LEVELS] = {64, 256};

#define STUDENT 2.365 /* estimate.h */

struct tally {
    double bars, held; /* not without noise; of them: that hold the truth */
};

struct found {
    struct tally bars[LEVELS][REPEATS_VERDICTS];
    double pixels[LEVELS][REPEATS_VERDICTS];    /* of all repeats */
    struct tally expected[LEVELS], own[LEVELS]; /* jobs' intervals that hold their true errors */
    double wide[LEVELS];      /* sum over jobs: half of the interval, in parts of the error */
    double estimated[LEVELS]; /* root of the mean of squared errors, in parts of the true one */
};

static void add_tally(struct tally *to, struct tally t)
{
    to->bars += t.bars;
    to->held += t.held;
}

/* --- judging --- */

static void judge_bars(const struct repeats *s, uint32_t level, struct found *f)
{
    for (uint32_t r = 0; r < s->count; r++)
        for (size_t i = 0; i < s->pixels; i++)
            f->pixels[level][s->look[level][r].verdict[i]]++;
    for (size_t at = 0; at < 3 * s->pixels; at++)
        for (uint32_t r = 0; r < s->count && repeats_is_noisy(s, level, at); r++) {
            const struct repeats_look *l = &s->look[level][r];
            const double truth = repeats_others(s, r, at), off = fabs((double)l->mean[at] - truth);
            struct tally *t = &f->bars[level][l->verdict[at / 3]];
            t->bars++;
            t->held += off <= STUDENT * sqrt(repeats_wider(s, level)) * (double)l->error[at] +
                                  REPEATS_ROUNDING * truth;
        }
}

/* What the interval is of is the expected error: the root of the mean over all repeats. A repeat's
 * own is another number near it. */
static void judge_errors(const struct repeats *s, uint32_t level, struct found *f)
{
    double own[REPEATS_MOST], expected = 0, estimated = 0;
    for (uint32_t r = 0; r < s->count; r++) {
        own[r] = sqrt(repeats_relmse(s, level, r));
        expected += own[r] * own[r] / s->count;
    }
    expected = sqrt(expected);
    for (uint32_t r = 0; r < s->count; r++) {
        const struct repeats_look *l = &s->look[level][r];
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

static struct tally untrusted(const struct tally of[REPEATS_VERDICTS])
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

/* Of one scene. The worst has light that spots send over a metal ball: 78.6 % at 64 spp. */
static double least_of(const char *name)
{
    return strcmp(name, "spots") == 0 ? 75 : 80;
}

/* Where nearly nothing is trusted, the few that are may be the worst. */
static void judge_scene(const char *name, const struct found *f, uint32_t l)
{
    const struct tally trusted = f->bars[l][EVIDENCE_TRUSTED];
    if (trusted.bars >= .05 * (trusted.bars + untrusted(f->bars[l]).bars))
        ok(percent(trusted) >= least_of(name),
           "%s, %u spp: %.1f %% of trusted bars hold, errors are %.2f of "
           "the true ones",
           name, level_spp[l], percent(trusted), f->estimated[l]);
}

static void add(struct found *to, const struct found *f)
{
    for (uint32_t l = 0; l < LEVELS; l++) {
        for (int v = 0; v < REPEATS_VERDICTS; v++) {
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
    struct repeats all = {.count = repeats, .levels = LEVELS, .spp = {64, 256}};
    *f = (struct found){0};
    if (!corpus_make(scene, &s)) {
        diag("%s: left out, its files are not here", corpus_name(scene));
        return false;
    }
    s.scene.film.width_px = s.scene.film.crop_x_end = WIDTH_PX;
    s.scene.film.height_px = s.scene.film.crop_y_end = HEIGHT_PX;
    repeats_make(&all, scenes_stage(&s));
    for (uint32_t l = 0; l < LEVELS; l++) {
        judge_bars(&all, l, f);
        judge_errors(&all, l, f);
        say(corpus_name(scene), f, l);
        judge_scene(corpus_name(scene), f, l);
    }
    repeats_release(&all);
    scenes_release(&s);
    return true;
}

/* Of few repeats the true error is not well known either: where it is next to certain, an interval
 * may lie beside it. */
static void judge(const struct found *sum)
{
    const double least = stat_is_long() ? 88 : 75;
    for (uint32_t l = 0; l < LEVELS; l++) {
        const double pixels = sum->pixels[l][0] + sum->pixels[l][1] + sum->pixels[l][2];
        const struct tally trusted = sum->bars[l][EVIDENCE_TRUSTED];
        ok(percent(trusted) >= 92, "%u spp: of the bars that are trusted %.1f %% hold the truth",
           level_spp[l], percent(trusted));
        ok(percent(untrusted(sum->bars[l])) < percent(trusted) - 5, "of the others %.1f %%",
           percent(untrusted(sum->bars[l])));
        ok(sum->pixels[l][EVIDENCE_TRUSTED] > .5 * pixels, "%.1f %% of the pixels are trusted",
           100 * sum->pixels[l][EVIDENCE_TRUSTED] / pixels);
        ok(percent(sum->expected[l]) >= least, "of the jobs' intervals %.1f %% hold the true error",
           percent(sum->expected[l]));
    }
}

int main(int argc, char **argv)
{
    static const uint32_t quick[] = {1, 6, 7, 14}; /* a room, one with mirrors, a furnace, a sky */
    const uint32_t repeats = argc > 1 ? (uint32_t)atoi(argv[1]) : max_u32(stat_tries(6, 64), 4);
    struct found sum = {0}, f;
    if (repeats < 2 || repeats > REPEATS_MOST)
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
