/* SPDX-License-Identifier: MIT */
#include "tests/stability/trial.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "common/film.h"
#include "common/trace/medium.h"
#include "tests/naive_path.h"
#include "tests/scenes.h"
#include "tests/stability/split.h"

enum { SIDE = 8, UNITS = SIDE * SIDE * FILM_REPLICATES, FIRST_SPP = 64, LEAST_N_EFF = 8 };

struct tally { /* of the three channels' sum */
    double mean, error;
    double n_eff; /* of parts that make up the error; 0: nothing was found */
    bool made;
};

/* x: means of independent parts of a pixel's samples, by pixel and replicate. */
static struct tally tally_of(const double x[UNITS])
{
    double sum = 0, square = 0, fourth = 0;
    for (int p = 0; p < SIDE * SIDE; p++) {
        double mean = 0;
        for (int r = 0; r < FILM_REPLICATES; r++)
            mean += x[p * FILM_REPLICATES + r] / FILM_REPLICATES;
        sum += mean;
        for (int r = 0; r < FILM_REPLICATES; r++) {
            const double off = x[p * FILM_REPLICATES + r] - mean;
            square += off * off;
            fourth += off * off * off * off;
        }
    }
    const double error = sqrt(square / (FILM_REPLICATES * (FILM_REPLICATES - 1)));
    return (struct tally){sum / (SIDE * SIDE), error / (SIDE * SIDE),
                          fourth > 0 ? square * square / fourth
                          : sum > 0  ? UNITS
                                     : 0,
                          true};
}

/* --- methods --- */

enum by { BY_FILM, BY_PATHS, BY_NAIVE };

struct method {
    const char *name;
    enum by by;
    enum strategy_kind strategy;
    enum sampler_kind sampler;
    bool split;
};

static void by_film(const struct stage *s, uint32_t spp, double x[UNITS])
{
    struct film film;
    scenes_render(s, spp, &film);
    for (int i = 0; i < UNITS; i++) {
        const float *sum = film.replicate + (size_t)3 * i;
        x[i] = ((double)sum[0] + (double)sum[1] + (double)sum[2]) / (spp / FILM_REPLICATES);
    }
    film_release(&film);
}

/* Roulette never ends them. */
static void by_paths(const struct stage *s, uint32_t spp, double x[UNITS])
{
    for (uint32_t p = 0; p < SIDE * SIDE; p++)
        for (uint32_t i = 0; i < spp; i++) {
            const rgb c = trial_path(s, p % SIDE, p / SIDE, i, UINT32_MAX);
            x[p * FILM_REPLICATES + i % FILM_REPLICATES] +=
                ((double)c[0] + (double)c[1] + (double)c[2]) / (spp / FILM_REPLICATES);
        }
}

static void by_naive(const struct stage *s, uint32_t spp, double x[UNITS])
{
    struct dice dice = dice_make(s->settings.seed);
    for (uint32_t p = 0; p < SIDE * SIDE; p++)
        for (uint32_t i = 0; i < spp; i++) {
            double sum[3] = {0, 0, 0};
            naive_path_sample(s, p % SIDE, p / SIDE, &dice, sum);
            x[p * FILM_REPLICATES + i % FILM_REPLICATES] +=
                (sum[0] + sum[1] + sum[2]) / (spp / FILM_REPLICATES);
        }
}

static struct tally measure(const struct scene *from, const struct method *m, uint32_t round)
{
    static void (*const ways[])(const struct stage *, uint32_t, double[UNITS]) = {
        [BY_FILM] = by_film, [BY_PATHS] = by_paths, [BY_NAIVE] = by_naive};
    struct arena arena = {0};
    double x[UNITS] = {0};
    const uint32_t spp = FIRST_SPP << 4 * round;
    struct scene s = *from;
    s.settings.strategy = m->strategy;
    s.settings.sampler = m->sampler;
    s.settings.target.spp = spp;
    for (const char *c = m->name; *c; c++) /* the same numbers would prove nothing */
        s.settings.seed = s.settings.seed * 31 + (uint64_t)*c + round;
    s.settings.seed %= (uint64_t)1 << 53;
    if (m->split)
        split_lamps(&s, &arena);
    ways[m->by](trial_stage(&s, &arena), spp, x);
    arena_release(&arena);
    return tally_of(x);
}

/* --- verdicts --- */

/* In rounds: off beyond what is chance, and by as much as before. */
struct suspicion {
    double off, before;
    bool judged;
};

static bool still_off(struct suspicion *s, double off, double error, double size, double n_eff)
{
    s->judged = n_eff >= LEAST_N_EFF;
    s->before = s->off;
    s->off = off;
    return s->judged && fabs(off) > 4.5 * error + 2e-5 * size;
}

static enum trial_verdict verdict_of(const struct suspicion *s, uint32_t round)
{
    if (round > 0 && (s->off * s->before < 0 || fabs(s->off) < .5 * fabs(s->before)))
        return TRIAL_UNJUDGED;
    return TRIAL_FAILS;
}

/* usual: what it is compared with, by round; measured when it is asked for. */
static enum trial_verdict agrees(const struct wild *w, const struct method *m, uint32_t rounds,
                                 struct tally usual[], char why[240])
{
    static const struct method mis = {"mis", BY_FILM, STRATEGY_MIS, SAMPLER_SOBOL, false};
    struct suspicion s = {0};
    trial_counts.made++;
    for (uint32_t round = 0;; round++) {
        if (!usual[round].made)
            usual[round] = measure(&w->scene, &mis, round);
        const struct tally a = usual[round], b = measure(&w->scene, m, round);
        const double error = hypot(a.error, b.error);
        const double size = fmax(fabs(a.mean), fabs(b.mean));
        const bool off = still_off(&s, b.mean - a.mean, error, size, fmin(a.n_eff, b.n_eff));
        if (!s.judged)
            trial_counts.unjudged++;
        if (!off)
            return s.judged ? TRIAL_HOLDS : TRIAL_UNJUDGED;
        snprintf(why, 240, "%s: %.6g +- %.2g, mis %.6g +- %.2g (off by %.3f %%, round %u)", m->name,
                 b.mean, b.error, a.mean, a.error, 100 * (b.mean - a.mean) / size, round);
        if (round + 1 >= rounds)
            return verdict_of(&s, round);
        trial_counts.repeated++;
    }
}

/* Of the naive tracer: where light may leave a body that it has not entered, what there is on its
 * way is told by the rules of medium.h alone. */
static bool claims(const struct method *m, const struct wild *w)
{
    const bool by_chance = m->by == BY_NAIVE || m->strategy == STRATEGY_BSDF;
    if (by_chance && w->traits & WILD_TINY)
        return false;
    if (m->by == BY_NAIVE)
        return w->traits & WILD_PLAIN && !(w->traits & WILD_OPEN && medium_uses(&w->scene));
    return !(m->by == BY_PATHS && w->traits & WILD_SIGNED) && (!m->split || split_can(&w->scene));
}

enum trial_verdict trial_means(const struct wild *w, uint32_t rounds, char why[240])
{
    static const struct method methods[] = {
        {"independent", BY_FILM, STRATEGY_MIS, SAMPLER_INDEPENDENT, false},
        {"stratified", BY_FILM, STRATEGY_MIS, SAMPLER_STRATIFIED, false},
        {"light", BY_FILM, STRATEGY_LIGHT, SAMPLER_SOBOL, false},
        {"bsdf", BY_FILM, STRATEGY_BSDF, SAMPLER_SOBOL, false},
        {"no roulette", BY_PATHS, STRATEGY_MIS, SAMPLER_SOBOL, false},
        {"split lamps", BY_FILM, STRATEGY_MIS, SAMPLER_SOBOL, true},
        {"naive", BY_NAIVE, STRATEGY_MIS, SAMPLER_SOBOL, false},
    };
    struct tally usual[TRIAL_MOST_ROUNDS] = {{0}};
    enum trial_verdict all = TRIAL_UNJUDGED; /* one that is judged is enough to hold */
    for (size_t i = 0; i < countof(methods) && all != TRIAL_FAILS; i++) {
        const struct method *m = &methods[i];
        if (!claims(m, w))
            continue;
        const enum trial_verdict v = agrees(w, m, rounds, usual, why);
        all = v == TRIAL_UNJUDGED ? all : v;
    }
    return all;
}

/* --- furnaces --- */

/* A sky of 1 and nothing else; `fed`: matte surfaces shine as much as they absorb. */
static void make_furnace(struct scene *s, bool fed, struct arena *arena)
{
    static const struct light sky = {.kind = LIGHT_SKY, .sky.radiance = {1, 1, 1, 0}};
    struct shape *shapes = arena_new(arena, struct shape, s->shape_count + 1);
    memcpy(shapes, s->shapes, s->shape_count * sizeof *shapes);
    for (uint32_t i = 0; i < s->shape_count; i++) {
        const struct material *m = &s->materials[shapes[i].material];
        const bool matte = m->kind == MATERIAL_DIFFUSE && m->slot_begin == m->slot_end;
        shapes[i].emission = fed && matte ? 1 - m->diffuse.albedo : rgb_gray(0);
    }
    s->shapes = shapes;
    s->lights = arena_new(arena, struct light, 1);
    s->lights[0] = sky;
    s->light_count = 1;
}

static enum trial_verdict is_cool(const struct wild *w, bool fed, uint32_t rounds, char why[240])
{
    const struct method m = {fed ? "fed" : "bare", BY_FILM,
                             (enum strategy_kind)(fed ? w->seed % 3 : 0), SAMPLER_SOBOL, false};
    struct suspicion s = {0};
    for (uint32_t round = 0;; round++) {
        struct arena arena = {0};
        struct scene scene = w->scene;
        make_furnace(&scene, fed, &arena);
        const struct tally t = measure(&scene, &m, round);
        arena_release(&arena);
        if (!still_off(&s, fmax(0, t.mean - 3), t.error, 3, t.n_eff))
            return s.judged ? TRIAL_HOLDS : TRIAL_UNJUDGED;
        snprintf(why, 240, "%s: %.6f +- %.1e", m.name, t.mean / 3, t.error / 3);
        if (round + 1 >= rounds)
            return verdict_of(&s, round);
    }
}

enum trial_verdict trial_furnace(const struct wild *w, uint32_t rounds, char why[240])
{
    if (w->traits & WILD_OPEN)
        return TRIAL_UNJUDGED;
    const enum trial_verdict bare = is_cool(w, false, rounds, why);
    return bare == TRIAL_FAILS ? bare : is_cool(w, true, rounds, why);
}
