/* Analytic truths (docs/accuracy.md; the numbers A-xx are those of its table): scenes whose
 * radiance is known in closed form, rendered through render_tile and film_merge. The frame is 8 x 8
 * pixels, the gate that of judge.h. More of them, by areas and energy: test_energy.c.
 * SPDX-License-Identifier: MIT */
#include <math.h>
#include <stdio.h>

#include "tests/cylinder_view.h"
#include "tests/dice.h"
#include "tests/judge.h"
#include "tests/naive_path.h"
#include "tests/scenes.h"
#include "tests/stat/stat.h"
#include "tests/tap.h"

static const double pi = 3.14159265358979323846;
static void is_true(struct scenes *s, uint32_t spp, double truth, const char *name)
{
    judge_scene(s, spp, truth, name);
}

/* --- closed bodies that shine and reflect everywhere alike --- */

enum body { BODY_CUBE, BODY_BALL, BODY_WAVY };

static void furnace(struct scenes *s, enum body body, float albedo, uint32_t max_bounces)
{
    scenes_init(s, 8, 8);
    scenes_look(s, vec3_make(.2f, -.1f, .3f), vec3_make(0.5f, .3f, -1), pi / 2);
    s->scene.settings.max_bounces = max_bounces;
    const uint32_t wall = scenes_diffuse(s, rgb_gray(albedo));
    const vec3 center = vec3_make(0, 0, 0);
    switch (body) {
    case BODY_CUBE:
        scenes_box(s, wall, vec3_make(-1, -1, -1), vec3_make(1, 1, 1), true);
        break;
    case BODY_BALL:
        scenes_ball(s, wall, center, 1, 6, 0, true);
        break;
    case BODY_WAVY:
        scenes_ball(s, wall, center, 1, 7, 0.3f, true);
        break;
    }
    for (uint32_t i = 0; i < s->scene.shape_count; i++)
        s->scene.shapes[i].emission = rgb_gray(1);
}

static void furnaces(void)
{
    struct scenes s;
    furnace(&s, BODY_CUBE, .5f, 10000);
    is_true(&s, 2048, 2, "A-01: cube, albedo .5");
    furnace(&s, BODY_CUBE, .8f, 10000);
    is_true(&s, 8192, 5, "A-01: cube, albedo .8");
    furnace(&s, BODY_CUBE, .95f, 10000);
    is_true(&s, 12288, 20, "A-01: cube, albedo .95");
    furnace(&s, BODY_CUBE, .8f, 8);
    is_true(&s, 4096, 4.328911, "A-01: cube, albedo .8, 8 bounces");
    furnace(&s, BODY_CUBE, .95f, 8);
    is_true(&s, 4096, 7.395012, "A-01: cube, albedo .95, 8 bounces");
    furnace(&s, BODY_CUBE, .8f, 0);
    is_true(&s, 8, 1, "A-01: cube, emission alone");
    furnace(&s, BODY_BALL, .5f, 10000);
    is_true(&s, 2048, 2, "A-01: ball, albedo .5");
    furnace(&s, BODY_WAVY, .5f, 10000);
    is_true(&s, 2048, 2, "A-01: wavy mesh, albedo .5");
    furnace(&s, BODY_WAVY, .8f, 3);
    is_true(&s, 1024, 2.952, "A-01: wavy mesh, albedo .8, 3 bounces");
}

/* --- E on a small white receiver at the origin: L = E / pi after one bounce --- */

static void receiver(struct scenes *s, vec3 normal)
{
    scenes_init(s, 8, 8);
    const vec3 n = vec3_unit(normal);
    scenes_look(s, n * 0.01f, vec3_make(0, 0, 0), 1e-3);
    s->scene.settings.max_bounces = 1;
    scenes_disc(s, scenes_diffuse(s, rgb_gray(1)), vec3_make(0, 0, 0), n, 1e-3f);
}

/* Lambert: E = L/2 n . sum of (angle of edge) (unit normal of the edge's plane), from the origin.
 */
static double lambert(double v[][3], int count, const double n[3])
{
    double sum = 0;
    for (int i = 0; i < count; i++) {
        const double *a = v[i], *b = v[(i + 1) % count];
        const double c[3] = {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2],
                             a[0] * b[1] - a[1] * b[0]};
        const double length = sqrt(c[0] * c[0] + c[1] * c[1] + c[2] * c[2]);
        const double angle = atan2(length, a[0] * b[0] + a[1] * b[1] + a[2] * b[2]);
        sum += angle * (n[0] * c[0] + n[1] * c[1] + n[2] * c[2]) / length;
    }
    return fabs(sum) / 2;
}

/* A random triangle in the wedge of azimuth [phi, phi + 1], shining towards the origin. */
static double add_triangle(struct scenes *s, uint32_t black, double phi, double radiance,
                           struct dice *dice)
{
    static const double up[3] = {0, 1, 0};
    double v[3][3];
    vec3 p[3];
    for (int i = 0; i < 3; i++) {
        const double a = phi + dice_unit(dice), r = dice_range(dice, 0.3, 2);
        const float at[3] = {(float)(r * cos(a)), (float)dice_range(dice, 0.2, 2),
                             (float)(r * sin(a))};
        p[i] = vec3_load(at);
        for (int k = 0; k < 3; k++)
            v[i][k] = (double)at[k];
    }
    const bool faces = vec3_dot(vec3_cross(p[1] - p[0], p[2] - p[0]), p[0]) < 0;
    scenes_triangle(s, black, p[0], p[faces ? 1 : 2], p[faces ? 2 : 1])->emission =
        rgb_gray((float)radiance);
    return radiance * lambert(v, 3, up);
}

/* The same by sampling directions alone. */
static struct scenes_mean naive_mean(const struct stage *stage, uint32_t paths)
{
    struct dice dice = dice_make(1);
    struct stat_mean m = {0};
    for (uint32_t i = 0; i < paths; i++) {
        double sum[3] = {0, 0, 0};
        naive_path_sample(stage, i % 8, i / 8 % 8, &dice, sum);
        stat_add(&m, sum[1]);
    }
    return (struct scenes_mean){m.mean, stat_error(&m)};
}

static void triangle_lights(void)
{
    struct dice dice = dice_make(5);
    struct scenes s;
    char name[64];
    for (int i = 0; i < 3; i++) {
        receiver(&s, vec3_make(0, 1, 0));
        const double e = add_triangle(&s, scenes_diffuse(&s, rgb_gray(0)), 2.0 * i, 1, &dice);
        snprintf(name, sizeof name, "A-02: triangle light %d", i + 1);
        is_true(&s, 2048, e / pi, name);
    }
    for (int same = 0; same < 2; same++) {
        receiver(&s, vec3_make(0, 1, 0));
        const uint32_t black = scenes_diffuse(&s, rgb_gray(0));
        double e = 0;
        for (int i = 0; i < 5; i++)
            e += add_triangle(&s, black, 1.2 * i, same ? 1 : pow(4, i), &dice);
        if (same)
            judge_mean(naive_mean(scenes_stage(&s), judge_samples(14000000)), e / pi,
                       "A-02: five triangles, directions sampled");
        is_true(&s, 8192, e / pi,
                same ? "A-02: five triangles" : "A-02: five triangles of radiance 1 to 256");
    }
}

static void rectangle_lights(void)
{
    struct scenes s;
    receiver(&s, vec3_make(0, 1, 0));
    const uint32_t black = scenes_diffuse(&s, rgb_gray(0));
    scenes_quad(&s, black, vec3_make(0, .5f, 0), vec3_make(1, 0, 0), vec3_make(0, 0, 2))->emission =
        rgb_gray(1);
    is_true(&s, 2048, .220777622, "A-03: rectangle overhead");
    receiver(&s, vec3_make(0, 1, 0));
    scenes_quad(&s, scenes_diffuse(&s, rgb_gray(0)), vec3_make(0, .5f, 0), vec3_make(0, 0, 2),
                vec3_make(1, 0, 0))
        ->emission = rgb_gray(1);
    struct film film;
    scenes_render(scenes_stage(&s), 64, &film);
    ok(scenes_mean(&film, 1).mean == 0, "a light's back is dark");
    film_release(&film);
    scenes_release(&s);
}

/* --- a sphere of radius s at distance 1, at the angle acos(c) from the normal --- */

static double sphere_irradiance(double ss, double c)
{
    if (c * c > ss)
        return pi * ss * fmax(c, 0);
    const double sine = sqrt(1 - c * c), x = sqrt(1 / ss - 1), y = -x * c / sine;
    const double q = sine * sqrt(1 - y * y);
    return (c * acos(y) - x * q) * ss + atan(q / x);
}

static void sphere_lights(void)
{
    static const struct {
        double ss, c, e;
        uint32_t spp;
    } table[] = {{.25, .3, .247292, 2048},  {.25, 0, .090586, 4096},  {.25, -.1, .055646, 2048},
                 {.25, -.3, .011672, 8192}, {.64, .1, .552636, 4096}, {.25, .8, 0, 512},
                 {.01, 1, 0, 256},          {1e-8, .5, 0, 256}};
    for (size_t i = 0; i < countof(table); i++) {
        const double c = table[i].c, e = sphere_irradiance(table[i].ss, c);
        if (table[i].e > 0 && fabs(e - table[i].e) > 1e-6)
            ok(false, "A-05: the formula gives the table's %g", table[i].e);
        struct scenes s;
        receiver(&s, vec3_make(0, 1, 0));
        const vec3 at = vec3_make((float)sqrt(1 - c * c), (float)c, 0);
        scenes_sphere(&s, scenes_diffuse(&s, rgb_gray(0)), at, (float)sqrt(table[i].ss))->emission =
            rgb_gray(1);
        if (c == 1) /* out of the camera's way */
            scenes_look(&s, vec3_make(.005f, .01f, 0), vec3_make(0, 0, 0), 1e-3);
        char name[64];
        snprintf(name, sizeof name, "A-05: sphere, s^2 %g, cos %g", table[i].ss, c);
        is_true(&s, table[i].spp, e / pi, name);
    }
}

/* --- Cylinder lights --- */

/* View factor of an element that faces the axis of a cylinder of radius 1 from the distance h, over
 * the first end: J. Howell's catalogue of configuration factors, B-31. An odd function of the
 * length. */
static double cylinder_factor(double h, double length)
{
    const double l = fabs(length), x = (1 + h) * (1 + h) + l * l, y = (1 - h) * (1 - h) + l * l;
    const double k = sqrt((h - 1) / (h + 1));
    const double f =
        atan(l / sqrt(h * h - 1)) / (pi * h) +
        l / pi * ((x - 2 * h) / (h * sqrt(x * y)) * atan(sqrt(x / y) * k) - atan(k) / h);
    return length < 0 ? -f : f;
}

/* `form`: the closed form's irradiance; 0: there is none, quadrature stands alone. */
static void cylinder_light(const char *what, const vec3 ends[2], float radius, vec3 normal,
                           double form)
{
    struct scenes s;
    char name[64];
    receiver(&s, normal);
    const double e = cylinder_view_make(ends, radius, vec3_unit(normal), 1000).irradiance;
    snprintf(name, sizeof name, "cylinder light, %s", what);
    if (form > 0)
        near(e / form, 1, 5e-6, "%s: quadrature gives the closed form's %.6f", name, form);
    scenes_cylinder(&s, scenes_diffuse(&s, rgb_gray(0)), ends[0], ends[1], radius)->emission =
        rgb_gray(1);
    is_true(&s, 2048, (form > 0 ? form : e) / pi, name);
}

static void cylinder_lights(void)
{
    static const struct {
        const char *what;
        float h, r, begin, end;
    } lying[] = {{"overhead", 1, .4f, -1, 1},
                 {"to one side", 1, .4f, .5f, 3},
                 {"close by", 1, .9f, -.5f, 1},
                 {"thin and long", 1, .01f, -100, 100}};
    const vec3 up = vec3_make(0, 1, 0);
    /* Along z, h above the origin: B-31's answers for two lengths from there, subtracted. */
    for (size_t i = 0; i < countof(lying); i++) {
        const float h = lying[i].h, begin = lying[i].begin, end = lying[i].end;
        const double r = (double)lying[i].r;
        const vec3 ends[2] = {vec3_make(0, h, begin), vec3_make(0, h, end)};
        const double e = pi * (cylinder_factor((double)h / r, (double)end / r) -
                               cylinder_factor((double)h / r, (double)begin / r));
        cylinder_light(lying[i].what, ends, lying[i].r, up, e);
    }
    const vec3 sunk[2] = {vec3_make(1, .1f, -1), vec3_make(1, -.2f, 2)};
    cylinder_light("partly below the horizon", sunk, .5f, up, 0);
    const vec3 column[2] = {vec3_make(.5f, 0, .2f), vec3_make(.5f, 3, .2f)};
    cylinder_light("a column on the floor", column, .1f, up, 0);
    const vec3 beam[2] = {vec3_make(.3f, .5f, 0), vec3_make(1.2f, 4, 1)};
    cylinder_light("seen along its axis", beam, .1f, vec3_make(.2f, 1, 0), 0);
}

/* A closed cylinder in a closed box, where all shine and reflect alike. */
static void cylinder_in_furnace(void)
{
    struct scenes s;
    furnace(&s, BODY_CUBE, .5f, 10000);
    const vec3 from = vec3_make(-.5f, -.4f, -.5f), to = vec3_make(.1f, .4f, -.7f);
    scenes_cylinder(&s, 0, from, to, .2f)->emission = rgb_gray(1);
    scenes_disc(&s, 0, from, from - to, .2f)->emission = rgb_gray(1);
    scenes_disc(&s, 0, to, to - from, .2f)->emission = rgb_gray(1);
    scenes_look(&s, vec3_make(.2f, -.1f, .3f), vec3_make(-.2f, 0, -.6f), pi / 3);
    is_true(&s, 4096, 2, "A-01: cube with a closed cylinder in it, albedo .5");
}

/* --- disc, sun, sky; A-09: point light --- */

static void simple_lights(void)
{
    struct scenes s;
    receiver(&s, vec3_make(0, 1, 0));
    scenes_disc(&s, scenes_diffuse(&s, rgb_gray(0)), vec3_make(0, 1, 0), vec3_make(0, -1, 0), .7f)
        ->emission = rgb_gray(1);
    is_true(&s, 1024, .49 / 1.49, "A-06: disc overhead");

    receiver(&s, vec3_make(.6f, .8f, 0));
    struct light *sun = scenes_light(&s, LIGHT_DISTANT);
    vec3_store(sun->distant.direction, vec3_make(0, -1, 0));
    sun->distant.irradiance = rgb_gray((float)pi);
    is_true(&s, 8, .8, "A-06: distant light");

    receiver(&s, vec3_make(.6f, .8f, 0));
    scenes_sky(&s, rgb_gray(.75f));
    scenes_sky(&s, rgb_gray(.25f));
    is_true(&s, 64, 1, "A-06: uniform skies");

    receiver(&s, vec3_make(0, 1, 0));
    struct light *bulb = scenes_light(&s, LIGHT_POINT);
    vec3_store(bulb->point.position, vec3_make(3, 4, 0));
    bulb->point.intensity = rgb_gray((float)pi * 25);
    is_true(&s, 8, .8, "A-06: point light");
}

static void point_light_in_sphere(void)
{
    struct scenes s;
    scenes_init(&s, 8, 8);
    scenes_look(&s, vec3_make(.2f, .4f, .1f), vec3_make(.3f, -.5f, -1), pi / 3);
    s.scene.settings.max_bounces = 1000;
    scenes_sphere(&s, scenes_diffuse(&s, rgb_gray(.5f)), vec3_make(0, 0, 0), 1);
    struct light *bulb = scenes_light(&s, LIGHT_POINT);
    bulb->point.intensity = rgb_gray((float)pi);
    is_true(&s, 2048, 1, "A-09: point light in a sphere");
}

/* --- glass in a uniform sky cannot be seen; A-12: a slab; A-17: mirrors --- */

static double worst_pixel(struct scenes *s, double truth)
{
    struct film film;
    scenes_render(scenes_stage(s), 256 / STAT_SLOW, &film);
    double worst = 0;
    for (size_t i = 0; i < tile_rect_pixels(film.window); i++) {
        double mean[3];
        film_mean(&film, i, mean);
        for (int c = 0; c < 3; c++)
            worst = fmax(worst, fabs(mean[c] / truth - 1));
    }
    film_release(&film);
    scenes_release(s);
    return worst;
}

static struct scenes glass_in_sky(uint32_t *glass, float ior)
{
    struct scenes s;
    scenes_init(&s, 8, 8);
    scenes_look(&s, vec3_make(1, 2, 3), vec3_make(0, 0, 0), .5);
    s.scene.settings.max_bounces = 1000;
    scenes_sky(&s, rgb_gray(1));
    *glass = scenes_glass(&s, ior);
    return s;
}

static void glass(void)
{
    const vec3 center = vec3_make(0, 0, 0), lo = vec3_make(-.5f, -.7f, -.6f);
    uint32_t m;
    struct scenes s = glass_in_sky(&m, 1.5f);
    scenes_sphere(&s, m, center, 1);
    ok(worst_pixel(&s, 1) < 1e-5, "A-13: glass sphere: every pixel is 1");
    s = glass_in_sky(&m, 2.4f);
    scenes_box(&s, m, lo, -lo, false);
    ok(worst_pixel(&s, 1) < 1e-5, "A-13: diamond box: every pixel is 1");
    s = glass_in_sky(&m, 1.3f);
    scenes_ball(&s, m, center, 1, 6, .2f, false);
    scenes_sphere(&s, scenes_glass(&s, 1.8f), vec3_make(.3f, 0, 0), .3f);
    ok(worst_pixel(&s, 1) < 1e-3, "A-13: sphere in a wavy ball: every pixel is 1");
    s = glass_in_sky(&m, 1);
    scenes_sphere(&s, m, center, 1);
    scenes_sphere(&s, m, center, 1);
    ok(worst_pixel(&s, 1) < 1e-5, "A-13: coincident spheres of index 1: every pixel is 1");
    s = glass_in_sky(&m, 1.5f);
    scenes_look(&s, center, vec3_make(1, 0, 0), 1);
    scenes_sphere(&s, m, center, 1);
    ok(worst_pixel(&s, 2.25) < 1e-5, "A-13: from the centre of a glass sphere: 2.25");
    s = glass_in_sky(&m, 1.5f);
    const vec3 end = vec3_make(.4f, .7f, .1f);
    scenes_cylinder(&s, m, -end, end, .5f);
    scenes_disc(&s, m, end, end, .5f);
    scenes_disc(&s, m, -end, -end, .5f);
    ok(worst_pixel(&s, 1) < 1e-5, "A-13: glass rod: every pixel is 1");
    s = glass_in_sky(&m, 1.5f);
    scenes_cylinder(&s, scenes_diffuse(&s, rgb_gray(1)), -vec3_make(.3f, .6f, 1),
                    vec3_make(.3f, .6f, 1), .5f);
    ok(worst_pixel(&s, 1) < 1e-5, "white tube, open at both ends: every pixel is 1");
}

static void slab(double degrees, double reflectance)
{
    struct scenes s;
    scenes_init(&s, 8, 8);
    s.scene.settings.max_bounces = 1000;
    const double a = degrees * pi / 180;
    scenes_look(&s, vec3_make((float)sin(a), 1, (float)cos(a)), vec3_make(0, 1, 0), 1e-3);
    scenes_box(&s, scenes_glass(&s, 1.5f), vec3_make(-50, -50, -.01f), vec3_make(50, 50, 0), false);
    scenes_quad(&s, scenes_diffuse(&s, rgb_gray(0)), vec3_make(-90, -90, -1), vec3_make(180, 0, 0),
                vec3_make(0, 180, 0))
        ->emission = rgb_gray(1);
    char name[64];
    snprintf(name, sizeof name, "A-12: slab at %g degrees lets through", degrees);
    is_true(&s, 4096, 1 - reflectance, name);
}

static void mirrors(float r, uint32_t spp, double truth, const char *name)
{
    struct scenes s;
    scenes_init(&s, 8, 8);
    s.scene.settings.max_bounces = 10000;
    scenes_box(&s, scenes_mirror(&s, rgb_gray(r)), vec3_make(-1, -1, -1), vec3_make(1, 2, 3), true);
    for (uint32_t i = 0; i < s.scene.shape_count; i++)
        s.scene.shapes[i].emission = rgb_gray(1);
    is_true(&s, spp, truth, name);
}

/* --- A-19, F-01: the error model itself --- */

static void small_light(void)
{
    struct scenes s;
    receiver(&s, vec3_make(0, 1, 0));
    scenes_look(&s, vec3_make(.005f, .01f, 0), vec3_make(0, 0, 0), 1e-3);
    scenes_sphere(&s, scenes_diffuse(&s, rgb_gray(0)), vec3_make(0, 1, 0), .1f)->emission =
        rgb_gray(100);
    const struct stage *stage = scenes_stage(&s);
    const uint32_t n = 1000000 / STAT_SLOW;
    const struct scenes_mean m = naive_mean(stage, n);
    near(m.error * m.error * n, 99, STAT_SLOW == 1 ? 5 : 20,
         "A-19: directions sampled find a light of share .01 with relative variance 99");
    is_true(&s, 256, 1, "A-19: the light itself is sampled");
}

int main(void) /* the cheapest first */
{
    simple_lights();
    rectangle_lights();
    glass();
    slab(0, .076923077);
    slab(45, .095673);
    mirrors(.5f, 2048, 2, "A-17: mirror box, reflectance .5");
    point_light_in_sphere();
    sphere_lights();
    cylinder_lights();
    cylinder_in_furnace();
    mirrors(.9f, 12288, 10, "A-17: mirror box, reflectance .9");
    furnaces();
    triangle_lights();
    small_light();
    return tap_done();
}
