/* Does the planner choose the cheapest sufficient method, and does it pay for itself?
 *
 * Each method renders each scene of the corpus until it is as good as asked or has had its share of
 * work; what is missing then is extrapolated by the slope of its last two doublings. All is counted
 * work, so that the figures do not depend on the machine. Regret: (planning + the chosen method's
 * work) over the least work of a sufficient method.
 *
 *     bench_planner [--quick] [CSV]      --quick: a fifth of the work, fewer perturbations
 *
 * SPDX-License-Identifier: MIT */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "bench/corpus.h"
#include "common/base.h"
#include "common/estimate.h"
#include "common/trace/prep.h"
#include "common/trace/render.h"
#include "common/trace/study.h"

enum { LEVELS = 16, MOST_SCENES = 64, TARGETS = 2 };

static const double targets[TARGETS] = {.03, .01};
static double most_units = 6e9; /* of a method on a scene */

/* --- what a method needs: the oracle --- */

struct curve { /* after 16, 32 .. samples of a pixel */
    uint32_t count;
    double square[LEVELS], units[LEVELS];
    double bias, lacks; /* of one that leaves light out */
};

struct oracle {
    struct curve of[PLAN_REAL];
};

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

/* Squared, less what noise makes of it. */
static double bias_of(const struct film *f, const struct film *reference, double floor)
{
    const size_t pixels = tile_rect_pixels(f->window);
    double sum = 0;
    for (size_t i = 0; i < pixels; i++) {
        double a[3], b[3], ea[3], eb[3];
        film_mean(f, i, a);
        film_mean(reference, i, b);
        estimate_pixel(f, i, ea);
        estimate_pixel(reference, i, eb);
        for (int c = 0; c < 3; c++)
            sum += ((a[c] - b[c]) * (a[c] - b[c]) - ea[c] * ea[c] - eb[c] * eb[c]) /
                   denominator(b[c], floor) / (3.0 * (double)pixels);
    }
    return sum > 0 ? sum : 0;
}

/* Noise twice as high as the usual method's for as much work, three times running: it is out of the
 * race, and what is extrapolated from here says by how much. */
static bool is_hopeless(const struct curve *c, const struct curve *usual)
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

struct judged_by { /* NULL, NULL for the usual method, which is its own reference */
    const struct film *reference;
    const struct curve *usual;
};

static bool is_enough(const struct curve *c, const struct film *f, const struct judged_by *by)
{
    const double error = targets[TARGETS - 1];
    if ((double)f->work.units > most_units / 2 || c->square[c->count - 1] < .5 * error * error)
        return true;
    const bool lacks_light =
        by->reference && c->count >= 3 && mean_of(f) < (1 - targets[0]) * mean_of(by->reference);
    return lacks_light || (by->usual && is_hopeless(c, by->usual));
}

/* Leaves the film to the caller. */
static struct curve run(const struct stage *s, struct film *film, struct judged_by by)
{
    struct curve c = {0};
    const struct tile_rect frame = {0, 0, s->film.width_px, s->film.height_px};
    const struct film *to = by.reference ? by.reference : film;
    const float *squares[LEVELS];
    struct arena arena = {0}, kept = {0};
    film_init(film, frame);
    for (uint32_t spp = 0; c.count < LEVELS;) {
        const uint32_t end = spp ? 2 * spp : 16;
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
        if (is_enough(&c, film, &by))
            break;
    }
    for (uint32_t i = 0; i < c.count; i++) /* of the usual method, by the pixels as they are now */
        c.square[i] = relative(squares[i], to, .01 * mean_of(to));
    arena_release(&arena);
    arena_release(&kept);
    return c;
}

/* Out of the race before its share of work was done: how its error falls is then not known well
 * enough to be carried far. */
static bool is_stopped(const struct curve *c)
{
    const double error = targets[TARGETS - 1];
    return c->units[c->count - 1] <= most_units / 2 &&
           c->square[c->count - 1] >= .5 * error * error;
}

/* Units until the error is e; infinite when it never will be. */
static double units_to(const struct curve *c, double e)
{
    const double want = e * e - c->bias;
    if (!(want > 0) || c->lacks > e / 2)
        return (double)INFINITY;
    if (c->square[0] <= want)
        return c->units[0] * c->square[0] / want;
    for (uint32_t i = 1; i < c->count; i++)
        if (c->square[i] <= want) {
            const double part = log(c->square[i - 1] / want) / log(c->square[i - 1] / c->square[i]);
            return c->units[i - 1] * pow(c->units[i] / c->units[i - 1], part);
        }
    const uint32_t last = c->count - 1, before = last >= 2 ? last - 2 : 0;
    double slope = before < last ? log(c->square[last] / c->square[before]) /
                                       log(c->units[last] / c->units[before])
                                 : -1;
    slope = slope > -1 || is_stopped(c) ? -1 : slope < -1.5 ? -1.5 : slope;
    return c->units[last] * pow(want / c->square[last], 1 / slope);
}

static void ask_oracle(struct scenes *s, struct oracle *o)
{
    struct film reference, film;
    const struct plan plan = {.sampler = SAMPLER_SOBOL};
    const struct stage *usual = scenes_stage(s);
    struct stage *copy = study_stage(usual, &s->arena);
    struct curve *mis = &o->of[PLAN_PATH_MIS];
    *mis = run(usual, &reference, (struct judged_by){NULL, NULL});
    const double mean = mean_of(&reference);
    for (int k = 0; k < PLAN_PATH_MIS; k++) {
        study_set_method(copy, usual, plan_method_of(&plan, (enum plan_candidate_kind)k));
        o->of[k] = run(copy, &film, (struct judged_by){&reference, mis});
        if (k == PLAN_DIRECT || k == PLAN_WHITTED) {
            o->of[k].bias = bias_of(&film, &reference, .01 * mean);
            o->of[k].lacks = mean > 0 ? 1 - mean_of(&film) / mean : 0;
        }
        film_release(&film);
    }
    film_release(&reference);
}

/* --- plans --- */

static struct plan plan_of(struct scenes *s, double error)
{
    struct plan plan;
    struct arena scratch = {0};
    s->scene.settings.integrator = INTEGRATOR_AUTO;
    s->scene.settings.strategy = STRATEGY_MIS;
    s->scene.settings.target = (struct scene_target){.error = error, .spp = SCENE_MAX_SPP};
    study_make(scenes_stage(s), NULL, &scratch, &plan);
    arena_release(&scratch);
    return plan;
}

struct figure {
    enum corpus_part part;
    double regret;
    double forecast; /* off by this factor, at least 1 */
    double price;    /* of planning, over the usual method's work */
    bool is_plain;   /* nothing is cheaper than the usual method: planning cannot gain anything */
};

struct figures {
    struct figure of[TARGETS * MOST_SCENES];
    uint32_t count;
    uint32_t insufficient;
    uint32_t perturbed, moved;
    FILE *csv;
};

static const char *const part_names[] = {
    [CORPUS_TUNED] = "tuned on", [CORPUS_HELD_OUT] = "held out", [CORPUS_FRESH] = "fresh"};

static double least_of(const struct oracle *o, double error, enum plan_candidate_kind *which)
{
    double least = (double)INFINITY;
    for (int k = 0; k < PLAN_REAL; k++) {
        const double units = units_to(&o->of[k], error);
        if (units < least) {
            least = units;
            *which = (enum plan_candidate_kind)k;
        }
    }
    return least;
}

static void judge(uint32_t scene, struct scenes *s, const struct oracle *o, int target,
                  struct figures *f)
{
    const double error = targets[target];
    const struct plan plan = plan_of(s, error);
    enum plan_candidate_kind best = PLAN_PATH_MIS;
    const double least = least_of(o, error, &best);
    const double chosen = units_to(&o->of[plan.chosen], error);
    const double usual = units_to(&o->of[PLAN_PATH_MIS], error);
    const double off = plan.forecast > chosen ? plan.forecast / chosen : chosen / plan.forecast;
    const struct figure figure = {corpus_part(scene), (plan.studied + chosen) / least, off,
                                  plan.studied / usual, usual <= least};
    f->insufficient += isinf(chosen);
    f->of[f->count++] = figure;
    printf("%-17s %-8s %2.0f %%  %-11s %-11s regret %5.3f  planning %5.2f %%  forecast x %.2f%s\n",
           corpus_name(scene), part_names[figure.part], 100 * error,
           plan_candidate_name(plan.chosen), plan_candidate_name(best), figure.regret,
           100 * figure.price, plan.forecast / chosen, plan.pilot_pixels ? "" : "  no pilot");
    fflush(stdout);
    if (!f->csv)
        return;
    fprintf(f->csv, "\"%s\",%s,%g,\"%s\",\"%s\",%.4g,%.4g,%.4g", corpus_name(scene),
            part_names[figure.part], error, plan_candidate_name(plan.chosen),
            plan_candidate_name(best), figure.regret, plan.studied, plan.forecast);
    for (int k = 0; k < PLAN_REAL; k++)
        fprintf(f->csv, ",%.4g", units_to(&o->of[k], error));
    fprintf(f->csv, "\n");
}

/* --- what should not matter --- */

static void shift_camera(struct scenes *s, float by)
{
    for (int i = 0; i < 3; i++)
        s->scene.camera.to_world.m[i][3] *= 1 + (i == 1 ? -by : by);
}

static void scale_light(struct scenes *s, float by)
{
    for (uint32_t i = 0; i < s->scene.shape_count; i++)
        s->scene.shapes[i].emission *= by;
    for (uint32_t i = 0; i < s->scene.light_count; i++) {
        struct light *l = &s->scene.lights[i];
        switch (l->kind) {
        case LIGHT_SKY:
            l->sky.radiance *= by;
            break;
        case LIGHT_POINT:
            l->point.intensity *= by;
            break;
        case LIGHT_DISTANT:
            l->distant.irradiance *= by;
            break;
        case LIGHT_SUN:
            l->sun.radiance *= by;
            l->sun.irradiance *= by;
            break;
        case LIGHT_SPOT:
            l->spot.intensity *= by;
            break;
        case LIGHT_ENVIRONMENT:
            l->environment.scale *= by;
            break;
        }
    }
}

/* The same choice, or one within 10 %. */
static void perturb(uint32_t scene, const struct oracle *o, uint32_t seeds, struct figures *f)
{
    enum plan_candidate_kind first = PLAN_PATH_MIS;
    for (uint32_t i = 0; i < seeds + 4; i++) {
        struct scenes s;
        if (!corpus_make(scene, &s))
            return;
        if (i >= 4)
            s.scene.settings.seed = i;
        else if (i == 1)
            shift_camera(&s, .01f);
        else if (i >= 2)
            scale_light(&s, i == 2 ? 1e-6f : 1e6f);
        const enum plan_candidate_kind k = plan_of(&s, targets[0]).chosen;
        if (i == 0)
            first = k;
        const double a = units_to(&o->of[k], targets[0]), b = units_to(&o->of[first], targets[0]);
        f->perturbed++;
        if (!(a <= 1.1 * b && b <= 1.1 * a)) {
            f->moved++;
            printf("%-17s   perturbed (%u): %s\n", corpus_name(scene), i, plan_candidate_name(k));
        }
        scenes_release(&s);
    }
}

/* --- all of it --- */

static int by_size(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static double median_of(double *v, uint32_t count)
{
    qsort(v, count, sizeof *v, by_size);
    return v[count / 2];
}

/* part: CORPUS_PARTS for all. */
static void say_part(const struct figures *f, enum corpus_part part)
{
    double forecasts[TARGETS * MOST_SCENES], prices[TARGETS * MOST_SCENES];
    double logs = 0, worst = 0, plain = 0;
    uint32_t count = 0, good = 0, twice = 0;
    for (uint32_t i = 0; i < f->count; i++) {
        const struct figure *g = &f->of[i];
        if (part != CORPUS_PARTS && g->part != part)
            continue;
        good += g->regret <= 1.1;
        twice += g->forecast <= 2;
        logs += log(g->regret);
        worst = fmax(worst, g->regret);
        plain = g->is_plain ? fmax(plain, g->regret) : plain;
        forecasts[count] = g->forecast;
        prices[count++] = g->price;
    }
    if (count == 0)
        return;
    printf("\n%s (%u)\n", part == CORPUS_PARTS ? "all" : part_names[part], count);
    printf("  regret at most 1.10 in %.1f %% (90 %%), worst %.2f (1.5), geometric mean %.3f "
           "(1.05)\n",
           100.0 * good / count, worst, exp(logs / count));
    printf("  total where the usual method is the cheapest: at most %.3f of it (1.02)\n", plain);
    printf("  forecasts within a factor of 2: %.1f %% (90 %%), median %.2f (1.3)\n",
           100.0 * twice / count, median_of(forecasts, count));
    const double price = median_of(prices, count); /* sorts them */
    printf("  planning: median %.2f %%, most %.2f %% of the usual method's work\n", 100 * price,
           100 * prices[count - 1]);
}

static void say(const struct figures *f)
{
    for (int part = 0; part <= CORPUS_PARTS; part++)
        say_part(f, (enum corpus_part)part);
    printf("\ninsufficient methods chosen: %u (0)\n", f->insufficient);
    printf("perturbed: the same choice, or one within 10 %%, in %.1f %% of %u (95 %%)\n",
           100.0 * (f->perturbed - f->moved) / f->perturbed, f->perturbed);
}

int main(int argc, char **argv)
{
    struct figures f = {.csv = NULL};
    uint32_t seeds = 16;
    if (argc > 1 && !strcmp(argv[1], "--quick")) {
        most_units /= 5;
        seeds = 2;
        argc--, argv++;
    }
    if (argc > 1 && !(f.csv = fopen(argv[1], "w"))) {
        fprintf(stderr, "bench_planner: %s cannot be written\n", argv[1]);
        return 5;
    }
    if (f.csv)
        fprintf(f.csv, "scene,part,error,chosen,best,regret,planning,forecast,direct,whitted,"
                       "bsdf,light,mis\n");
    printf("%u scenes; the method chosen, the cheapest one\n", corpus_count());
    for (uint32_t i = 0; i < corpus_count(); i++) {
        struct scenes s;
        struct oracle o;
        if (!corpus_make(i, &s)) {
            printf("%-17s left out: its files are not here\n", corpus_name(i));
            continue;
        }
        ask_oracle(&s, &o);
        for (int t = 0; t < TARGETS; t++)
            judge(i, &s, &o, t, &f);
        scenes_release(&s);
        perturb(i, &o, seeds, &f);
    }
    say(&f);
    if (f.csv)
        fclose(f.csv);
    return 0;
}
