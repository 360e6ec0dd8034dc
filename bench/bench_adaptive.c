/* Less work by sampling where it is needed: adaptive.h against the same number of samples
 * everywhere, at equal error.
 *
 * Each scene is rendered evenly, its true error (against.h) and its work noted after each judged
 * round. An adaptive job takes the same samples, of the blocks that it asks for, and their work: so
 * these are kept and not rendered again. At the true error that its image then has, the even one's
 * work is read off its curve (straight between two rounds in log-log); the ratio of the two is the
 * gain. So it is one error for both, whatever the target was; how far below the target the job
 * ended is shown beside it. Where more samples everywhere do not bring less error, a few bright
 * pixels are all of it and chance decides: such a gain is shown, but not counted. The reference
 * takes other random numbers. All is counted work (film.h), so that the figures do not depend on
 * the machine.
 *
 *     bench_adaptive [--quick] [NAME ...]      --quick: not to the smallest target
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

enum { WIDTH_PX = 320, HEIGHT_PX = 240, MOST_SPP = 2048, MOST_PASSES = 13, TARGETS = 3 };

static const double targets[TARGETS] = {.1, .05, .03};
static const struct tile_rect window = {0, 0, WIDTH_PX, HEIGHT_PX};

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
    double units[MOST_PASSES], error2[MOST_PASSES];
};

/* The samples of passes, block by block: tiles of one block each. */
struct kept {
    struct arena arena;
    struct tile_grid grid;
    uint32_t spp;
    struct film_samples *passes[MOST_PASSES]; /* [pass][block] */
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

/* Evenly, until the error seems to be so much, or as long as it may last. */
static uint32_t spp_for(const struct film *f, uint32_t spp, double error2)
{
    const double e = spp >= 64 ? estimate_error(f) : (double)INFINITY;
    return e * e <= error2 || spp == MOST_SPP ? spp : 0;
}

static void render_reference(const struct stage *stage, double error2, struct film *f)
{
    uint32_t spp = 0;
    for (uint32_t p = 0; spp == 0; p++) {
        const struct tile_pass pass = tile_pass_of(p, MOST_SPP);
        add_pass(stage, f, pass);
        spp = spp_for(f, pass.s_end, error2);
    }
}

static void render_pass(const struct stage *stage, struct kept *k, uint32_t pass, struct film *f)
{
    const uint32_t count = tile_count(&k->grid);
    k->passes[pass] = arena_new(&k->arena, struct film_samples, count);
    for (uint32_t t = 0; t < count; t++) {
        struct film_samples *s = &k->passes[pass][t];
        *s = film_samples_make(tile_rect_of(&k->grid, t), tile_pass_of(pass, MOST_SPP), &k->arena);
        adapt_render(stage, s);
        film_merge(f, s);
    }
}

static void render_evenly(const struct stage *stage, const struct film *reference, double error2,
                          struct kept *k, struct even_curve *c)
{
    const double least = estimate_least(reference);
    struct film f;
    film_init(&f, reference->window);
    for (uint32_t p = 0; k->spp == 0; p++) {
        const uint32_t spp = tile_pass_of(p, MOST_SPP).s_end;
        render_pass(stage, k, p, &f);
        k->spp = spp_for(&f, spp, error2);
        if (!adaptive_judges(spp))
            continue;
        c->units[c->count] = (double)f.work.units;
        c->error2[c->count++] = against_error2(&f, reference, f.window, least);
    }
    film_release(&f);
}

/* A fill, of a tile of one block: what was kept of it. */
static void fill_kept(const void *kept, struct film_samples *s)
{
    const struct kept *k = kept;
    const struct tile_rect r = s->rect;
    const uint32_t block = r.y_begin / BLOCK_PX * k->grid.columns + r.x_begin / BLOCK_PX;
    const struct film_samples *from = &k->passes[tile_pass_count(s->pass.s_end) - 1][block];
    memcpy(s->sums, from->sums, tile_rect_pixels(r) * FILM_CHANNELS * sizeof *s->sums);
    s->blocks[0] = from->blocks[0];
    s->work = from->work;
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

struct tally { /* of gains */
    double logs, least;
    uint32_t count, gained; /* all; those of 1.5 and more */
    uint32_t jobs, held;    /* all; those whose interval holds the true error */
};

static void count_gain(struct tally *t, double gain)
{
    t->logs += log(gain);
    t->least = t->count++ == 0 || gain < t->least ? gain : t->least;
    t->gained += gain >= 1.5;
}

static void say(const struct adapt *a, double target, struct estimate_interval e, double error2,
                double gain)
{
    printf("  %4.1f %%: %5.2f %% seems (%.2f to %.2f), %5.2f %% true, %4u spp at most, %6.1f mean, "
           "%3.0f %% stopped, gain ",
           100 * target, 100 * estimate_error(&a->film), 100 * e.low, 100 * e.high,
           100 * sqrt(error2 > 0 ? error2 : 0), a->spp, adapt_mean_spp(a),
           100 * adaptive_stopped(&a->adaptive, a->spp - 1));
    printf(isnan(gain) ? "unknown\n" : "%.2f\n", gain);
    fflush(stdout);
}

static void count_interval(struct tally *t, struct estimate_interval e, double error2)
{
    t->jobs++;
    t->held += e.low * e.low <= error2 && error2 <= e.high * e.high;
}

static bool is_chance(const struct even_curve *c)
{
    for (uint32_t i = 1; i < c->count; i++)
        if (!(c->error2[i] < c->error2[i - 1]))
            return true;
    return false;
}

/* To targets[0, wanted), each going on from the last, while they are met. */
static void compare(const struct kept *k, const struct even_curve *c, const struct film *reference,
                    uint32_t wanted, struct tally all[TARGETS])
{
    const double least = estimate_least(reference);
    const bool chance = is_chance(c);
    struct adapt a;
    adapt_init(&a, window, BLOCK_PX);
    for (uint32_t i = 0; i < wanted && adapt_run(&a, targets[i], k->spp, fill_kept, k); i++) {
        const double error2 = against_error2(&a.film, reference, window, least);
        const double gain = units_to(c, error2) / (double)a.film.work.units;
        const struct estimate_interval e = estimate_interval(&a.film);
        say(&a, targets[i], e, error2, gain);
        count_interval(&all[i], e, error2);
        if (!isnan(gain) && !chance)
            count_gain(&all[i], gain);
    }
    adapt_release(&a);
}

/* Both films go to a little less than the smallest target: the even one, since an adaptive job ends
 * there, and the reference, since what it has not seen of a lamp's edge is not in its own noise. */
static void run(const char *name, uint32_t wanted, struct tally all[TARGETS])
{
    const double least2 = targets[wanted - 1] * targets[wanted - 1];
    struct scenes s, other;
    if (!make(name, 1, &s) || !make(name, 2, &other)) {
        printf("%s: left out, its files are not here\n", name);
        return;
    }
    struct film reference;
    struct even_curve curve = {0};
    struct kept kept = {.grid = tile_grid_make(window, BLOCK_PX)};
    film_init(&reference, window);
    render_reference(scenes_stage(&other), .5 * least2, &reference);
    render_evenly(scenes_stage(&s), &reference, .6 * least2, &kept, &curve);
    printf("%s (evenly %u spp, %.2f %%)%s\n", name, kept.spp,
           100 * sqrt(curve.error2[curve.count - 1]),
           is_chance(&curve) ? " chance: not counted" : "");
    compare(&kept, &curve, &reference, wanted, all);
    arena_release(&kept.arena);
    film_release(&reference);
    scenes_release(&other);
    scenes_release(&s);
}

static void sum_up(const char *which, const struct tally all[TARGETS])
{
    for (uint32_t i = 0; i < TARGETS; i++)
        if (all[i].count)
            printf("%s, %g %%: %u, of them %u with a gain of 1.5 and more; mean %.2f, least %.2f\n",
                   which, 100 * targets[i], all[i].count, all[i].gained,
                   exp(all[i].logs / all[i].count), all[i].least);
    for (uint32_t i = 0; i < TARGETS; i++)
        if (all[i].jobs)
            printf("%s, %g %%: the interval of %u of %u jobs holds the true error\n", which,
                   100 * targets[i], all[i].held, all[i].jobs);
}

int main(int argc, char **argv)
{
    uint32_t wanted = TARGETS;
    if (argc > 1 && !strcmp(argv[1], "--quick")) {
        wanted--;
        argc--, argv++;
    }
    struct tally m[TARGETS] = {0}, e[TARGETS] = {0};
    for (size_t i = 0; argc == 1 && i < countof(mixed); i++)
        run(mixed[i], wanted, m);
    for (size_t i = 0; argc == 1 && i < countof(even); i++)
        run(even[i], wanted, e);
    for (int i = 1; i < argc; i++)
        run(argv[i], wanted, m);
    sum_up("mixed scenes", m);
    sum_up("even ones", e);
    return 0;
}
