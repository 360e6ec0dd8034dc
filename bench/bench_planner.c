/* Does the planner choose the cheapest sufficient method, and does it pay for itself?
 *
 * Each method renders each scene of the corpus until it is as good as asked or has had its share of
 * work (oracle.h). All is counted work, so that the figures do not depend on the machine. Regret:
 * (planning + the chosen method's work) over the least work of a sufficient method. Scenes are
 * taken by as many threads as there are processors.
 *
 *     bench_planner [--quick] [CSV]      --quick: a third of the work
 *
 * SPDX-License-Identifier: MIT */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "bench/corpus.h"
#include "bench/oracle.h"
#include "common/base.h"
#include "common/trace/study.h"
#include "tests/gang.h"
#include "tests/scale.h"

enum { MOST_SCENES = 64, TARGETS = ORACLE_TARGETS, SEEDS = 20 };

static const double most_units = 1e9; /* of a method on a scene; four times that of the chosen */

struct figure {
    double regret;
    double forecast; /* over what it was, or the other way: at least 1 */
    double price;    /* of planning, over the usual method's work */
    bool is_plain;   /* nothing is cheaper than the usual method: planning cannot gain anything */
    bool is_insufficient;
    bool is_measured; /* the chosen method was seen to get half as far, at least */
};

struct result { /* of a scene */
    bool is_there;
    struct figure of[TARGETS];
    uint32_t perturbed, same, near;
};

struct bench {
    double share; /* of work */
    FILE *csv;
    struct result results[MOST_SCENES];
};

/* --- plans --- */

static struct plan plan_of(struct scenes *s, struct scene_target target)
{
    struct plan plan;
    struct arena scratch = {0};
    s->scene.settings.integrator = INTEGRATOR_AUTO;
    s->scene.settings.strategy = STRATEGY_MIS;
    s->scene.settings.target = target;
    study_make(scenes_stage(s), NULL, &scratch, &plan);
    arena_release(&scratch);
    return plan;
}

static struct plan plan_for(struct scenes *s, double error)
{
    return plan_of(s, (struct scene_target){.error = error, .spp = SCENE_MAX_SPP});
}

/* The method does not depend on the target: this one needs the least of an outlook. */
static enum plan_candidate_kind method_of(struct scenes *s)
{
    return plan_of(s, (struct scene_target){.spp = 1}).chosen;
}

static const char *const part_names[] = {[CORPUS_TUNED] = "tuned on",
                                         [CORPUS_HELD_OUT] = "held out",
                                         [CORPUS_FRESH] = "fresh",
                                         [CORPUS_LAST] = "last"};

static double least_of(const struct oracle *o, double error, enum plan_candidate_kind *which)
{
    double least = (double)INFINITY;
    for (int k = 0; k < PLAN_REAL; k++) {
        const double units = oracle_units(&o->of[k], error);
        if (units < least) {
            least = units;
            *which = (enum plan_candidate_kind)k;
        }
    }
    return least;
}

static void write_row(FILE *csv, uint32_t scene, double error, const struct plan *plan,
                      enum plan_candidate_kind best, const struct oracle *o)
{
    char units[PLAN_REAL][16];
    for (int k = 0; k < PLAN_REAL; k++)
        snprintf(units[k], sizeof units[k], "%.4g", oracle_units(&o->of[k], error));
    fprintf(csv, "\"%s\",%s,%g,\"%s\",\"%s\",%.4g,%.4g,%s,%s,%s,%s,%s\n", corpus_name(scene),
            part_names[corpus_part(scene)], error, plan_candidate_name(plan->chosen),
            plan_candidate_name(best), plan->studied, plan->forecast, units[PLAN_DIRECT],
            units[PLAN_WHITTED], units[PLAN_PATH_BSDF], units[PLAN_PATH_LIGHT],
            units[PLAN_PATH_MIS]);
}

static struct figure judge(const struct bench *b, uint32_t scene, struct scenes *s,
                           const struct oracle *o, double error)
{
    const struct plan plan = plan_for(s, error);
    enum plan_candidate_kind best = PLAN_PATH_MIS;
    const double least = least_of(o, error, &best);
    const double chosen = oracle_units(&o->of[plan.chosen], error);
    const double usual = oracle_units(&o->of[PLAN_PATH_MIS], error);
    const double truth = oracle_units(&o->chosen, error), reach = oracle_reach(&o->chosen, error);
    const struct figure f = {
        .regret = (plan.studied + chosen) / least,
        .forecast = fmax(plan.forecast / truth, truth / plan.forecast),
        .price = plan.studied / usual,
        .is_plain = usual <= least,
        .is_insufficient = isinf(chosen),
        .is_measured = reach <= 2,
    };
    char far[40] = "";
    if (!f.is_measured)
        snprintf(far, sizeof far, "  (extrapolated x %.0f)", reach);
    printf("%-17s %-8s %2.0f %%  %-11s %-11s regret %5.3f  planning %5.2f %%  forecast x "
           "%.2f%s%s\n",
           corpus_name(scene), part_names[corpus_part(scene)], 100 * error,
           plan_candidate_name(plan.chosen), plan_candidate_name(best), f.regret, 100 * f.price,
           plan.forecast / truth, far, plan.pilot_pixels ? "" : "  no pilot");
    fflush(stdout);
    if (b->csv)
        write_row(b->csv, scene, error, &plan, best, o);
    return f;
}

/* --- what should not matter --- */

static void shift_camera(struct scenes *s, float by)
{
    for (int i = 0; i < 3; i++)
        s->scene.camera.to_world.m[i][3] *= 1 + (i == 1 ? -by : by);
}

static void perturb(struct scenes *s, uint32_t i)
{
    switch (i) {
    case 0:
        shift_camera(s, .01f);
        break;
    case 1:
        shift_camera(s, -.01f);
        break;
    case 2:
        scale_lengths(&s->scene, 1e-3f);
        break;
    case 3:
        scale_lengths(&s->scene, 1e3f);
        break;
    case 4:
        scale_radiance(&s->scene, 1e-6f);
        break;
    case 5:
        scale_radiance(&s->scene, 1e6f);
        break;
    default:
        s->scene.settings.seed = i;
    }
}

static bool is_near(const struct oracle *o, enum plan_candidate_kind a, enum plan_candidate_kind b)
{
    for (int t = 0; t < TARGETS; t++) {
        const double x = oracle_units(&o->of[a], oracle_targets[t]);
        const double y = oracle_units(&o->of[b], oracle_targets[t]);
        if (!(x <= 1.1 * y && y <= 1.1 * x))
            return false;
    }
    return true;
}

static void shake(uint32_t scene, const struct oracle *o, enum plan_candidate_kind first,
                  struct result *to)
{
    for (uint32_t i = 0; i < 6 + SEEDS; i++) {
        struct scenes s;
        if (!corpus_make(scene, &s))
            return;
        perturb(&s, i);
        const enum plan_candidate_kind k = method_of(&s);
        to->perturbed++;
        to->same += k == first;
        to->near += k == first || is_near(o, k, first);
        if (k != first)
            printf("%-17s   perturbed (%u): %s\n", corpus_name(scene), i, plan_candidate_name(k));
        scenes_release(&s);
    }
}

static void try(void *user, uint32_t scene)
{
    struct bench *b = user;
    struct result *r = &b->results[scene];
    struct scenes s;
    struct oracle o;
    if (!corpus_make(scene, &s)) {
        printf("%-17s left out: its files are not here\n", corpus_name(scene));
        return;
    }
    const enum plan_candidate_kind first = method_of(&s);
    oracle_ask(&s, b->share, first, &o);
    r->is_there = true;
    for (int t = 0; t < TARGETS; t++)
        r->of[t] = judge(b, scene, &s, &o, oracle_targets[t]);
    scenes_release(&s);
    shake(scene, &o, first, r);
}

/* --- all of it --- */

static int by_size(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

struct forecasts {
    double off[TARGETS * MOST_SCENES];
    uint32_t count;
};

static void say_forecasts(struct forecasts *f, const char *which)
{
    uint32_t twice = 0;
    if (f->count == 0)
        return;
    for (uint32_t i = 0; i < f->count; i++)
        twice += f->off[i] <= 2;
    qsort(f->off, f->count, sizeof *f->off, by_size);
    printf("  forecasts within a factor of 2%s: %.1f %% of %u (90 %%), median %.2f (1.3), worst "
           "%.1f\n",
           which, 100.0 * twice / f->count, f->count, f->off[f->count / 2], f->off[f->count - 1]);
}

struct sums {
    double logs, worst, plain, price;
    uint32_t count, good, insufficient, perturbed, same, near;
    struct forecasts all, measured;
};

static void add_figure(struct sums *to, const struct figure *g)
{
    to->count++;
    to->good += g->regret <= 1.1;
    to->logs += log(g->regret);
    to->worst = fmax(to->worst, g->regret);
    to->price = fmax(to->price, g->price);
    to->plain = g->is_plain ? fmax(to->plain, g->regret) : to->plain;
    to->insufficient += g->is_insufficient;
    to->all.off[to->all.count++] = g->forecast;
    if (g->is_measured)
        to->measured.off[to->measured.count++] = g->forecast;
}

static void add_result(struct sums *to, const struct result *r)
{
    for (int t = 0; t < TARGETS; t++)
        add_figure(to, &r->of[t]);
    to->perturbed += r->perturbed;
    to->same += r->same;
    to->near += r->near;
}

/* part: CORPUS_PARTS for all. */
static void say_part(const struct bench *b, enum corpus_part part)
{
    struct sums sums = {.count = 0};
    for (uint32_t i = 0; i < corpus_count(); i++)
        if (b->results[i].is_there && (part == CORPUS_PARTS || corpus_part(i) == part))
            add_result(&sums, &b->results[i]);
    if (sums.count == 0)
        return;
    printf("\n%s (%u)\n", part == CORPUS_PARTS ? "all" : part_names[part], sums.count);
    printf("  regret at most 1.10 in %.1f %% (90 %%), worst %.2f (1.5), geometric mean %.3f "
           "(1.05)\n",
           100.0 * sums.good / sums.count, sums.worst, exp(sums.logs / sums.count));
    printf("  insufficient methods chosen: %u (0)\n", sums.insufficient);
    printf("  total where the usual method is the cheapest: at most %.3f of it (1.02)\n",
           sums.plain);
    printf("  planning: at most %.2f %% of the usual method's work\n", 100 * sums.price);
    say_forecasts(&sums.all, "");
    say_forecasts(&sums.measured, ", truth not extrapolated by more than 2");
    printf("  perturbed: the same choice in %.1f %% of %u, that or one within 10 %% in %.1f %% "
           "(95 %%)\n",
           100.0 * sums.same / sums.perturbed, sums.perturbed, 100.0 * sums.near / sums.perturbed);
}

int main(int argc, char **argv)
{
    static struct bench b;
    const long processors = sysconf(_SC_NPROCESSORS_ONLN);
    struct gang gang = {.threads = processors < 1           ? 1
                                   : processors < TEAM_MOST ? (uint32_t)processors
                                                            : TEAM_MOST};
    b.share = most_units;
    if (argc > 1 && !strcmp(argv[1], "--quick")) {
        b.share /= 3;
        argc--, argv++;
    }
    if (argc > 1 && !(b.csv = fopen(argv[1], "w"))) {
        fprintf(stderr, "bench_planner: %s cannot be written\n", argv[1]);
        return 5;
    }
    if (b.csv)
        fprintf(b.csv, "scene,part,error,chosen,best,planning,forecast,direct,whitted,bsdf,light,"
                       "mis\n");
    printf("%u scenes; the method chosen, the cheapest one\n", corpus_count());
    const struct crew crew = gang_crew(&gang);
    crew_run(&crew, try, &b, corpus_count());
    for (int part = 0; part <= CORPUS_PARTS; part++)
        say_part(&b, (enum corpus_part)part);
    if (b.csv)
        fclose(b.csv);
    return 0;
}
