/* SPDX-License-Identifier: MIT */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "client/chart.h"
#include "common/plan.h"
#include "common/trace/study.h"

static const struct chart_method methods[] = {
    {"path-mis", INTEGRATOR_PATH, STRATEGY_MIS, SAMPLER_SOBOL},
    {"path-light", INTEGRATOR_PATH, STRATEGY_LIGHT, SAMPLER_SOBOL},
    {"path-bsdf", INTEGRATOR_PATH, STRATEGY_BSDF, SAMPLER_SOBOL},
    {"path-mis, independent", INTEGRATOR_PATH, STRATEGY_MIS, SAMPLER_INDEPENDENT},
    {"path-mis, stratified", INTEGRATOR_PATH, STRATEGY_MIS, SAMPLER_STRATIFIED},
    {"direct", INTEGRATOR_DIRECT, STRATEGY_MIS, SAMPLER_SOBOL},
    {"whitted", INTEGRATOR_WHITTED, STRATEGY_LIGHT, SAMPLER_SOBOL},
};

_Static_assert(countof(methods) <= CHART_MOST_LINES, "a line each");

#define MISSING      1e-3 /* of the energy: less is not told from none */
#define FLOOR_FACTOR 3    /* of the reference's noise: nearer, a point says little */

static uint32_t point_count(const struct chart_options *o)
{
    uint32_t n = 0;
    while (n < CURVE_MOST_POINTS && (uint32_t)CHART_FIRST_SPP << n <= o->spp)
        n++;
    return n;
}

uint32_t chart_run_count(const struct scene *scene, const struct chart_options *o)
{
    (void)scene;
    return 4 * CHART_REFERENCE_RUNS + (uint32_t)countof(methods) * point_count(o) * o->runs +
           (1 + CHART_MOST_PIECES) * o->runs;
}

double chart_energy(const struct chart *c, const double *image)
{
    double sum = 0, of_reference = 0;
    for (size_t i = 0; i < 3 * (size_t)c->width_px * c->height_px; i++) {
        sum += image[i];
        of_reference += c->reference.image[i];
    }
    return sum / of_reference - 1;
}

/* --- a point --- */

static void fill_point(const struct chart *c, struct chart_line *line, uint32_t point,
                       const struct chart_run runs[], double *scratch)
{
    const size_t pixels = (size_t)c->width_px * c->height_px;
    const uint32_t n = c->options.runs;
    struct chart_point *p = &line->points[point];
    line->curve.work[point] = 0;
    p->spp = runs[0].spp;
    p->trimmed = p->unknown = p->heavy = 0;
    for (uint32_t r = 0; r < n; r++) {
        double trimmed;
        line->curve.work[point] += (double)runs[r].work.units / n;
        line->curve.error[point][r] =
            curve_relmse(runs[r].image, c->reference.image, pixels, &trimmed, scratch);
        p->trimmed += trimmed / n;
        p->unknown += runs[r].unknown / n;
        p->heavy += runs[r].heavy / n;
    }
    p->error = curve_at(&line->curve, point);
    double most = 0;
    for (uint32_t r = 0; r < n; r++)
        most = fmax(most, line->curve.error[point][r]);
    p->tail = p->trimmed < 0.5 * p->error.at || most > 0.5 * n * p->error.at;
    p->near_floor = p->error.at < FLOOR_FACTOR * c->reference.noise;
}

/* --- a line --- */

/* What the last point's runs say together. */
static void fill_last(const struct chart *c, struct chart_line *line, const struct chart_run runs[])
{
    const uint32_t n = c->options.runs;
    double energy[CURVE_MOST_RUNS], *images[CURVE_MOST_RUNS];
    for (uint32_t r = 0; r < n; r++) {
        images[r] = runs[r].image;
        energy[r] = chart_energy(c, runs[r].image);
    }
    line->energy = curve_mean(energy, n);
    line->missing = line->method->integrator != INTEGRATOR_PATH && line->energy.high < -MISSING;
    line->bias2 = curve_bias2(images, n, c->reference.image, (size_t)c->width_px * c->height_px);
    line->bias2.at -= c->reference.noise;
    line->bias2.low -= c->reference.noise;
    line->bias2.high -= c->reference.noise;
}

static int ascending(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

struct rates { /* seconds per unit, of runs */
    double *ns;
    uint32_t count;
};

static double quantile(struct rates r, double part)
{
    qsort(r.ns, r.count, sizeof *r.ns, ascending);
    return r.ns[(uint32_t)(part * (r.count - 1) + 0.5)];
}

static bool fill_line(struct chart *c, const struct scene *scene, uint32_t number,
                      struct chart_crew *crew, struct rates *rates, struct err *err)
{
    struct arena arena = {0};
    struct chart_line *line = &c->lines[number];
    const struct stage *stage;
    const uint32_t n = c->options.runs;
    const struct rates of_line = {rates->ns + rates->count, c->point_count * n};
    line->method = &methods[number];
    line->curve.points = c->point_count;
    line->curve.runs = n;
    if (!chart_prepare(scene, line->method, &stage, &arena, err)) {
        arena_release(&arena);
        return false;
    }
    for (uint32_t p = 0; p < c->point_count; p++) {
        struct arena images = {0};
        struct chart_run *runs = chart_make_runs(stage, CHART_FIRST_SPP << p, n,
                                                 scene->settings.seed, number * 32 + p, &images);
        chart_runs_do(crew, runs, n);
        fill_point(c, line, p, runs,
                   arena_new(&images, double, (size_t)c->width_px * c->height_px));
        if (p + 1 == c->point_count)
            fill_last(c, line, runs);
        for (uint32_t r = 0; r < n; r++)
            rates->ns[rates->count++] = runs[r].seconds * 1e9 / fmax((double)runs[r].work.units, 1);
        arena_release(&images);
    }
    line->unit_ns = quantile(of_line, 0.5);
    arena_release(&arena);
    return true;
}

static void fill_table(struct chart *c)
{
    for (uint32_t i = 0; i < c->line_count; i++) {
        struct chart_line *line = &c->lines[i];
        uint32_t end = 0;
        while (end < c->point_count && !line->points[end].near_floor)
            end++;
        line->slope = curve_slope(&line->curve, 0, end);
        for (int t = 0; t < CHART_TARGETS; t++)
            line->work_to[t] = curve_work_to(&line->curve, chart_targets[t] * chart_targets[t]);
        line->gain = curve_gain(&line->curve, &c->lines[0].curve);
    }
    c->best = c->best_target = -1;
    for (int t = 0; t < CHART_TARGETS; t++)
        for (uint32_t i = 0; i < c->line_count; i++) {
            const double work = c->lines[i].work_to[t].at;
            if (c->lines[i].missing || isnan(work))
                continue;
            if (c->best_target != t || work < c->lines[c->best].work_to[t].at) {
                c->best = (int32_t)i;
                c->best_target = t;
            }
        }
}

/* What "auto" would take for the hardest target that some method reaches. */
static bool ask_planner(struct chart *c, const struct scene *scene, struct err *err)
{
    struct arena arena = {0};
    struct scene s = *scene;
    struct plan plan;
    const struct stage *stage;
    s.settings.target = (struct scene_target){
        .error = chart_targets[c->best_target < 0 ? 0 : c->best_target], .spp = SCENE_MAX_SPP};
    const bool good = chart_prepare(&s, c->lines[0].method, &stage, &arena, err);
    if (good && study_make(stage, NULL, &arena, &plan)) {
        const struct plan_method m = plan_method_of(&plan, plan.chosen);
        for (uint32_t i = c->line_count; i-- > 0;)
            if (methods[i].integrator == m.integrator && methods[i].strategy == m.strategy &&
                methods[i].sampler == SAMPLER_SOBOL)
                c->planned = (int32_t)i;
    }
    arena_release(&arena);
    return good;
}

/* Noise in some pixel, of the reference's at least: else there is nothing to chart. */
static bool is_noisy(const struct chart *c, struct err *err)
{
    for (uint32_t i = 0; i < c->line_count; i++)
        if (!c->lines[i].missing && c->lines[i].points[0].error.at > 0)
            return true;
    return err_set(err, ERR_INPUT,
                   "every method finds the whole image without noise; there is nothing to chart");
}

bool chart_measure(struct chart *c, const struct scene *scene, const struct chart_options *o,
                   struct chart_crew *crew, struct arena *arena, struct err *err)
{
    const struct scene small = chart_shrunk(scene, o->size_px);
    const struct scene_film *f = &small.film;
    *c = (struct chart){
        .title = scene->title,
        .width_px = f->crop_x_end - f->crop_x_begin,
        .height_px = f->crop_y_end - f->crop_y_begin,
        .options = *o,
        .line_count = (uint32_t)countof(methods),
        .point_count = point_count(o),
        .planned = -1,
    };
    if (!chart_refer(c, &small, crew, arena, err))
        return false;
    struct rates rates = {arena_new(arena, double, c->line_count * c->point_count * o->runs), 0};
    for (uint32_t i = 0; i < c->line_count; i++)
        if (!fill_line(c, &small, i, crew, &rates, err))
            return false;
    c->unit_ns[0] = quantile(rates, 0.05);
    c->unit_ns[1] = quantile(rates, 0.5);
    c->unit_ns[2] = quantile(rates, 0.95);
    fill_table(c);
    return is_noisy(c, err) && ask_planner(c, &small, err);
}
