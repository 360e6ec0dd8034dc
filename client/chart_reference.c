/* What the runs of a chart are held against: the mean of two methods that are shown to be equal, by
 * two one-sided tests (D. Schuirmann, J. Pharmacokinetics and Biopharmaceutics 15, 1987).
 * SPDX-License-Identifier: MIT */
#include <math.h>
#include <string.h>

#include "client/chart.h"

#define MARGIN      0.01 /* of the image's mean */
#define LEVEL       0.01 /* for calling them equal */
#define LOCAL_LEVEL 1e-4 /* for calling a block different, over all blocks */
#define LOCAL_LEAST 0.03 /* of its own mean: less is not looked at */

enum { RUNS = CHART_REFERENCE_RUNS, SIDE = 8 };

static const struct chart_method first = {"path-mis", INTEGRATOR_PATH, STRATEGY_MIS, SAMPLER_SOBOL};

/* Other ways to find the same light. */
static const struct chart_method others[] = {
    {"path-light", INTEGRATOR_PATH, STRATEGY_LIGHT, SAMPLER_SOBOL},
    {"path-bsdf", INTEGRATOR_PATH, STRATEGY_BSDF, SAMPLER_SOBOL},
};

struct side { /* one method's runs */
    const struct chart_run *runs;
    double *mean;
    double noise;              /* relMSE of the mean, against itself */
    struct curve_value energy; /* mean over pixels and channels */
};

static double mean_of(const double *image, size_t values)
{
    double sum = 0;
    for (size_t i = 0; i < values; i++)
        sum += image[i];
    return sum / (double)values;
}

static void judge(struct side *s, size_t values, struct arena *arena)
{
    double energy[RUNS], noise = 0;
    s->mean = arena_new(arena, double, values);
    for (int r = 0; r < RUNS; r++) {
        energy[r] = mean_of(s->runs[r].image, values);
        for (size_t i = 0; i < values; i++)
            s->mean[i] += s->runs[r].image[i] / RUNS;
    }
    s->energy = curve_mean(energy, RUNS);
    const double least = 0.01 * s->energy.at;
    for (size_t i = 0; i < values; i++) {
        double square = 0;
        for (int r = 0; r < RUNS; r++)
            square += (s->runs[r].image[i] - s->mean[i]) * (s->runs[r].image[i] - s->mean[i]);
        if (square > 0)
            noise += square / (RUNS - 1) / RUNS / (s->mean[i] * s->mean[i] + least * least);
    }
    s->noise = noise / (double)values;
}

static bool run_side(struct side *s, const struct chart_method *m, const struct scene *scene,
                     struct chart_crew *crew, uint32_t spp, uint32_t of, struct arena *arena,
                     struct err *err)
{
    const struct stage *stage;
    if (!chart_prepare(scene, m, &stage, arena, err))
        return false;
    struct chart_run *runs = chart_make_runs(stage, spp, RUNS, scene->settings.seed, of, arena);
    chart_runs_do(crew, runs, RUNS);
    s->runs = runs;
    judge(s, 3 * chart_runs_pixels(stage), arena);
    return true;
}

/* The one of the others with less noise after a few samples. */
static bool choose(const struct scene *scene, struct chart_crew *crew,
                   const struct chart_method **chosen, struct arena *arena, struct err *err)
{
    double least = (double)INFINITY;
    *chosen = &others[0];
    for (uint32_t i = 0; i < countof(others); i++) {
        struct side s;
        if (!run_side(&s, &others[i], scene, crew, CHART_FIRST_SPP, 1000 + i, arena, err))
            return false;
        if (s.noise < least) {
            least = s.noise;
            *chosen = &others[i];
        }
    }
    return true;
}

static bool is_equal_on_the_whole(struct chart_reference *r, const struct side s[2],
                                  struct err *err)
{
    /* Half an interval is the standard error times what 7 degrees of freedom ask for. */
    const double t = (s[0].energy.high - s[0].energy.at) + (s[1].energy.high - s[1].energy.at);
    const double mean = 0.5 * (s[0].energy.at + s[1].energy.at), factor = 2.364624;
    const double a = (s[0].energy.high - s[0].energy.at) / factor;
    const double b = (s[1].energy.high - s[1].energy.at) / factor;
    const double both = a * a + b * b;
    const double dof = both > 0 ? both * both / (a * a * a * a + b * b * b * b) * (RUNS - 1) : 1;
    r->margin = MARGIN;
    r->off = s[0].energy.at / s[1].energy.at - 1;
    r->p = curve_unequal_p(s[0].energy.at - s[1].energy.at, sqrt(both), dof, MARGIN * mean);
    return r->p < LEVEL ||
           err_set(err, ERR_INPUT,
                   "the references of %s and %s, %u samples each, are not shown to be equal "
                   "within %g %%: means %.6g and %.6g, +- %.2g; ask for a larger --reference",
                   r->methods[0]->name, r->methods[1]->name, r->spp, 100 * MARGIN, s[0].energy.at,
                   s[1].energy.at, t);
}

struct patch {
    uint32_t x_begin, y_begin, x_end, y_end;
};

static double mean_in_block(const double *image, const struct patch *b, uint32_t width)
{
    double sum = 0;
    for (uint32_t y = b->y_begin; y < b->y_end; y++)
        for (uint32_t i = 3 * b->x_begin; i < 3 * b->x_end; i++)
            sum += image[(size_t)y * 3 * width + i];
    return sum / (3. * (b->x_end - b->x_begin) * (b->y_end - b->y_begin));
}

/* Not to be told from equal, in a block of pixels. */
static bool is_equal_in(const struct side s[2], const struct patch *b, uint32_t width,
                        double blocks)
{
    struct curve_value mean[2];
    for (int k = 0; k < 2; k++) {
        double values[RUNS];
        for (int r = 0; r < RUNS; r++)
            values[r] = mean_in_block(s[k].runs[r].image, b, width);
        mean[k] = curve_mean(values, RUNS);
    }
    const double off = fabs(mean[0].at - mean[1].at);
    const double half = hypot(mean[0].high - mean[0].at, mean[1].high - mean[1].at) / 2.364624;
    return off < LOCAL_LEAST * fmax(mean[0].at, mean[1].at) || half == 0 ||
           curve_unequal_p(0, half, 2 * (RUNS - 1), off) > LOCAL_LEVEL / blocks;
}

static bool is_equal_everywhere(const struct chart *c, const struct side s[2], struct err *err)
{
    const double blocks = ceil(c->width_px / (double)SIDE) * ceil(c->height_px / (double)SIDE);
    for (uint32_t y = 0; y < c->height_px; y += SIDE)
        for (uint32_t x = 0; x < c->width_px; x += SIDE) {
            const struct patch b = {x, y, min_u32(x + SIDE, c->width_px),
                                    min_u32(y + SIDE, c->height_px)};
            if (!is_equal_in(s, &b, c->width_px, blocks))
                return err_set(err, ERR_INPUT,
                               "the references of %s and %s differ at pixels (%u, %u) to (%u, "
                               "%u): one of them is wrong, or misses what the other finds once "
                               "in very many samples; ask for a larger --reference",
                               c->reference.methods[0]->name, c->reference.methods[1]->name, x, y,
                               b.x_end - 1, b.y_end - 1);
        }
    return true;
}

bool chart_refer(struct chart *c, const struct scene *scene, struct chart_crew *crew,
                 struct arena *arena, struct err *err)
{
    struct chart_reference *r = &c->reference;
    struct side s[2];
    r->methods[0] = &first;
    r->spp = c->options.reference_spp;
    if (!choose(scene, crew, &r->methods[1], arena, err))
        return false;
    for (uint32_t i = 0; i < 2; i++)
        if (!run_side(&s[i], r->methods[i], scene, crew, r->spp / RUNS, 1100 + i, arena, err))
            return false;
    if (!(s[0].energy.at > 0) || !(s[1].energy.at > 0))
        return err_set(
            err, ERR_INPUT,
            "there is no light in the image: its error relative to black has no meaning");
    if (!is_equal_on_the_whole(r, s, err) || !is_equal_everywhere(c, s, err))
        return false;
    const size_t values = 3 * (size_t)c->width_px * c->height_px;
    const double sum = s[0].noise + s[1].noise, part = sum > 0 ? s[1].noise / sum : 0.5;
    r->image = arena_new(arena, double, values);
    for (size_t i = 0; i < values; i++)
        r->image[i] = part * s[0].mean[i] + (1 - part) * s[1].mean[i];
    r->noise = part * part * s[0].noise + (1 - part) * (1 - part) * s[1].noise;
    for (int k = 0; k < 2; k++)
        r->mean[k] = s[k].energy.at;
    return true;
}
