/* SPDX-License-Identifier: MIT */
#include "bench/oracle.h"

#include <math.h>
#include <string.h>

#include "common/estimate.h"
#include "common/trace/render.h"
#include "common/trace/study.h"

enum { FIRST_SPP = 16, LONGER = 4 };

const double oracle_targets[ORACLE_TARGETS] = {.03, .01};

static double denominator(double y, double floor)
{
    return y * y + floor * floor;
}

/* The squared errors of a film's pixels, by its replicates. */
static const float *squares_of(const struct film *f, struct arena *arena)
{
    const size_t pixels = tile_rect_pixels(f->window);
    float *squares = arena_new(arena, float, 3 * pixels);
    for (size_t i = 0; i < pixels; i++) {
        double error[3];
        estimate_pixel(f, i, error);
        for (int c = 0; c < 3; c++)
            squares[3 * i + c] = (float)(error[c] * error[c]);
    }
    return squares;
}

/* Their mean, relative to the reference's pixels. */
static double relative(const float *squares, const struct film *reference, double floor)
{
    const size_t pixels = tile_rect_pixels(reference->window);
    double sum = 0;
    for (size_t i = 0; i < pixels; i++) {
        double y[3];
        film_mean(reference, i, y);
        for (int c = 0; c < 3; c++)
            sum += (double)squares[3 * i + c] / denominator(y[c], floor) / (3.0 * (double)pixels);
    }
    return sum;
}

static double mean_of(const struct film *f)
{
    double sum = 0;
    const size_t pixels = tile_rect_pixels(f->window);
    for (size_t i = 0; i < 3 * pixels; i++)
        sum += f->sum[i] / f->spp[i / 3] / (3.0 * (double)pixels);
    return sum;
}

struct bias {
    double square, error; /* less what noise makes of it, relative to pixels; its standard error */
    double lack, noise;   /* mean of what pixels lack, relative to them; its standard error */
};

static struct bias bias_of(const struct film *f, const struct film *reference, double floor)
{
    const size_t pixels = tile_rect_pixels(f->window);
    const double n = (double)pixels;
    double sum = 0, sum2 = 0, lack = 0, noise2 = 0;
    for (size_t i = 0; i < pixels; i++) {
        double a[3], b[3], ea[3], eb[3], here = 0, sd = 0;
        film_mean(f, i, a);
        film_mean(reference, i, b);
        estimate_pixel(f, i, ea);
        estimate_pixel(reference, i, eb);
        for (int c = 0; c < 3; c++) {
            const double off2 = ea[c] * ea[c] + eb[c] * eb[c], y2 = denominator(b[c], floor);
            here += ((a[c] - b[c]) * (a[c] - b[c]) - off2) / y2 / 3;
            lack += (b[c] - a[c]) / sqrt(y2) / (3 * n);
            sd += sqrt(off2 / y2) / 3; /* channels are off together */
        }
        sum += here / n;
        sum2 += here * here / n;
        noise2 += sd * sd / (n * n);
    }
    return (struct bias){.square = fmax(sum, 0),
                         .error = sqrt(fmax(sum2 - sum * sum, 0) / n),
                         .lack = lack,
                         .noise = sqrt(noise2)};
}

/* Noise twice as high as the usual method's for as much work, three times running: it is out of the
 * race, and what is extrapolated from here says by how much. */
static bool is_hopeless(const struct oracle_curve *c, const struct oracle_curve *usual)
{
    if (c->count < 3)
        return false;
    for (uint32_t i = c->count - 3; i < c->count; i++) {
        double square = usual->square[0];
        for (uint32_t k = 0; k < usual->count && usual->units[k] <= c->units[i]; k++)
            square = usual->square[k];
        if (c->square[i] < 2 * square)
            return false;
    }
    return true;
}

struct contest {
    double share; /* of work, units */
    const struct film *reference;
    const struct oracle_curve *usual; /* NULL, NULL for that one itself, its own reference */
};

static bool is_good(const struct oracle_curve *c)
{
    const double error = oracle_targets[ORACLE_TARGETS - 1];
    return c->square[c->count - 1] < .5 * error * error;
}

static bool is_out(const struct oracle_curve *c, const struct film *f, const struct contest *of)
{
    const bool lacks_light = of->reference && c->count >= 3 &&
                             mean_of(f) < (1 - oracle_targets[0]) * mean_of(of->reference);
    return lacks_light || (of->usual && is_hopeless(c, of->usual));
}

/* Leaves the film to the caller. */
static struct oracle_curve run(const struct stage *s, struct film *film, const struct contest *of)
{
    struct oracle_curve c = {0};
    const struct tile_rect frame = {0, 0, s->film.width_px, s->film.height_px};
    const struct film *to = of->reference ? of->reference : film;
    const float *squares[ORACLE_LEVELS];
    struct arena arena = {0}, kept = {0};
    film_init(film, frame);
    for (uint32_t spp = 0; c.count < ORACLE_LEVELS;) {
        const uint32_t end = spp ? 2 * spp : FIRST_SPP;
        struct film_samples samples =
            film_samples_make(frame, (struct tile_pass){spp, end}, &arena);
        render_tile(s, &samples);
        film_merge(film, &samples);
        arena_reset(&arena);
        spp = end;
        squares[c.count] = squares_of(film, &kept);
        c.units[c.count] = (double)film->work.units;
        c.square[c.count] = relative(squares[c.count], to, .01 * mean_of(to));
        c.count++;
        c.is_out = is_out(&c, film, of);
        if (c.is_out || is_good(&c) || (double)film->work.units > of->share / 2)
            break;
    }
    for (uint32_t i = 0; i < c.count; i++) {
        c.square[i] =
            relative(squares[i], to, .01 * mean_of(to)); /* by the pixels as they are now */
        c.own[i] = relative(squares[i], film, .01 * mean_of(film));
    }
    arena_release(&arena);
    arena_release(&kept);
    return c;
}

/* So many samples as no job can do without: before that no error is known. */
static double least_units(const struct oracle_curve *c)
{
    return c->units[0] * FILM_REPLICATES / FIRST_SPP;
}

/* Of the squared error over work, log by log, beyond what was tried. Of one that was out before it
 * had its share that is not known well enough to be carried far. */
static double slope_of(const struct oracle_curve *c)
{
    const uint32_t last = c->count - 1, before = last >= 2 ? last - 2 : 0;
    if (c->is_out || before == last)
        return -1;
    const double slope =
        log(c->square[last] / c->square[before]) / log(c->units[last] / c->units[before]);
    return fmin(fmax(slope, -1.5), -1);
}

double oracle_units(const struct oracle_curve *c, double e)
{
    const double want = e * e - c->bias;
    if (!(want > 0) || c->lacks > e / 2)
        return (double)INFINITY;
    if (c->square[0] <= want)
        return fmax(c->units[0] * c->square[0] / want, least_units(c));
    for (uint32_t i = 1; i < c->count; i++)
        if (c->square[i] <= want) {
            const double part = log(c->square[i - 1] / want) / log(c->square[i - 1] / c->square[i]);
            return c->units[i - 1] * pow(c->units[i] / c->units[i - 1], part);
        }
    const uint32_t last = c->count - 1;
    return c->units[last] * pow(want / c->square[last], 1 / slope_of(c));
}

double oracle_reach(const struct oracle_curve *c, double e)
{
    return oracle_units(c, e) / c->units[c->count - 1];
}

/* Sets what the method leaves out. Light is lacked by pixels, each beside its own: what is missing
 * in dark ones is lost in the noise of the mean. Of a method that surely lacks light the bias
 * counts as far as it may reach: what has not been shown to suffice is no rival. Else it has none:
 * what looks like it is noise. */
static void judge_bias(struct oracle_curve *c, const struct film *f, const struct film *reference)
{
    const double mean = mean_of(reference);
    const struct bias bias = bias_of(f, reference, .01 * mean);
    if (!(bias.lack > 3 * bias.noise))
        return;
    c->lacks = 1 - mean_of(f) / mean;
    c->bias = bias.square + 2 * bias.error;
}

/* As it would have been with its share alone. */
static struct oracle_curve cut(const struct oracle_curve *of, double share)
{
    struct oracle_curve c = *of;
    for (uint32_t i = 0; i + 1 < c.count; i++)
        if (c.units[i] > share / 2)
            c.count = i + 1;
    return c;
}

/* As far as it has come, beside its own pixels where these are better known than the reference's.
 */
static struct oracle_curve beside_itself(const struct oracle_curve *of)
{
    struct oracle_curve c = *of;
    const uint32_t last = c.count - 1;
    if (c.lacks == 0 && c.own[last] < c.square[last])
        memcpy(c.square, c.own, sizeof c.square);
    return c;
}

void oracle_ask(struct scenes *s, double share, enum plan_candidate_kind chosen, struct oracle *o)
{
    struct film reference, film;
    const struct plan plan = {.sampler = SAMPLER_SOBOL};
    const struct stage *usual = scenes_stage(s);
    struct stage *copy = study_stage(usual, &s->arena);
    struct oracle_curve whole[PLAN_REAL];
    struct contest of = {chosen == PLAN_PATH_MIS ? LONGER * share : share, NULL, NULL};
    whole[PLAN_PATH_MIS] = run(usual, &reference, &of);
    of.reference = &reference;
    of.usual = &whole[PLAN_PATH_MIS];
    for (int k = 0; k < PLAN_PATH_MIS; k++) {
        of.share = k == (int)chosen ? LONGER * share : share;
        study_set_method(copy, usual, plan_method_of(&plan, (enum plan_candidate_kind)k));
        whole[k] = run(copy, &film, &of);
        if (k == PLAN_DIRECT || k == PLAN_WHITTED)
            judge_bias(&whole[k], &film, &reference);
        film_release(&film);
    }
    for (int k = 0; k < PLAN_REAL; k++)
        o->of[k] = cut(&whole[k], share);
    o->chosen = beside_itself(&whole[chosen]);
    film_release(&reference);
}
