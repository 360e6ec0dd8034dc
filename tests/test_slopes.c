/* How fast errors fall (ACCURACY 5.5): of the samplers' points on integrands whose rate is known,
 * and with TEST_LONG=1 of whole scenes, by their repeats and as `smalti chart` measures them.
 *
 *     test_slopes        the quick tier, or with TEST_LONG=1 the long one
 *     test_slopes N...   scenes N of the planner's corpus
 *
 * D. Mitchell, "Consequences of Stratified Sampling in Graphics", SIGGRAPH 1996: with an edge the
 * error squared of spread points goes with n^(-3/2). A. Owen, "Scrambled Net Variance for Integrals
 * of Smooth Functions", Annals of Statistics 25, 1997: without, with n^-3.
 * SPDX-License-Identifier: MIT */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "bench/corpus.h"
#include "client/chart.h"
#include "common/scene_disk.h"
#include "common/trace/sampler.h"
#include "tests/repeats.h"
#include "tests/stat/stat.h"
#include "tests/tap.h"

enum { POINTS = 6, MOST = 1 << 14, GROUPS = 64, LANES = 8 };

enum integrand { SMOOTH, EDGE, SPIKE };

static double value_of(enum integrand f, double u, double v)
{
    switch (f) {
    case SMOOTH:
        return sin(3.14159265358979323846 * u) * sin(3.14159265358979323846 * v);
    case EDGE:
        return u + 0.7 * v < 0.8;
    case SPIKE:
        return 1 / sqrt(u);
    }
    __builtin_unreachable();
}

static const double truths[] = {
    [SMOOTH] = 4 / (3.14159265358979323846 * 3.14159265358979323846), [EDGE] = 0.45, [SPIKE] = 2};

static int ascending(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* Without a variance the mean of squares is nobody's: what is typical, the groups' median, in its
 * place. */
static void take_medians(struct curve *c)
{
    for (uint32_t p = 0; p < c->points; p++) {
        qsort(c->error[p], c->runs, sizeof c->error[p][0], ascending);
        for (uint32_t r = 0; r < c->runs; r++)
            c->error[p][r] = c->error[p][c->runs / 2];
    }
}

/* Points 0 to MOST - 1 of replicate 0 in eight pixels at once, one in each lane. */
static struct curve_value slope_of(enum integrand f, enum sampler_kind sampler, uint32_t repeats)
{
    static struct curve c;
    const struct scene_settings how = {.sampler = sampler, .target = {.spp = MOST}};
    memset(&c, 0, sizeof c);
    c.points = POINTS;
    c.runs = GROUPS;
    for (uint32_t begin = 0; begin < repeats; begin += LANES) {
        double sum[LANES] = {0};
        uint32_t point = 0;
        for (uint32_t i = 0; i < MOST; i++) {
            struct rng8 rng = {0};
            for (uint32_t k = 0; k < LANES; k++) {
                const struct rng one = rng_make(5, begin + k, 9, i * FILM_REPLICATES);
                rng8_set_lane(&rng, k, &one);
            }
            const struct sobol8_bits q =
                sampler_pair_bits(&how, &rng, rng_dimension(0, RNG_BSDF_DIRECTION));
            for (uint32_t k = 0; k < LANES; k++)
                sum[k] += value_of(f, (q.u[k] + 0.5) * 0x1p-32, (q.v[k] + 0.5) * 0x1p-32);
            if (i + 1 != 16u << 2 * point)
                continue;
            c.work[point] = i + 1;
            for (uint32_t k = 0; k < LANES; k++) {
                const double off = sum[k] / (i + 1) - truths[f];
                c.error[point][(begin + k) % GROUPS] += off * off;
            }
            point++;
        }
    }
    if (f == SPIKE)
        take_medians(&c);
    return curve_slope(&c, 0, POINTS);
}

static void of_points(void)
{
    const uint32_t repeats = max_u32(stat_tries(1024, 8192), 1024);
    const struct curve_value alone = slope_of(EDGE, SAMPLER_INDEPENDENT, repeats),
                             smooth = slope_of(SMOOTH, SAMPLER_SOBOL, repeats),
                             edge = slope_of(EDGE, SAMPLER_SOBOL, repeats),
                             spike = slope_of(SPIKE, SAMPLER_SOBOL, repeats);
    near(alone.at, -1, 0.05 + 0.5 * (alone.high - alone.low),
         "independent points: %.3f (%.3f to %.3f)", alone.at, alone.low, alone.high);
    ok(smooth.at <= -2.5, "Owen-Sobol, smooth: %.3f (%.3f to %.3f), at most -2.5", smooth.at,
       smooth.low, smooth.high);
    near(edge.at, -1.5, 0.12, "Owen-Sobol, an edge: %.3f (%.3f to %.3f)", edge.at, edge.low,
         edge.high);
    /* The first point's share, u^(-1/2) / n with u in [0, 1/n), is n^(-1/2) times a fixed law. */
    near(spike.at, -1, 0.1, "Owen-Sobol, x^(-1/2), whose variance does not exist: typically %.3f",
         spike.at);
}

/* --- whole scenes --- */

static void of_scene(const char *path)
{
    struct arena arena = {0};
    struct scene_disk disk;
    struct scene_errors errors = {0};
    struct err err = {0};
    uint32_t unread;
    static struct chart c;
    struct chart_crew crew = {.threads = 2, .quiet = true};
    const struct chart_options options = {16, 512, 16, 16384};
    if (ok(scene_disk_open(&disk, path, &arena, &errors) &&
               scene_disk_load(&disk, &arena, &unread, &errors) &&
               chart_measure(&c, &disk.scene, &options, &crew, &arena, &err),
           "%s is charted %s", path, err.text))
        for (uint32_t i = 0; i < c.line_count; i++) {
            const struct chart_line *line = &c.lines[i];
            bool flagged = line->missing;
            for (uint32_t p = 0; p < c.point_count; p++)
                flagged = flagged || line->points[p].tail ||
                          line->points[p].unknown + line->points[p].heavy > 0.05;
            /* To be above, the whole interval has to be. */
            ok(flagged || (line->slope.low <= -0.95 && line->slope.high >= -1.6),
               "%s, %s: %.2f (%.2f to %.2f)%s", path, line->method->name, line->slope.at,
               line->slope.low, line->slope.high, flagged ? ", flagged" : "");
            if (line->missing)
                continue;
            ok(line->bias2.low <= c.reference.noise, "and has no bias: %.2g to %.2g",
               line->bias2.low, line->bias2.high);
        }
    arena_release(&arena);
}

/* The first is the least at which every replicate has points that share no camera ray: samples 8 to
 * 15 go along the rays of 0 to 7 (rng.h), and bring that much less. */
enum { LEVELS = 6, WIDTH_PX = 24, HEIGHT_PX = 18 };

/* A repeat's error at all amounts of samples, against the mean of the others: no reference has to
 * be made, and none has a floor. */
static void fill_curve(const struct repeats *r, struct curve *c)
{
    *c = (struct curve){.points = r->levels, .runs = r->count};
    for (uint32_t l = 0; l < r->levels; l++) {
        c->work[l] = r->spp[l];
        for (uint32_t i = 0; i < r->count; i++)
            c->error[l][i] = repeats_relmse(r, l, i);
    }
}

static double heavy_part(const struct repeats *r)
{
    double heavy = 0;
    for (uint32_t i = 0; i < r->count; i++)
        for (size_t p = 0; p < r->pixels; p++)
            heavy += r->look[r->levels - 1][i].verdict[p] == EVIDENCE_HEAVY;
    return heavy / ((double)r->count * (double)r->pixels);
}

static void of_whole(uint32_t scene)
{
    static struct repeats r;
    static struct curve c;
    struct scenes s;
    if (!corpus_make(scene, &s)) {
        diag("%s: left out, its files are not here", corpus_name(scene));
        return;
    }
    s.scene.film.width_px = s.scene.film.crop_x_end = WIDTH_PX;
    s.scene.film.height_px = s.scene.film.crop_y_end = HEIGHT_PX;
    r = (struct repeats){
        .count = REPEATS_MOST, .levels = LEVELS, .spp = {32, 64, 128, 256, 512, 1024}};
    repeats_make(&r, scenes_stage(&s));
    fill_curve(&r, &c);
    const struct curve_value slope = curve_slope(&c, 0, LEVELS);
    const double heavy = heavy_part(&r);
    ok(heavy > .05 || (slope.at <= -1.05 && slope.at >= -1.6),
       "Owen-Sobol, %s: %.2f (%.2f to %.2f)%s", corpus_name(scene), slope.at, slope.low, slope.high,
       heavy > .05 ? ", flagged" : "");
    repeats_release(&r);
    scenes_release(&s);
}

/* Of the corpus: rooms with lamps of all sizes, by glass, by a point, by walls that shine, a dome,
 * a soft box, the Cornell box, many lights. */
static const uint32_t whole[] = {0, 2, 5, 9, 10, 11, 16, 26, 28};

int main(int argc, char **argv)
{
    for (int i = 1; i < argc; i++)
        of_whole((uint32_t)atoi(argv[i]));
    if (argc > 1)
        return tap_done();
    of_points();
    if (stat_is_long() && STAT_SLOW == 1) {
        for (size_t i = 0; i < countof(whole); i++)
            of_whole(whole[i]);
        of_scene("scenes/cornell-box.json");
        of_scene("scenes/glass-and-metal.json");
        of_scene("scenes/many-lights.json");
    } else
        diag("left out: the slopes of whole scenes (TEST_LONG=1)");
    return tap_done();
}
