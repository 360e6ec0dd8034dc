/* Integrators, strategies and samplers: all that claim a case give its truth, and each other's
 * image; direct is path cut at one scattering; whitted is what a naive tracer makes of the same
 * words. SPDX-License-Identifier: MIT */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "tests/naive_path.h"
#include "tests/scenes.h"
#include "tests/stat/means.h"
#include "tests/tap.h"

static const double pi = 3.14159265358979323846;

static const char *const strategy_names[] = {
    [STRATEGY_MIS] = "mis", [STRATEGY_LIGHT] = "light", [STRATEGY_BSDF] = "bsdf"};
static const char *const sampler_names[] = {[SAMPLER_SOBOL] = "sobol",
                                            [SAMPLER_INDEPENDENT] = "independent",
                                            [SAMPLER_STRATIFIED] = "stratified"};
static const char *const integrator_names[] = {
    [INTEGRATOR_PATH] = "path", [INTEGRATOR_DIRECT] = "direct", [INTEGRATOR_WHITTED] = "whitted"};

struct method {
    enum integrator_kind integrator;
    enum strategy_kind strategy;
    enum sampler_kind sampler;
};

/* Of each channel. */
static void means_of(struct scenes *s, struct method m, uint32_t spp, struct scenes_mean mean[3])
{
    struct film film;
    struct scene_settings *to = &s->scene.settings;
    to->integrator = m.integrator;
    to->strategy = m.strategy;
    to->sampler = m.sampler;
    to->target.spp = spp;
    scenes_render(scenes_stage(s), spp, &film);
    for (int c = 0; c < 3; c++)
        mean[c] = scenes_mean(&film, c);
    if (film.invalid_count)
        ok(false, "%lu invalid samples", (unsigned long)film.invalid_count);
    film_release(&film);
}

static struct scenes_mean mean_of(struct scenes *s, struct method m, uint32_t spp)
{
    struct scenes_mean mean[3];
    means_of(s, m, spp, mean);
    return mean[1];
}

/* --- truths (docs/accuracy.md) --- */

enum { MIS = 1 << STRATEGY_MIS, LIGHT = 1 << STRATEGY_LIGHT, BSDF = 1 << STRATEGY_BSDF };

/* A white receiver at the origin that faces y, one scattering. */
static void receiver(struct scenes *s)
{
    scenes_look(s, vec3_make(0, .01f, 0), vec3_make(0, 0, 0), 1e-3);
    s->scene.settings.max_bounces = 1;
    scenes_disc(s, scenes_diffuse(s, rgb_gray(1)), vec3_make(0, 0, 0), vec3_make(0, 1, 0), 1e-3f);
}

static void shining_cube(struct scenes *s, uint32_t wall)
{
    scenes_look(s, vec3_make(.2f, -.1f, .3f), vec3_make(.5f, .3f, -1), pi / 2);
    s->scene.settings.max_bounces = 1000;
    scenes_box(s, wall, vec3_make(-1, -1, -1), vec3_make(1, 1, 1), true);
    for (uint32_t i = 0; i < s->scene.shape_count; i++)
        s->scene.shapes[i].emission = rgb_gray(1);
}

static void furnace(struct scenes *s)
{
    shining_cube(s, scenes_diffuse(s, rgb_gray(.5f)));
}

static void mirrors(struct scenes *s)
{
    shining_cube(s, scenes_mirror(s, rgb_gray(.5f)));
}

static void rectangle(struct scenes *s)
{
    receiver(s);
    scenes_quad(s, scenes_diffuse(s, rgb_gray(0)), vec3_make(0, .5f, 0), vec3_make(1, 0, 0),
                vec3_make(0, 0, 2))
        ->emission = rgb_gray(1);
}

static void ball(struct scenes *s)
{
    receiver(s);
    scenes_sphere(s, scenes_diffuse(s, rgb_gray(0)), vec3_make((float)sqrt(.91), .3f, 0), .5f)
        ->emission = rgb_gray(1);
}

static void sky(struct scenes *s)
{
    receiver(s);
    scenes_sky(s, rgb_gray(1));
}

static void distant(struct scenes *s)
{
    receiver(s);
    struct light *sun = scenes_light(s, LIGHT_DISTANT);
    vec3_store(sun->distant.direction, vec3_make(.6f, -.8f, 0));
    sun->distant.irradiance = rgb_gray((float)pi);
}

static void bulb(struct scenes *s)
{
    scenes_look(s, vec3_make(.2f, .4f, .1f), vec3_make(.3f, -.5f, -1), pi / 3);
    s->scene.settings.max_bounces = 1000;
    scenes_sphere(s, scenes_diffuse(s, rgb_gray(.5f)), vec3_make(0, 0, 0), 1);
    scenes_light(s, LIGHT_POINT)->point.intensity = rgb_gray((float)pi);
}

static void glass(struct scenes *s)
{
    scenes_look(s, vec3_make(1, 2, 3), vec3_make(0, 0, 0), .5);
    s->scene.settings.max_bounces = 1000;
    scenes_sky(s, rgb_gray(1));
    scenes_sphere(s, scenes_glass(s, 1.5f), vec3_make(0, 0, 0), .7f);
}

/* A floor in a point light, seen in a mirror straight above it. */
static void floor_in_mirror(struct scenes *s)
{
    scenes_look(s, vec3_make(0, 1, 0), vec3_make(0, 2, 0), 1e-3);
    s->scene.settings.max_bounces = 1000;
    scenes_disc(s, scenes_mirror(s, rgb_gray(.5f)), vec3_make(0, 2, 0), vec3_make(0, -1, 0), .01f);
    scenes_disc(s, scenes_diffuse(s, rgb_gray(.5f)), vec3_make(0, 0, 0), vec3_make(0, 1, 0), 1);
    struct light *l = scenes_light(s, LIGHT_POINT);
    vec3_store(l->point.position, vec3_make(3, 4, 0));
    l->point.intensity = rgb_gray((float)pi * 25);
}

static const struct {
    const char *name;
    void (*build)(struct scenes *);
    double truth[3];     /* by integrator; NAN: another has this case */
    uint32_t strategies; /* that have a finite variance */
} cases[] = {
    /* In a corner light sampling has one because walls that are near are sampled by solid angle. */
    {"A-01 furnace, albedo .5", furnace, {2, 1.5, (double)NAN}, MIS | LIGHT | BSDF},
    {"A-17 mirror box, .5", mirrors, {2, 1.5, 2}, MIS | LIGHT | BSDF},
    {"A-03 rectangle", rectangle, {.220777622, .220777622, .220777622}, MIS | LIGHT | BSDF},
    {"A-05 sphere", ball, {.0787155, .0787155, .0787155}, MIS | LIGHT | BSDF},
    {"A-06 sky", sky, {1, 1, 0}, MIS | LIGHT | BSDF},
    {"A-06 distant light", distant, {.8, .8, .8}, MIS | LIGHT | BSDF},
    {"A-09 point light in a sphere", bulb, {1, .5, .5}, MIS | LIGHT | BSDF},
    {"A-13 glass in a sky", glass, {1, (double)NAN, 1}, MIS | LIGHT | BSDF},
    /* .5 .5 (1 / pi) (25 pi / 25) .8; the mirror itself is too small to light the floor. */
    {"floor in a mirror", floor_in_mirror, {.2, (double)NAN, .2}, MIS | LIGHT | BSDF},
};

/* As many samples as detect a bias of `gate`, found by tries; the error of spread points falls
 * faster than that of independent ones. */
static void is_true(size_t c, struct method m, double gate)
{
    const double z_accept = 4.2, z_detect = z_accept + 2.33; /* 150 tests share 0.4 % */
    const double truth = cases[c].truth[m.integrator];
    const double want = fmax(gate * truth, 1e-6) / z_detect, most = 1 << 21;
    const double power = m.sampler == SAMPLER_INDEPENDENT ? 2 : 1.3;
    struct scenes s;
    scenes_init(&s, 8, 8);
    cases[c].build(&s);
    double spp = 64;
    struct scenes_mean got;
    for (;;) {
        got = mean_of(&s, m, (uint32_t)spp);
        if (got.error <= want || spp == most)
            break;
        spp = fmin(fmax(1.5 * spp, 1.1 * spp * pow(got.error / want, power)), most);
    }
    const double off = fabs(got.mean - truth);
    ok(off <= z_accept * got.error + 2e-5 * truth && got.error <= want,
       "%s, %s, %s, %s: %.6f is %.6f (detects %.2f %%)", cases[c].name,
       integrator_names[m.integrator], strategy_names[m.strategy], sampler_names[m.sampler], truth,
       got.mean, truth > 0 ? 100 * z_detect * got.error / truth : 0);
    scenes_release(&s);
}

static void truths(void)
{
    const double gate = STAT_SLOW > 1 ? .2 : stat_is_long() ? .002 : .05;
    for (size_t c = 0; c < countof(cases); c++)
        for (int i = 0; i < 27; i++) {
            const struct method m = {(enum integrator_kind)(i / 9), (enum strategy_kind)(i / 3 % 3),
                                     (enum sampler_kind)(i % 3)};
            if (isnan(cases[c].truth[m.integrator]) || !(cases[c].strategies >> m.strategy & 1))
                continue;
            if (m.integrator == INTEGRATOR_WHITTED && m.strategy != STRATEGY_LIGHT)
                continue; /* prep says light */
            is_true(c, m, gate);
        }
}

/* --- a whole room --- */

static void room(struct scenes *s, bool point_light)
{
    scenes_init(s, 12, 12);
    scenes_look(s, vec3_make(0, 1, 3.4f), vec3_make(0, .8f, 0), .8);
    const uint32_t white = scenes_diffuse(s, rgb_gray(.6f));
    scenes_box(s, white, vec3_make(-1.5f, 0, -1.5f), vec3_make(1.5f, 2, 4), true);
    s->scene.shapes[0].material = scenes_diffuse(s, vec3_make(.6f, .1f, .1f));
    s->scene.shapes[4].material = scenes_mirror(s, vec3_make(.5f, .8f, .6f));
    scenes_sphere(s, scenes_glass(s, 1.5f), vec3_make(.6f, .45f, .3f), .45f);
    scenes_quad(s, scenes_diffuse(s, rgb_gray(.1f)), vec3_make(-1.2f, 1.7f, -1.2f),
                vec3_make(2.4f, 0, 0), vec3_make(0, 0, 2.4f))
        ->emission = vec3_make(2, 2, 1.5f);
    scenes_sphere(s, white, vec3_make(-.5f, .6f, -.6f), .35f)->emission = vec3_make(.2f, .5f, 1);
    if (point_light) {
        struct light *l = scenes_light(s, LIGHT_POINT);
        vec3_store(l->point.position, vec3_make(.3f, 1.1f, 1.5f));
        l->point.intensity = vec3_make(.2f, .1f, .1f);
    }
}

static bool same_image(const struct film *a, const struct film *b)
{
    return !memcmp(a->replicate, b->replicate,
                   tile_rect_pixels(a->window) * FILM_CHANNELS * sizeof *a->replicate);
}

static void direct_is_cut(void)
{
    struct scenes s;
    struct film direct, cut, dark, none;
    room(&s, true);
    s.scene.settings.integrator = INTEGRATOR_DIRECT;
    scenes_render(scenes_stage(&s), 32, &direct);
    s.scene.settings.max_bounces = 0;
    scenes_render(scenes_stage(&s), 32, &dark);
    s.scene.settings.integrator = INTEGRATOR_PATH;
    scenes_render(scenes_stage(&s), 32, &none);
    s.scene.settings.max_bounces = 1;
    scenes_render(scenes_stage(&s), 32, &cut);
    ok(same_image(&direct, &cut), "direct is path with max_bounces 1, bit by bit");
    ok(same_image(&dark, &none) && !same_image(&dark, &cut), "and with 0, if that is asked for");
    film_release(&direct);
    film_release(&cut);
    film_release(&dark);
    film_release(&none);
    scenes_release(&s);
}

static void all_agree(void)
{
    const uint32_t spp = max_u32(stat_tries(128, 8192), 2 * FILM_REPLICATES);
    const double margin = STAT_SLOW > 1 ? .2 : stat_is_long() ? .004 : .05;
    struct scenes_mean usual[3], got[3];
    for (int i = 0; i < 9; i++) {
        const struct method m = {INTEGRATOR_PATH, (enum strategy_kind)(i / 3),
                                 (enum sampler_kind)(i % 3)};
        double worst = 0, off = 0, error = 0;
        struct scenes s;
        room(&s, true);
        s.scene.settings.seed = (uint64_t)(i + 1); /* the same numbers would prove nothing */
        /* Half of the bound is left when both are off by their errors: directions alone take more.
         */
        const uint32_t more = stat_is_long() && m.strategy == STRATEGY_BSDF ? 2 : 1;
        means_of(&s, m, more * spp, i == 0 ? usual : got);
        for (int c = 0; i > 0 && c < 3; c++) {
            const double level = margin * usual[c].mean;
            const struct means t = {got[c].mean - usual[c].mean,
                                    hypot(got[c].error, usual[c].error), (double)INFINITY};
            worst = fmax(worst, means_unequal_p(&t, level));
            off = fmax(off, fabs(t.off) / usual[c].mean);
            error = fmax(error, t.error / usual[c].mean);
        }
        scenes_release(&s);
        if (i > 0)
            ok(worst < .01 / 24, "%s, %s: mis with sobol within %.1f %% (%.2f %% +- %.2f %%)",
               strategy_names[m.strategy], sampler_names[m.sampler], 100 * margin, 100 * off,
               100 * error);
    }
}

static void oracle(const char *name, struct method m, const double margin)
{
    struct scenes s;
    room(&s, false);
    const struct scenes_mean got = mean_of(&s, m, stat_tries(256, 8192));
    const struct stage *stage = scenes_stage(&s);
    struct dice dice = dice_make(11);
    struct stat_mean naive = {0};
    const uint32_t n = stat_tries(800, 100000);
    for (uint32_t i = 0; i < n; i++) {
        double sum[3] = {0, 0, 0};
        for (uint32_t p = 0; p < 144; p++)
            naive_path_sample(stage, p % 12, p / 12, &dice, sum);
        stat_add(&naive, sum[1] / 144);
    }
    const struct means t = {got.mean - naive.mean, hypot(got.error, stat_error(&naive)),
                            (double)INFINITY};
    ok(means_unequal_p(&t, margin * naive.mean) < .005,
       "%s: the naive tracer's image within %.1f %% (%.5f, %.5f +- %.5f)", name, 100 * margin,
       got.mean, naive.mean, t.error);
    scenes_release(&s);
}

/* --- what a strategy is for --- */

/* relMSE is not asked for, only which is better: a large light nearly touching the floor is found
 * by directions, a small one by aiming, and mis is near the better one. */
static void strategies_differ(void)
{
    double error[2][3];
    for (int i = 0; i < 6; i++) {
        struct scenes s;
        scenes_init(&s, 8, 8);
        scenes_look(&s, vec3_make(0, .01f, 0), vec3_make(0, 0, 0), 1e-3);
        s.scene.settings.max_bounces = 1;
        scenes_disc(&s, scenes_diffuse(&s, rgb_gray(1)), vec3_make(0, 0, 0), vec3_make(0, 1, 0),
                    1e-3f);
        const float r = i < 3 ? 20 : .05f, h = i < 3 ? .05f : 1;
        scenes_disc(&s, scenes_diffuse(&s, rgb_gray(0)), vec3_make(.01f, h, 0), vec3_make(0, -1, 0),
                    r)
            ->emission = rgb_gray(1);
        const struct method m = {INTEGRATOR_DIRECT, (enum strategy_kind)(i % 3),
                                 SAMPLER_INDEPENDENT};
        const struct scenes_mean got = mean_of(&s, m, 2048 / STAT_SLOW);
        error[i / 3][i % 3] = got.error;
        scenes_release(&s);
    }
    const double *near_by = error[0], *small = error[1];
    ok(near_by[STRATEGY_BSDF] < .2 * near_by[STRATEGY_LIGHT] &&
           near_by[STRATEGY_MIS] < .4 * near_by[STRATEGY_LIGHT],
       "a wide light near by: bsdf %.1e, light %.1e, mis %.1e", near_by[STRATEGY_BSDF],
       near_by[STRATEGY_LIGHT], near_by[STRATEGY_MIS]);
    ok(small[STRATEGY_LIGHT] < .2 * small[STRATEGY_BSDF] &&
           small[STRATEGY_MIS] < .4 * small[STRATEGY_BSDF],
       "a small light: bsdf %.1e, light %.1e, mis %.1e", small[STRATEGY_BSDF],
       small[STRATEGY_LIGHT], small[STRATEGY_MIS]);
}

int main(void)
{
    truths();
    direct_is_cut();
    all_agree();
    const double margin = STAT_SLOW > 1 ? .2 : stat_is_long() ? .005 : .06;
    for (int i = 0; i < 3; i++)
        oracle(integrator_names[i], (struct method){(enum integrator_kind)i, 0, 0}, margin);
    strategies_differ();
    return tap_done();
}
