/* material.h, path_mask.h: materials made of others are what they say, one vertex at a time and in
 * images whose answer is known.
 * SPDX-License-Identifier: MIT */
#include "common/trace/material.h"

#include <math.h>
#include <string.h>

#include "tests/scenes.h"
#include "tests/stat/means.h"
#include "tests/stat/stat.h"
#include "tests/tap.h"

static const double pi = 3.14159265358979323846;

static uint32_t mix(struct scenes *s, uint32_t first, uint32_t second, float amount)
{
    return scenes_material(s,
                           (struct material){.kind = MATERIAL_MIX, .mix = {first, second, amount}});
}

static uint32_t mask(struct scenes *s, uint32_t of, float opacity)
{
    return scenes_material(s, (struct material){.kind = MATERIAL_MASK, .mask = {of, opacity}});
}

static uint32_t two_sided(struct scenes *s, uint32_t front, uint32_t back)
{
    return scenes_material(
        s, (struct material){.kind = MATERIAL_TWO_SIDED, .two_sided = {front, back}});
}

/* --- one vertex at a time --- */

/* The share of numbers in [0, 1) for which `material` becomes `other`. */
static double share(const struct stage *s, uint32_t material, bool back, uint32_t other)
{
    const struct material *materials = stage_at(s, s->materials);
    enum { STEPS = 4096 };
    const struct material_side side = {material, back, NULL};
    uint32_t count = 0;
    for (int i = 0; i < STEPS; i++)
        count += material_at(s, &side, (float)i / STEPS) == &materials[other];
    return (double)count / STEPS;
}

static double opacity(const struct stage *s, uint32_t material, bool back)
{
    return (double)material_opacity(s, &(struct material_side){material, back, NULL});
}

static void choices(void)
{
    struct scenes s;
    scenes_init(&s, 8, 8);
    const uint32_t a = scenes_diffuse(&s, rgb_gray(.2f)), b = scenes_diffuse(&s, rgb_gray(.4f));
    const uint32_t c = scenes_mirror(&s, rgb_gray(1));
    const uint32_t quarter = mix(&s, a, b, .25f), deep = mix(&s, quarter, c, .5f);
    const uint32_t thin = mask(&s, c, .5f), mixed = mix(&s, a, thin, .5f);
    const uint32_t sides = two_sided(&s, quarter, thin), hole = mask(&s, a, 0);
    const uint32_t all = mix(&s, a, b, 1), none = mix(&s, hole, hole, .5f);
    const struct stage *stage = scenes_stage(&s);
    ok(stage->wrapped && stage->masked, "the stage knows that it has such materials");
    ok(share(stage, a, false, a) == 1, "a plain material is itself");
    ok(share(stage, quarter, false, a) == .75 && share(stage, quarter, true, b) == .25,
       "a mix is its second by its amount");
    ok(share(stage, deep, false, a) == .375 && share(stage, deep, false, b) == .125 &&
           share(stage, deep, false, c) == .5,
       "and the number serves for a mix inside it");
    near(opacity(stage, mixed, false), .75, 0, "half of a half lets through a quarter");
    near(share(stage, mixed, false, c), 1. / 3, 1e-3, "of what is stopped a third is the mask's");
    ok(opacity(stage, sides, false) == 1 && opacity(stage, sides, true) == .5 &&
           share(stage, sides, true, c) == 1 && share(stage, sides, false, a) == .75,
       "two sides have each their own");
    ok(opacity(stage, none, false) == 0 && share(stage, none, false, a) == 1,
       "where nothing is there is still something to name");
    ok(share(stage, all, false, b) == 1, "an amount of 1 is the second alone");
    scenes_release(&s);
}

/* --- images --- */

static struct scenes_mean rendered(struct scenes *s, uint32_t spp)
{
    struct film film;
    scenes_render(scenes_stage(s), spp / STAT_SLOW < 8 ? 8 : spp / STAT_SLOW, &film);
    const struct scenes_mean m = scenes_mean(&film, 1);
    ok(film.invalid_count == 0, "no invalid samples");
    film_release(&film);
    scenes_release(s);
    return m;
}

/* As test_truth.c judges: within 3.9 standard errors, and 0.5 % would be found. */
static void is_true(struct scenes *s, uint32_t spp, double truth, const char *name)
{
    const struct scenes_mean m = rendered(s, spp);
    const double gate = STAT_SLOW == 1 ? .005 : .25, off = fabs(m.mean - truth);
    ok(off <= 3.9 * m.error + 1e-5 * truth && 6.23 * m.error <= gate * truth,
       "%s: %.6f is %.6f (detects %.2f %%)", name, truth, m.mean, 623 * m.error / truth);
}

/* Each vertex chooses anew, so that a mix reflects as its mean does. */
static void mix_in_a_furnace(void)
{
    struct scenes s;
    scenes_init(&s, 8, 8);
    scenes_look(&s, vec3_make(.2f, -.1f, .3f), vec3_make(0.5f, .3f, -1), pi / 2);
    s.scene.settings.max_bounces = 10000;
    const uint32_t bright = scenes_diffuse(&s, rgb_gray(.9f)),
                   dark = scenes_diffuse(&s, rgb_gray(.1f));
    const uint32_t mirror = scenes_mirror(&s, rgb_gray(.5f));
    const uint32_t wall = mix(&s, mix(&s, bright, dark, .25f), mirror, .5f); /* (.7 + .5) / 2 */
    scenes_box(&s, wall, vec3_make(-1, -1, -1), vec3_make(1, 1, 1), true);
    for (uint32_t i = 0; i < s.scene.shape_count; i++)
        s.scene.shapes[i].emission = rgb_gray(1);
    is_true(&s, 8192, 2.5, "a mix in a furnace");
}

/* A floor below a lamp, a point and a distant light and a sky, all seen through two black panes. */
static void floor_below(struct scenes *s, float opacity, bool panes)
{
    scenes_init(s, 8, 8);
    scenes_look(s, vec3_make(0, .5f, .1f), vec3_make(0, 0, 0), 1);
    const uint32_t gray = scenes_diffuse(s, rgb_gray(.5f)), black = scenes_diffuse(s, rgb_gray(0));
    scenes_quad(s, gray, vec3_make(-1, 0, 1), vec3_make(2, 0, 0), vec3_make(0, 0, -2));
    scenes_quad(s, black, vec3_make(-1, 3, -1), vec3_make(2, 0, 0), vec3_make(0, 0, 2))->emission =
        rgb_gray(1);
    struct light *point = scenes_light(s, LIGHT_POINT), *sun = scenes_light(s, LIGHT_DISTANT);
    vec3_store(point->point.position, vec3_make(.5f, 2, 0));
    point->point.intensity = rgb_gray(1);
    vec3_store(sun->distant.direction, vec3_unit(vec3_make(.1f, -1, .2f)));
    sun->distant.irradiance = rgb_gray(1);
    scenes_sky(s, rgb_gray(.3f));
    if (!panes)
        return;
    const uint32_t pane = mask(s, black, opacity);
    scenes_sphere(s, pane, vec3_make(0, 0, 0), 1.8f); /* round the floor and its camera */
    scenes_box(s, pane, vec3_make(-1.3f, -.5f, -1.3f), vec3_make(1.3f, 1, 1.3f), false);
}

/* Equal within a margin: a bias as large passes in 1 % of seeds. */
static void is_equal(double off, double error, double margin, const char *name)
{
    const struct means m = {off, error, (double)INFINITY};
    ok(means_unequal_p(&m, margin) < .01, "%s: off by %.5f +- %.5f, less than %.5f", name, off,
       error, margin);
}

static void panes_weaken(void)
{
    struct scenes s;
    floor_below(&s, 0, false);
    const struct scenes_mean bare = rendered(&s, 4096);
    floor_below(&s, .25f, true);
    const struct scenes_mean m = rendered(&s, 4096);
    const double left = .75 * .75;
    is_equal(m.mean - left * bare.mean, hypot(m.error, left * bare.error),
             bare.mean * (STAT_SLOW == 1 ? .004 : .2),
             "lamp, point, sun and sky through two masks of .25");
}

/* --- masks against holes --- */

static void tile(struct scenes *s, uint32_t material, int x, int z)
{
    scenes_quad(s, material, vec3_make(.25f * (float)x, 1, .25f * (float)z + .25f),
                vec3_make(.25f, 0, 0), vec3_make(0, 0, -.25f));
}

/* A lattice of tiles over a floor, every third of them missing: not there, or masked away. A lamp
 * on the other side, and a camera, so that rays of every sort pass the holes. */
static void lattice(struct scenes *s, bool masked)
{
    scenes_init(s, 8, 8);
    scenes_look(s, vec3_make(.1f, 1.6f, .2f), vec3_make(0, 0, 0), 1);
    const uint32_t gray = scenes_diffuse(s, rgb_gray(.8f));
    const uint32_t metal = scenes_metal(s, rgb_gray(.2f), rgb_gray(3.9f), .2f);
    const uint32_t hole = masked ? mask(s, metal, 0) : 0;
    scenes_quad(s, gray, vec3_make(-1, 0, 1), vec3_make(2, 0, 0), vec3_make(0, 0, -2));
    scenes_quad(s, gray, vec3_make(-1, 2, -1), vec3_make(2, 0, 0), vec3_make(0, 0, 2))->emission =
        rgb_gray(1);
    for (int i = 0; i < 64; i++) {
        const int x = i % 8 - 4, z = i / 8 - 4;
        if ((x + 2 * z + 12) % 3)
            tile(s, metal, x, z);
        else if (masked)
            tile(s, hole, x, z);
    }
}

static void holes(void)
{
    struct scenes s;
    lattice(&s, false);
    const struct scenes_mean cut = rendered(&s, 8192);
    lattice(&s, true);
    s.scene.settings.seed = 2;
    const struct scenes_mean masked = rendered(&s, 8192);
    is_equal(masked.mean - cut.mean, hypot(masked.error, cut.error),
             cut.mean * (STAT_SLOW == 1 ? .005 : .3), "tiles masked away are tiles cut out");
}

/* --- what changes nothing --- */

static void film_of(struct scenes *s, struct film *film)
{
    scenes_render(scenes_stage(s), 16, film);
    scenes_release(s);
}

static bool same_films(const struct film *a, const struct film *b)
{
    bool same = true;
    for (size_t i = 0; i < tile_rect_pixels(a->window); i++) {
        double x[3], y[3];
        film_mean(a, i, x);
        film_mean(b, i, y);
        same &= memcmp(x, y, sizeof x) == 0;
    }
    return same;
}

static void identities(void)
{
    struct scenes s;
    struct film plain, film;
    lattice(&s, false);
    film_of(&s, &plain);
    for (int i = 0; i < 4; i++) {
        lattice(&s, false);
        const uint32_t gray = 0, metal = 1;
        const uint32_t made[4] = {mask(&s, metal, 1), mix(&s, gray, metal, 1),
                                  mix(&s, metal, gray, 0), two_sided(&s, metal, metal)};
        for (uint32_t k = 0; k < s.scene.shape_count; k++)
            if (s.scene.shapes[k].material == metal)
                s.scene.shapes[k].material = made[i];
        film_of(&s, &film);
        static const char *const names[4] = {"a mask of 1", "a mix of 1", "a mix of 0",
                                             "two equal sides"};
        ok(same_films(&plain, &film), "%s: the same bits", names[i]);
        film_release(&film);
    }
    film_release(&plain);
}

static void sides(void)
{
    for (int back = 0; back < 2; back++) {
        struct scenes s;
        scenes_init(&s, 8, 8);
        scenes_look(&s, vec3_make(0, back ? -1 : 1, 1e-3f), vec3_make(0, 0, 0), .1);
        const uint32_t both =
            two_sided(&s, scenes_diffuse(&s, rgb_gray(.75f)), scenes_mirror(&s, rgb_gray(.25f)));
        scenes_quad(&s, both, vec3_make(-1, 0, 1), vec3_make(2, 0, 0), vec3_make(0, 0, -2));
        scenes_sky(&s, rgb_gray(1));
        is_true(&s, 64, back ? .25 : .75, back ? "behind" : "in front");
    }
}

int main(void)
{
    choices();
    mix_in_a_furnace();
    panes_weaken();
    holes();
    identities();
    sides();
    return tap_done();
}
