/* SPDX-License-Identifier: MIT */
#include "common/plan.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include "common/base.h"

/* The numbers of the rules. They were set on the scenes of `make bench-planner` that are not held
 * out. */
#define PLACE_SHARE    0.33 /* of PLAN_SAMPLES; the rest is for pilots */
#define PLACE_SAMPLES  10.0 /* a place costs about so many */
#define LIGHT_SHARE    0.5  /* beside them, in scenes that have what is looked for */
#define CLOSE          1.05 /* a simpler method may cost so much more: its pilot has a price, too */
#define MOST_TAIL      0.5
#define MOST_THIN      0.05
#define WIDE_LIGHT_SR  0.3 /* a light that surfaces find by themselves */
#define SMALL_LIGHT_SR 0.05
#define PEAKED_MAP     50.0

enum { MOST_PIXELS = 4096, MOST_PLACES = 1024, MOST_PATHS = 65536 };

static const struct plan_method methods[PLAN_REAL] = {
    [PLAN_DIRECT] = {INTEGRATOR_DIRECT, STRATEGY_MIS, SAMPLER_SOBOL},
    [PLAN_WHITTED] = {INTEGRATOR_WHITTED, STRATEGY_LIGHT, SAMPLER_SOBOL},
    [PLAN_PATH_BSDF] = {INTEGRATOR_PATH, STRATEGY_BSDF, SAMPLER_SOBOL},
    [PLAN_PATH_LIGHT] = {INTEGRATOR_PATH, STRATEGY_LIGHT, SAMPLER_SOBOL},
    [PLAN_PATH_MIS] = {INTEGRATOR_PATH, STRATEGY_MIS, SAMPLER_SOBOL},
};

const char *plan_candidate_name(enum plan_candidate_kind k)
{
    static const char *const names[] = {
        [PLAN_DIRECT] = "direct",         [PLAN_WHITTED] = "whitted",
        [PLAN_PATH_BSDF] = "path, bsdf",  [PLAN_PATH_LIGHT] = "path, light",
        [PLAN_PATH_MIS] = "path, mis",    [PLAN_BIDIRECTIONAL] = "bidirectional",
        [PLAN_PHOTON_MAP] = "photon map", [PLAN_METROPOLIS] = "metropolis",
    };
    return names[k];
}

struct plan_names plan_names(enum plan_candidate_kind k)
{
    static const char *const integrators[] = {[INTEGRATOR_PATH] = "path",
                                              [INTEGRATOR_DIRECT] = "direct",
                                              [INTEGRATOR_WHITTED] = "whitted"};
    static const char *const strategies[] = {
        [STRATEGY_MIS] = "mis", [STRATEGY_LIGHT] = "light", [STRATEGY_BSDF] = "bsdf"};
    return (struct plan_names){integrators[methods[k].integrator], strategies[methods[k].strategy]};
}

enum plan_candidate_kind plan_find(const char *integrator, const char *strategy)
{
    int k = 0;
    for (; k < PLAN_REAL; k++) {
        const struct plan_names n = plan_names((enum plan_candidate_kind)k);
        if (!strcmp(n.integrator, integrator) && !strcmp(n.strategy, strategy))
            break;
    }
    return (enum plan_candidate_kind)k;
}

const char *plan_class_name(enum plan_class c)
{
    static const char *const names[] = {
        [PLAN_LE] = "LE",         [PLAN_LSE] = "LS+E",
        [PLAN_LDE] = "LDE",       [PLAN_LDSE] = "LDS+E",
        [PLAN_LSDE] = "LS+DE",    [PLAN_LSDSE] = "LS+DS+E",
        [PLAN_LDDE] = "LDD+E",    [PLAN_LDDSE] = "LDD+S+E",
        [PLAN_LSDDE] = "LS+DD+E", [PLAN_LSDDSE] = "LS+DD+S+E",
    };
    return names[c];
}

struct plan_method plan_method_of(const struct plan *p, enum plan_candidate_kind k)
{
    struct plan_method m = methods[k];
    m.sampler = p->sampler;
    return m;
}

void plan_init(struct plan *p, const struct scene_settings *s, uint64_t pixels)
{
    *p = (struct plan){
        .error = s->target.error > 0 ? s->target.error : PLAN_ERROR,
        .is_asked = s->target.error > 0,
        .spp = s->target.spp,
        .pixels = pixels,
        .max_bounces = s->max_bounces,
        .sampler = s->sampler,
        .chosen = PLAN_PATH_MIS,
    };
}

/* --- which are worth a pilot --- */

PRINTF(3, 4)
static void rule(struct plan_candidate *c, enum plan_verdict verdict, const char *fmt, ...)
{
    va_list args;
    va_start(args, fmt);
    c->verdict = verdict;
    vsnprintf(c->why, sizeof c->why, fmt, args);
    va_end(args);
}

static double sum_of(const double of_class[])
{
    double sum = 0;
    for (int i = 0; i < PLAN_CLASSES; i++)
        sum += of_class[i];
    return sum;
}

/* A method that leaves light out is considered only if no path was found to go on where it ends,
 * with light or without. A share of half of the error would be allowed, but what counts is each
 * pixel's error: where light comes by no other way, in a shadow, all is gone, and one pixel in 4 /
 * error^2 is too many already. No pilot sees that. */
static void consider_biased(struct plan_candidate *c, double share, double error, uint64_t paths)
{
    c->lacks += share;
    if (share > 0)
        rule(c, PLAN_INSUFFICIENT,
             "leaves out %.3g %% of the light (+- %.2g), and all in some pixels", 100 * share,
             200 * error);
    else if (paths > 0)
        rule(c, PLAN_INSUFFICIENT, "%llu paths go on where it ends", (unsigned long long)paths);
}

static uint32_t shared_lights(const struct plan_features *f)
{
    return f->emitters[PLAN_SURFACE] + f->emitters[PLAN_SUN] + f->emitters[PLAN_MAP];
}

static void consider_bsdf(const struct plan_features *f, struct plan_candidate *c)
{
    if (f->emitters[PLAN_MAP] && f->map_peak > PEAKED_MAP)
        rule(c, PLAN_RULED_OUT, "the environment has pixels %.3g times as bright as its mean",
             f->map_peak);
    else if (!f->emitters[PLAN_MAP] && f->solid_angle < WIDE_LIGHT_SR)
        rule(c, PLAN_RULED_OUT, "the largest light fills %.2g sr, below %.2g", f->solid_angle,
             WIDE_LIGHT_SR);
}

static void consider_light(const struct plan_features *f, struct plan_candidate *c)
{
    if (f->lobes[PLAN_NARROW] || f->lobes[PLAN_GLOSSY])
        rule(c, PLAN_RULED_OUT, "there are glossy surfaces, that find lights by themselves");
    else if (f->emitters[PLAN_MAP] || f->solid_angle > SMALL_LIGHT_SR)
        rule(c, PLAN_RULED_OUT, "there are lights above %.2g sr", SMALL_LIGHT_SR);
}

static void say_would_find(struct plan_candidate *c, double share, double all)
{
    c->verdict = PLAN_ABSENT;
    c->lacks = all - share;
    if (all > 0)
        rule(c, PLAN_ABSENT, "would find %.3g %% of the light that no path from the eye can",
             100 * share);
}

static void consider_absent(struct plan *p)
{
    const double *missed = p->light.missed;
    const double seen = missed[PLAN_LSE] + missed[PLAN_LSDE] + missed[PLAN_LSDDE];
    const double all = sum_of(missed);
    say_would_find(&p->candidates[PLAN_BIDIRECTIONAL], seen, all);
    say_would_find(&p->candidates[PLAN_PHOTON_MAP], all, all);
    say_would_find(&p->candidates[PLAN_METROPOLIS], seen, all);
}

static void consider_each(struct plan *p)
{
    const struct plan_features *f = &p->features;
    struct plan_candidate *c = p->candidates;
    for (int k = 0; k < PLAN_REAL; k++)
        c[k] = (struct plan_candidate){.verdict = PLAN_DEARER, .lacks = sum_of(p->light.missed)};
    if (p->max_bounces <= 1) {
        for (int k = 0; k < PLAN_REAL; k++)
            if (k != PLAN_PATH_MIS)
                rule(&c[k], PLAN_RULED_OUT, "the document allows for %u scatterings",
                     p->max_bounces);
        return;
    }
    const struct plan_light *l = &p->light;
    consider_biased(&c[PLAN_DIRECT], l->beyond_direct, l->beyond_direct_error, l->direct_paths);
    consider_biased(&c[PLAN_WHITTED], l->beyond_whitted, l->beyond_whitted_error, l->whitted_paths);
    for (int k = PLAN_PATH_BSDF; k <= PLAN_PATH_LIGHT; k++)
        if (shared_lights(f) == 0)
            rule(&c[k], PLAN_RULED_OUT, "no light that both ways can find: it is the same as mis");
    if (shared_lights(f) > 0) {
        consider_bsdf(f, &c[PLAN_PATH_BSDF]);
        consider_light(f, &c[PLAN_PATH_LIGHT]);
    }
}

static uint32_t at_most(double n, uint32_t most)
{
    return n < most ? (uint32_t)n : most;
}

static double samples_of(const struct plan *p)
{
    return PLAN_SAMPLES * (double)p->pixels;
}

uint32_t plan_places(const struct plan *p)
{
    return at_most(PLACE_SHARE * samples_of(p) / PLACE_SAMPLES, MOST_PLACES);
}

uint32_t plan_light_paths(const struct plan *p)
{
    return at_most(LIGHT_SHARE * samples_of(p), MOST_PATHS);
}

static void size_pilots(struct plan *p, uint32_t count, bool may_pilot)
{
    const double samples = (1 - PLACE_SHARE) * samples_of(p) / (count * PLAN_PILOT_SPP);
    const uint32_t fit = at_most(samples, MOST_PIXELS) / 4 * 4;
    if (count == 1)
        snprintf(p->why_no_pilot, PLAN_WHY, "there is nothing to choose from");
    else if (!may_pilot)
        snprintf(p->why_no_pilot, PLAN_WHY, "the scene is too large to be copied");
    else if (fit < PLAN_LEAST_PIXELS)
        snprintf(p->why_no_pilot, PLAN_WHY, "%llu pixels are too few for pilots of %u methods",
                 (unsigned long long)p->pixels, count);
    else
        p->pilot_pixels = fit;
}

void plan_consider(struct plan *p, bool may_pilot)
{
    uint32_t count = 0;
    p->pilot_pixels = 0;
    p->why_no_pilot[0] = '\0';
    consider_each(p);
    consider_absent(p);
    for (int k = 0; k < PLAN_REAL; k++)
        count += p->candidates[k].verdict == PLAN_DEARER;
    size_pilots(p, count, may_pilot);
}

/* --- the choice --- */

double plan_price(const struct plan_pilot *pilot)
{
    return pilot->variance * pilot->work;
}

/* What the usual method's pilot shows as well is the scene's, which the others are no safer from.
 */
static bool is_tailed(const struct plan *p, int k)
{
    const struct plan_pilot *c = &p->candidates[k].pilot;
    const struct plan_pilot *usual = &p->candidates[PLAN_PATH_MIS].pilot;
    return c->tail > max_f64(MOST_TAIL, 1.2 * usual->tail) ||
           c->thin > max_f64(MOST_THIN, 2 * usual->thin);
}

static bool is_rival(const struct plan *p, int k)
{
    return p->candidates[k].tried && !is_tailed(p, k);
}

static void say_why(struct plan *p, int k, double least)
{
    struct plan_candidate *c = &p->candidates[k];
    if (is_tailed(p, k))
        rule(
            c, PLAN_TAILED,
            "%.0f %% of its variance is in 2 %% of the pixels, %.1f %% of the pixels hang on a few "
            "samples",
            100 * c->pilot.tail, 100 * c->pilot.thin);
    else
        rule(c, PLAN_DEARER, "variance x work is %.3g times the least",
             plan_price(&c->pilot) / least);
}

static void choose_by_pilots(struct plan *p)
{
    double least = (double)__builtin_inff();
    for (int k = 0; k < PLAN_REAL; k++) {
        const double price = plan_price(&p->candidates[k].pilot);
        least = is_rival(p, k) && price < least ? price : least;
    }
    for (int k = PLAN_REAL; k-- > 0;)
        if (is_rival(p, k) && plan_price(&p->candidates[k].pilot) <= CLOSE * least)
            p->chosen = (enum plan_candidate_kind)k;
    for (int k = 0; k < PLAN_REAL; k++)
        if (p->candidates[k].tried)
            say_why(p, k, least);
    rule(&p->candidates[p->chosen], PLAN_CHOSEN,
         "the simplest within 5 %% of the least variance x work");
}

void plan_choose(struct plan *p)
{
    if (p->pilot_pixels > 0) {
        choose_by_pilots(p);
        return;
    }
    for (int k = 0; k < PLAN_REAL; k++)
        if (p->candidates[k].verdict == PLAN_DEARER)
            rule(&p->candidates[k], PLAN_DEARER, "not tried: %.*s", PLAN_WHY - 16, p->why_no_pilot);
    rule(&p->candidates[PLAN_PATH_MIS], PLAN_CHOSEN, "the usual method: %.*s", PLAN_WHY - 32,
         p->why_no_pilot);
}

/* --- the forecast --- */

void plan_forecast(struct plan *p, double spp, double factor)
{
    p->forecast_spp = spp;
    p->forecast = spp * p->outlook.work * (double)p->pixels;
    p->forecast_low = p->is_asked ? p->forecast / factor : p->forecast;
    p->forecast_high = p->is_asked ? p->forecast * factor : p->forecast;
}
