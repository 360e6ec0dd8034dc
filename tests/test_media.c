/* medium.h, and path.c where there are media: absorption and bodies within bodies against closed
 * forms (ACCURACY rows, F-21).
 * SPDX-License-Identifier: MIT */
#include "common/trace/medium.h"

#include <math.h>
#include <stdio.h>

#include "tests/scenes.h"
#include "tests/stat/stat.h"
#include "tests/tap.h"

static const double pi = 3.14159265358979323846;

static uint32_t body(struct scenes *s, float ior, uint32_t priority, float absorption)
{
    const uint32_t m = scenes_glass(s, ior);
    s->scene.materials[m].inside.priority = priority;
    s->scene.materials[m].inside.absorption = rgb_gray(absorption);
    return m;
}

static struct scenes begin(vec3 from, vec3 at, double fov)
{
    struct scenes s;
    scenes_init(&s, 8, 8);
    scenes_look(&s, from, at, fov);
    s.scene.settings.max_bounces = 1000;
    return s;
}

static struct scenes_mean render(struct scenes *s, uint32_t spp)
{
    struct film film;
    scenes_render(scenes_stage(s), spp / STAT_SLOW < 8 ? 8 : spp / STAT_SLOW, &film);
    const struct scenes_mean m = scenes_mean(&film, 1);
    if (film.invalid_count)
        ok(false, "%lu invalid samples", (unsigned long)film.invalid_count);
    film_release(&film);
    scenes_release(s);
    return m;
}

/* Within 3.9 standard errors, which detect `gate` of the truth. */
static void is_true(struct scenes *s, uint32_t spp, double truth, double gate, const char *name)
{
    const struct scenes_mean m = render(s, spp);
    const double detects = (3.9 + 2.33) * m.error / truth;
    ok(fabs(m.mean - truth) <= 3.9 * m.error + 1e-5 * truth && (STAT_SLOW > 1 || detects <= gate),
       "%s: %.6f is %.6f (detects %.2f %%)", name, truth, m.mean, 100 * detects);
}

/* --- an absorbing slab in front of a wall of light, and beside it, in a mirror image --- */

static void slab(float depth, bool reflected, double truth)
{
    const vec3 from = vec3_make(0, 1, 1), at = vec3_make(0, 1, 0);
    struct scenes s = begin(from, at, 1e-3);
    scenes_box(&s, body(&s, 1.5f, 0, depth / .01f), vec3_make(-50, -50, -.01f),
               vec3_make(50, 50, 0), false);
    const vec3 corner = vec3_make(-90, -90, reflected ? 2 : -1);
    const vec3 x = vec3_make(180, 0, 0), y = vec3_make(0, 180, 0);
    const uint32_t black = scenes_diffuse(&s, rgb_gray(0));
    scenes_quad(&s, black, corner, reflected ? y : x, reflected ? x : y)->emission = rgb_gray(1);
    char name[64];
    snprintf(name, sizeof name, "A-12 slab of optical depth %g, %s", (double)depth,
             reflected ? "reflected" : "passed");
    is_true(&s, reflected ? 16384 : 4096, truth, reflected ? .03 : .01, name);
}

static void slabs(void)
{
    const double f = .04;
    for (int i = 0; i < 2; i++) {
        const double a = i ? 1 : .1, q = 1 - f * f * exp(-2 * a);
        slab((float)a, false, (1 - f) * (1 - f) * exp(-a) / q);
        slab((float)a, true, f + f * (1 - f) * (1 - f) * exp(-2 * a) / q);
    }
}

/* --- light and camera inside what absorbs --- */

enum lamp { LAMP_SKY, LAMP_POINT, LAMP_DISC };

/* A white disc in the middle of a ball of index 1, so that nothing is reflected: L falls by
 * exp(-a x), a = .5. The lamp is 3 m away, the camera a tenth, the sky outside of the ball. */
static void lit_in_ball(enum lamp lamp, double path_length, const char *name)
{
    const vec3 origin = vec3_make(0, 0, 0), up = vec3_make(0, 1, 0);
    struct scenes s = begin(vec3_make(.06f, .08f, 0), origin, 1e-3);
    s.scene.settings.max_bounces = lamp == LAMP_SKY ? 2 : 1;
    scenes_sphere(&s, body(&s, 1, 0, .5f), origin, 4);
    scenes_disc(&s, scenes_diffuse(&s, rgb_gray(1)), origin, up, .01f);
    const float h = 3, r = .01f;
    switch (lamp) {
    case LAMP_SKY:
        scenes_sky(&s, rgb_gray(1));
        break;
    case LAMP_POINT: {
        struct light *l = scenes_light(&s, LIGHT_POINT);
        vec3_store(l->point.position, h * up);
        l->point.intensity = rgb_gray((float)pi * h * h);
        break;
    }
    case LAMP_DISC:
        scenes_disc(&s, scenes_diffuse(&s, rgb_gray(0)), h * up, -up, r)->emission =
            rgb_gray((r * r + h * h) / (r * r));
        break;
    }
    is_true(&s, lamp == LAMP_SKY ? 2048 : 64, exp(-.5 * path_length), .01, name);
}

static void balls(void)
{
    const vec3 origin = vec3_make(0, 0, 0);
    struct scenes s = begin(origin, vec3_make(1, 0, 0), .1);
    scenes_sphere(&s, body(&s, 1, 0, .7f), origin, 2);
    scenes_sky(&s, rgb_gray(1));
    is_true(&s, 16, exp(-1.4), 1e-4, "the sky from the middle of a ball that absorbs");
    s = begin(vec3_make(-5, 0, 0), origin, 1e-3);
    scenes_sphere(&s, body(&s, 1, 0, .7f), origin, 2);
    scenes_sphere(&s, body(&s, 1, 0, .1f), origin, .5f);
    scenes_sky(&s, rgb_gray(1));
    is_true(&s, 16384, exp(-.7 * 3 - .1), .01, "through a ball within a ball: the inner one counts");
    lit_in_ball(LAMP_SKY, 4.1, "a disc in it under the sky");
    lit_in_ball(LAMP_POINT, 3.1, "under a point light");
    lit_in_ball(LAMP_DISC, 3.1, "under a small lamp");
}

/* --- clear bodies in one another, in a uniform sky of 1 --- */

static void unseen(struct scenes *s, const char *name)
{
    struct film film;
    scenes_sky(s, rgb_gray(1));
    scenes_render(scenes_stage(s), 64 / STAT_SLOW < 8 ? 8 : 64 / STAT_SLOW, &film);
    double worst = 0;
    for (size_t i = 0; i < tile_rect_pixels(film.window); i++) {
        double mean[3];
        film_mean(&film, i, mean);
        worst = fmax(worst, fabs(mean[0] - 1));
    }
    ok(worst < 1e-4 && !film.invalid_count, "A-13 %s: every pixel is 1 (%.1e)", name, worst);
    film_release(&film);
    scenes_release(s);
}

/* Closed, along y. */
static void can(struct scenes *s, uint32_t material, float radius, float low, float high)
{
    const vec3 from = vec3_make(0, low, 0), to = vec3_make(0, high, 0);
    scenes_cylinder(s, material, from, to, radius);
    scenes_disc(s, material, to, to - from, radius);
    scenes_disc(s, material, from, from - to, radius);
}

static void nested(void)
{
    const vec3 from = vec3_make(1, 2, 3), origin = vec3_make(0, 0, 0);
    struct scenes s = begin(from, origin, .7);
    /* A can of glass, hollow by a can of air; water that reaches into the glass; ice, half out. */
    const uint32_t glass = body(&s, 1.5f, 20, 0), air = body(&s, 1, 30, 0);
    const uint32_t water = body(&s, 1.33f, 40, 0), ice = body(&s, 1.31f, 50, 0);
    can(&s, glass, .8f, -.9f, .9f);
    can(&s, air, .7f, -.8f, 1);
    can(&s, water, .72f, -.82f, .3f);
    scenes_sphere(&s, ice, vec3_make(.1f, .3f, 0), .25f);
    unseen(&s, "a glass of water with ice, hollow by air");
    s = begin(from, origin, .7);
    can(&s, body(&s, 1.5f, 2, 0), .8f, -.9f, -.2f);
    can(&s, body(&s, 1.33f, 1, 0), .75f, -.4f, .3f);
    unseen(&s, "water that overlaps glass");
    s = begin(from, origin, .7);
    const uint32_t frosted = body(&s, 1.33f, 0, 0);
    scenes_sphere(&s, body(&s, 1.8f, 1, 0), vec3_make(.2f, 0, 0), .6f);
    scenes_sphere(&s, frosted, vec3_make(-.2f, 0, 0), .6f);
    unseen(&s, "two balls that cut each other, one without a priority");
    s = begin(from, origin, .7);
    for (int i = 0; i < 12; i++)
        scenes_sphere(&s, body(&s, 1.1f + .05f * (float)i, 1 + (uint32_t)i, 0), origin,
                      1 - .05f * (float)i);
    unseen(&s, "twelve balls, more than are kept");
    s = begin(from, origin, .7);
    for (int i = 0; i < 50; i++)
        scenes_sphere(&s, i ? 0 : body(&s, 1.5f, 1, 0), origin, 1);
    unseen(&s, "fifty balls in one place");
}

/* Radiance in a body is n^2 times that outside. */
static void camera_inside(void)
{
    const vec3 origin = vec3_make(0, 0, 0);
    struct scenes s = begin(origin, vec3_make(1, 0, 0), 1);
    scenes_sphere(&s, body(&s, 1.33f, 1, 0), origin, 2);
    scenes_sphere(&s, body(&s, 1.5f, 2, 0), origin, 1);
    scenes_sky(&s, rgb_gray(1));
    const struct stage *stage = scenes_stage(&s);
    ok(stage->around.count == 2 && stage->around.material[0] == 0 && stage->around.material[1] == 1,
       "the camera is in two bodies, in order");
    is_true(&s, 16, 2.25, 1e-4, "A-13 from glass in water: n^2");
    s = begin(vec3_make(1.5f, 0, 0), vec3_make(1.5f, 1, 0), 1e-2);
    scenes_sphere(&s, body(&s, 1.33f, 2, .3f), origin, 2);
    scenes_sphere(&s, body(&s, 1.5f, 1, 5), vec3_make(1.5f, 0, 0), .3f);
    scenes_sky(&s, rgb_gray(1));
    const double way = sqrt(4 - 2.25);
    const struct scenes_mean m = render(&s, 64);
    ok(m.mean < 1.33 * 1.33 * exp(-.3 * way) * 1.0001 && m.mean > .8 * exp(-.3 * way),
       "a body of lower priority around the camera neither reflects nor absorbs (%.4f)", m.mean);
}

/* --- index 1: not there, and yet no shadow ray passes --- */

static void index_one(void)
{
    double mean[3];
    for (int i = 0; i < 3; i++) { /* nothing; index 1 as written; index 1 by priority */
        struct scenes s = begin(vec3_make(0, 1, 3), vec3_make(0, .5f, 0), .5);
        scenes_quad(&s, scenes_diffuse(&s, rgb_gray(.7f)), vec3_make(-3, 0, -3), vec3_make(0, 0, 6),
                    vec3_make(6, 0, 0));
        scenes_disc(&s, scenes_diffuse(&s, rgb_gray(0)), vec3_make(0, 2, 0), vec3_make(0, -1, 0),
                    .5f)
            ->emission = rgb_gray(3);
        if (i)
            scenes_sphere(&s, body(&s, 1, i == 2, 0), vec3_make(0, .5f, 0), .5f);
        if (i == 2) /* hidden in it */
            scenes_sphere(&s, body(&s, 1, 0, 0), vec3_make(0, .5f, 0), .3f);
        mean[i] = render(&s, 4096).mean;
    }
    ok(fabs(mean[1] / mean[0] - 1) < .01 * STAT_SLOW &&
           fabs(mean[2] / mean[0] - 1) < .01 * STAT_SLOW,
       "a body of index 1 is not there (%.4f, %.4f, %.4f)", mean[0], mean[1], mean[2]);
}

/* The sky through a veil in two balls of index 1, the inner one hidden by the outer one: masks are
 * looked through behind a surface that is not there, too, one after the other. */
static void veils_in_bodies(void)
{
    const vec3 origin = vec3_make(0, 0, 0), z = vec3_make(0, 0, 1);
    for (int veils = 1; veils <= 2; veils++) {
        struct scenes s = begin(vec3_make(0, 0, 4), origin, 1e-3);
        const struct material veil = {.kind = MATERIAL_MASK,
                                      .mask = {scenes_diffuse(&s, rgb_gray(0)), .25f}};
        const uint32_t m = scenes_material(&s, veil);
        scenes_sphere(&s, body(&s, 1, 2, 0), origin, 1);
        scenes_sphere(&s, body(&s, 1, 1, 0), origin, .5f);
        for (int i = 0; i < veils; i++)
            scenes_disc(&s, m, .1f * (float)i * z, z, .3f);
        scenes_sky(&s, rgb_gray(1));
        is_true(&s, 16384, pow(.75, veils), .01, "the sky through veils in a body in a body");
    }
}

int main(void)
{
    slabs();
    balls();
    nested();
    camera_inside();
    index_one();
    veils_in_bodies();
    return tap_done();
}
