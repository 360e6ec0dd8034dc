/* Where light and receiver touch (docs/accuracy.md; A-xx are numbers of its table): polygons that
 * cut the receiver's plane or stand on it, rectangles down to no height at all, walls of a cube up
 * to their common edge. Each by every strategy, in the gate of judge.h.
 * SPDX-License-Identifier: MIT */
#include <math.h>
#include <stdio.h>

#include "tests/judge.h"
#include "tests/stat/stat.h"
#include "tests/tap.h"

static const double pi = 3.14159265358979323846;

static const char *const strategy_names[] = {
    [STRATEGY_MIS] = "mis", [STRATEGY_LIGHT] = "light", [STRATEGY_BSDF] = "bsdf"};

/* A white receiver at the origin that faces y, one scattering, seen from a height at which the
 * frame is small beside the distance to the light. */
static void receiver(struct scenes *s, float height)
{
    scenes_init(s, 8, 8);
    scenes_look(s, vec3_make(0, height, 0), vec3_make(0, 0, 0), 1e-3);
    s->scene.settings.max_bounces = 1;
    scenes_disc(s, scenes_diffuse(s, rgb_gray(1)), vec3_make(0, 0, 0), vec3_make(0, 1, 0), 1e-3f);
}

/* As many samples as the gate asks for, found by tries: the error of spread points falls by about
 * n^-0.75. */
static void is_true(struct scenes *s, enum strategy_kind strategy, double truth, const char *name)
{
    const double gate = STAT_SLOW > 1 ? .25 : stat_is_long() ? .002 : .005;
    const double most = 1 << 20, want = gate * truth / 6.23;
    char text[96];
    struct film film;
    s->scene.settings.strategy = strategy;
    const struct stage *stage = scenes_stage(s);
    double spp = 64;
    for (;;) {
        scenes_render(stage, (uint32_t)spp, &film);
        const double error = scenes_mean(&film, 1).error;
        if (error <= want || spp == most)
            break;
        spp = fmin(fmax(2 * spp, 1.1 * spp * pow(error / want, 1.3)), most);
        film_release(&film);
    }
    snprintf(text, sizeof text, "%s, %s", name, strategy_names[strategy]);
    judge_mean(scenes_mean(&film, 1), truth, text);
    if (film.invalid_count)
        ok(false, "%s: %lu invalid samples", text, (unsigned long)film.invalid_count);
    film_release(&film);
}

/* By each strategy. Directions alone are left out where all but a few meet the light, since those
 * few are too rare for an error, and in the quick tier where few meet it. */
static void all_true(struct scenes *s, double distance, double truth, const char *name)
{
    is_true(s, STRATEGY_MIS, truth, name);
    is_true(s, STRATEGY_LIGHT, truth, name);
    if (distance > .01 && (truth > .1 || stat_is_long()))
        is_true(s, STRATEGY_BSDF, truth, name);
}

/* --- Lambert's formula, of what is above the horizon --- */

struct polygon {
    uint32_t count;
    double v[8][3];
};

/* The part with y >= 0 (I. Sutherland, G. Hodgman, "Reentrant Polygon Clipping", CACM 17(1),
 * 1974: one plane of it). */
static struct polygon above(const struct polygon *p)
{
    struct polygon out = {0};
    for (uint32_t i = 0; i < p->count; i++) {
        const double *a = p->v[i], *b = p->v[(i + 1) % p->count];
        if (a[1] >= 0) {
            for (int k = 0; k < 3; k++)
                out.v[out.count][k] = a[k];
            out.count++;
        }
        if ((a[1] > 0 && b[1] < 0) || (a[1] < 0 && b[1] > 0)) {
            const double t = a[1] / (a[1] - b[1]);
            for (int k = 0; k < 3; k++)
                out.v[out.count][k] = k == 1 ? 0 : a[k] + t * (b[k] - a[k]);
            out.count++;
        }
    }
    return out;
}

/* E = L/2 n . sum of (angle of edge) (unit normal of the edge's plane), n = y. Edges along the
 * horizon add nothing to that, those through the origin are none. */
static double lambert(const struct polygon *whole)
{
    const struct polygon p = above(whole);
    double sum = 0;
    for (uint32_t i = 0; i < p.count; i++) {
        const double *a = p.v[i], *b = p.v[(i + 1) % p.count];
        const double c[3] = {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2],
                             a[0] * b[1] - a[1] * b[0]};
        const double length = sqrt(c[0] * c[0] + c[1] * c[1] + c[2] * c[2]);
        if (length > 0)
            sum += atan2(length, a[0] * b[0] + a[1] * b[1] + a[2] * b[2]) * c[1] / length;
    }
    return fabs(sum) / 2;
}

static void polygon_light(const char *name, uint32_t corners, const float v[][3], float distance)
{
    struct scenes s;
    struct polygon p = {.count = corners};
    for (uint32_t i = 0; i < corners; i++)
        for (int k = 0; k < 3; k++)
            p.v[i][k] = (double)v[i][k];
    receiver(&s, distance / 10);
    const vec3 a = vec3_load(v[0]), b = vec3_load(v[1]), last = vec3_load(v[corners - 1]);
    const uint32_t black = scenes_diffuse(&s, rgb_gray(0));
    const bool faces = vec3_dot(vec3_cross(b - a, last - a), a) < 0;
    struct shape *light;
    if (corners == 3)
        light = scenes_triangle(&s, black, a, faces ? b : last, faces ? last : b);
    else
        light = scenes_quad(&s, black, a, faces ? b - a : last - a, faces ? last - a : b - a);
    light->emission = rgb_gray(1);
    all_true(&s, (double)distance, lambert(&p) / pi, name);
    scenes_release(&s);
}

static void polygons(void)
{
    static const float sunk[][3] = {{.3f, -.5f, -.2f}, {.9f, 1, .1f}, {.4f, -.3f, .8f}};
    static const float tip[][3] = {{-.2f, -1, .5f}, {-.4f, 1.5f, .2f}, {-.1f, -2, -.6f}};
    polygon_light("A-02: triangle, one corner above the floor", 3, sunk, .1f);
    polygon_light("A-02: triangle through the floor, close by", 3, tip, .1f);
    static const float leaning[][3] = {
        {.2f, -.4f, -1}, {.2f, -.4f, 1}, {-.3f, 1, 1}, {-.3f, 1, -1}};
    polygon_light("A-02: panel that leans over, through the floor", 4, leaning, .1f);
    const int step = stat_is_long() ? 2 : 4;
    for (int i = 1; i <= 5; i += step) {
        const float d = powf(10, (float)-i);
        const float foot[][3] = {{d, 0, -.5f}, {d, 0, .7f}, {d, 1, .1f}};
        const float wall[][3] = {{d, -.2f, -.5f}, {d, -.2f, .5f}, {d, .8f, .5f}, {d, .8f, -.5f}};
        char name[64];
        snprintf(name, sizeof name, "A-02: triangle on the floor, %g m away", (double)d);
        polygon_light(name, 3, foot, d);
        snprintf(name, sizeof name, "A-02: wall through the floor, %g m away", (double)d);
        polygon_light(name, 4, wall, d);
    }
}

/* --- a rectangle of 1 x 2 with a corner, an edge or its middle overhead --- */

/* One corner overhead. */
static double corner_factor(double a, double b, double c)
{
    const double x = a / c, y = b / c, p = sqrt(1 + x * x), q = sqrt(1 + y * y);
    return (x / p * atan(y / p) + y / q * atan(x / q)) / (2 * pi);
}

static void rectangles(void)
{
    static const struct {
        const char *what;
        double x, z; /* of the corner nearest to the origin, as parts of the sides */
        int copies;  /* corners of smaller rectangles that meet overhead */
        double a, b;
    } places[] = {
        {"corner", 0, 0, 1, 1, 2}, {"edge", .5, 0, 2, .5, 2}, {"middle", .5, .5, 4, .5, 1}};
    const int step = stat_is_long() ? 2 : 4;
    for (size_t i = 0; i < countof(places); i++)
        for (int k = 1; k <= 5; k += step) {
            const float c = powf(10, (float)-k);
            const double f = places[i].copies * corner_factor(places[i].a, places[i].b, (double)c);
            struct scenes s;
            char name[64];
            receiver(&s, c / 10);
            scenes_quad(&s, scenes_diffuse(&s, rgb_gray(0)),
                        vec3_make(-(float)places[i].x, c, -2 * (float)places[i].z),
                        vec3_make(1, 0, 0), vec3_make(0, 0, 2))
                ->emission = rgb_gray(1);
            snprintf(name, sizeof name, "A-03: rectangle %g m above, its %s", (double)c,
                     places[i].what);
            all_true(&s, (double)c, f, name);
            scenes_release(&s);
        }
}

/* --- walls of a cube, averaged up to the edge in which they meet --- */

static void cube_walls(int light, double factor, const char *name)
{
    struct scenes s;
    scenes_cube(&s, 8, 8, light);
    all_true(&s, 1, factor, name);
    scenes_release(&s);
}

int main(void)
{
    polygons();
    rectangles();
    cube_walls(3, .199824896, "A-08: opposite wall of a cube");
    cube_walls(4, .200043776, "A-08: adjacent wall of a cube");
    return tap_done();
}
