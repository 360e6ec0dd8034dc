/* Less work by sampling where it is needed: adaptive.h against the same number of samples
 * everywhere, at equal error.
 *
 * Each scene is rendered evenly, its true error (against.h) and its work noted after each judged
 * round, and adaptively to two targets. At the true error that the adaptive image then has, the
 * even one's work is read off its curve (straight between two rounds in log-log); the ratio of the
 * two is the gain. Where more samples everywhere do not bring less error, a few bright pixels are
 * all of it and chance decides: such a gain is shown, but not counted. Both take the same random
 * numbers; the reference takes others. All is counted work (film.h), so that the figures do not
 * depend on the machine.
 *
 *     bench_adaptive [--quick] [NAME ...]      --quick: the largest target alone
 *
 * SPDX-License-Identifier: MIT */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "bench/against.h"
#include "bench/corpus.h"
#include "common/estimate.h"
#include "tests/adapt.h"

enum { WIDTH_PX = 320, HEIGHT_PX = 240, MOST_SPP = 2048, MOST_ROUNDS = 16, TARGETS = 2 };

static const double targets[TARGETS] = {.1, .05};

/* Parts of different noise in one image; and scenes that have no such parts, where there is nothing
 * to gain and something to lose. */
static const char *const mixed[] = {"cornell-box",      "glass-and-metal", "many-lights",
                                    "materials",        "soft box",        "sky and sun",
                                    "walls that shine", "lanterns",        "plates",
                                    "wavy ball",        "tubes",           "dark, albedo .1"};
static const char *const even[] = {"room, ceiling", "mirrors", "furnace, dark", "dome",
                                   "floor, tiny lamp"};

/* ---- one scene ---- */

struct even_curve {
    uint32_t count;
    double units[MOST_ROUNDS], error2[MOST_ROUNDS];
};

static bool make(const char *name, uint32_t seed, struct scenes *s)
{
    for (uint32_t i = 0; i < corpus_count(); i++) {
        if (strcmp(corpus_name(i), name) != 0)
            continue;
        if (!corpus_make(i, s))
            return false;
        s->scene.film.width_px = s->scene.film.crop_x_end = WIDTH_PX;
        s->scene.film.height_px = s->scene.film.crop_y_end = HEIGHT_PX;
        s->scene.settings.seed = seed;
        return true;
    }
    return false;
}

static void add_pass(const struct stage *stage, struct film *f, struct tile_pass pass)
{
    struct arena arena = {0};
    struct film_samples s = film_samples_make(f->window, pass, &arena);
    adapt_render(stage, &s);
    film_merge(f, &s);
    arena_release(&arena);
}

/* Evenly, until the error seems to be less than half of the square that counts. */
static uint32_t render_reference(const struct stage *stage, double target, struct film *f)
{
    film_init(f, (struct tile_rect){0, 0, WIDTH_PX, HEIGHT_PX});
    for (uint32_t p = 0; p < tile_pass_count(MOST_SPP); p++) {
        const struct tile_pass pass = tile_pass_of(p, MOST_SPP);
        add_pass(stage, f, pass);
        const double e = pass.s_end >= 64 ? estimate_error(f) : (double)INFINITY;
        if (e * e < .5 * target * target)
            return pass.s_end;
    }
    return MOST_SPP;
}

static void render_evenly(const struct stage *stage, uint32_t spp, const struct film *reference,
                          struct even_curve *c)
{
    const double least = estimate_least(reference);
    struct film f;
    *c = (struct even_curve){0};
    film_init(&f, reference->window);
    for (uint32_t p = 0; p < tile_pass_count(spp); p++) {
        const struct tile_pass pass = tile_pass_of(p, spp);
        add_pass(stage, &f, pass);
        if (!adaptive_judges(pass.s_end))
            continue;
        c->units[c->count] = (double)f.work.units;
        c->error2[c->count++] = against_error2(&f, reference, f.window, least);
    }
    film_release(&f);
}

/* NAN: not between two of its points. */
static double units_to(const struct even_curve *c, double error2)
{
    for (uint32_t i = 1; i < c->count; i++)
        if (c->error2[i] <= error2 && error2 <= c->error2[i - 1]) {
            const double part =
                log(c->error2[i - 1] / error2) / log(c->error2[i - 1] / c->error2[i]);
            return c->units[i - 1] * pow(c->units[i] / c->units[i - 1], part);
        }
    return (double)NAN;
}

struct tally {
    double logs, least;     /* of gains */
    uint32_t count, gained; /* all; those of 1.5 and more */
};

static void say(const struct adapt *a, double target, bool met, const struct even_curve *c,
                const struct film *reference, struct tally *t)
{
    const double error2 =
        against_error2(&a->film, reference, a->film.window, estimate_least(reference));
    const double gain = units_to(c, error2) / (double)a->film.work.units;
    printf("  %4.1f %%: %5.2f %% true, %4u spp at most, %6.1f mean, %3.0f %% stopped, energy %+.2f "
           "%%, gain ",
           100 * target, 100 * sqrt(error2 > 0 ? error2 : 0), a->spp, adapt_mean_spp(a),
           100 * adaptive_stopped(&a->adaptive, a->spp - 1),
           100 * against_energy(&a->film, reference));
    printf(isnan(gain) ? "unknown%s\n" : "%s%.2f\n", met ? "" : "(not met) ", gain);
    fflush(stdout);
    if (isnan(gain))
        return;
    t->logs += log(gain);
    t->least = t->count++ == 0 || gain < t->least ? gain : t->least;
}

static bool is_chance(const struct even_curve *c)
{
    for (uint32_t i = 1; i < c->count; i++)
        if (!(c->error2[i] < c->error2[i - 1]))
            return true;
    return false;
}

static void run(const char *name, uint32_t wanted, struct tally *all)
{
    struct scenes s, other;
    if (!make(name, 1, &s) || !make(name, 2, &other)) {
        printf("%s: left out, its files are not here\n", name);
        return;
    }
    struct film reference;
    struct even_curve curve;
    struct tally t = {0};
    struct adapt a;
    const uint32_t spp = render_reference(scenes_stage(&other), targets[wanted - 1], &reference);
    const struct stage *stage = scenes_stage(&s);
    render_evenly(stage, spp, &reference, &curve);
    const bool chance = is_chance(&curve);
    printf("%s (evenly %u spp, %.2f %%)%s\n", name, spp, 100 * sqrt(curve.error2[curve.count - 1]),
           chance ? " chance: not counted" : "");
    adapt_init(&a, reference.window, 64);
    bool met = true;
    for (uint32_t i = 0; met && i < wanted; i++) { /* each goes on from the last */
        met = adapt_run(&a, targets[i], spp, adapt_render, stage);
        say(&a, targets[i], met, &curve, &reference, &t);
    }
    adapt_release(&a);
    film_release(&reference);
    scenes_release(&other);
    scenes_release(&s);
    if (t.count == 0 || chance)
        return;
    all->logs += t.logs / t.count;
    all->least = all->count++ == 0 || t.least < all->least ? t.least : all->least;
    all->gained += exp(t.logs / t.count) >= 1.5;
}

int main(int argc, char **argv)
{
    uint32_t wanted = TARGETS;
    if (argc > 1 && !strcmp(argv[1], "--quick")) {
        wanted = 1;
        argc--, argv++;
    }
    struct tally m = {0}, e = {0};
    for (size_t i = 0; argc == 1 && i < countof(mixed); i++)
        run(mixed[i], wanted, &m);
    for (size_t i = 0; argc == 1 && i < countof(even); i++)
        run(even[i], wanted, &e);
    for (int i = 1; i < argc; i++)
        run(argv[i], wanted, &m);
    printf("%u scenes: %u with a gain of 1.5, mean %.2f, least %.2f\n", m.count, m.gained,
           exp(m.logs / m.count), m.least);
    if (e.count)
        printf("%u even ones: mean %.2f, least %.2f (1 / 1.05 = .95)\n", e.count,
               exp(e.logs / e.count), e.least);
    return 0;
}
