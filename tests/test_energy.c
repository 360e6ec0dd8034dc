/* Analytic truths about light exchanged between surfaces (docs/accuracy.md; A-xx and F-xx are
 * numbers of its tables): view factors of whole areas, and balances of energy. They are means over
 * surfaces, so points are drawn on these and looked at from just outside.
 * SPDX-License-Identifier: MIT */
#include <math.h>
#include <stdio.h>

#include "common/trace/path.h"
#include "tests/catalog.h"
#include "tests/judge.h"
#include "tests/stat/stat.h"
#include "tests/tap.h"

static const double pi = 3.14159265358979323846;

/* --- the mean radiance of all surfaces, by area, but for what they emit; triangles only --- */

enum { MAX_TRIANGLES = 4096 };

struct skin {
    const struct stage *stage;
    uint32_t count;
    struct stage_id id[MAX_TRIANGLES];
    double until[MAX_TRIANGLES]; /* area up to and with this one */
};

static double skin_make(struct skin *skin, const struct stage *stage)
{
    struct stage_id id;
    double area = 0;
    *skin = (struct skin){.stage = stage};
    for (uint64_t at = 0; catalog_next(stage, &at, &id);) {
        const struct stage_triangle t = stage_triangle_at(stage, id.place.index, id.instance);
        const vec3 a = vec3_load(t.v[0]), b = vec3_load(t.v[1]), c = vec3_load(t.v[2]);
        area += 0.5 * (double)vec3_length(vec3_cross(b - a, c - a));
        skin->id[skin->count] = id;
        skin->until[skin->count++] = area;
    }
    return area;
}

enum { DIMENSION_TRIANGLE = 100000, DIMENSION_POINT }; /* beyond those of any path here */

/* A ray that looks straight at a point of the skin, from the front. */
static struct ray skin_ray(const struct skin *skin, const struct rng *rng)
{
    const double u = (double)rng_single(rng, DIMENSION_TRIANGLE) * skin->until[skin->count - 1];
    uint32_t i = 0;
    while (i + 1 < skin->count && skin->until[i] <= u)
        i++;
    const struct square b = warp_triangle(rng_pair(rng, DIMENSION_POINT));
    const struct surface at = surface_on_triangle(skin->stage, skin->id[i], b.u, b.v);
    return (struct ray){at.p + 1e-3f * at.ng, -at.ng, __builtin_inff(), 0, 0};
}

/* Each replicate of each of many pixels is independent of all others. */
static struct scenes_mean skin_mean(const struct skin *skin, uint32_t samples)
{
    enum { PIXELS = 64 };
    const uint32_t each = samples / (PIXELS * WAVE_LANES);
    struct stat_mean m = {0};
    for (uint32_t pixel = 0; pixel < PIXELS; pixel++) {
        double sum[WAVE_LANES] = {0};
        for (uint32_t j = 0; j < each; j++) {
            struct ray rays[WAVE_LANES];
            struct rng rngs[WAVE_LANES];
            struct wave_starts starts;
            rgb light[WAVE_LANES];
            for (uint32_t k = 0; k < WAVE_LANES; k++) {
                rngs[k] = rng_make(1, pixel, 0, WAVE_LANES * j + k);
                rays[k] = skin_ray(skin, &rngs[k]);
            }
            wave_begin(skin->stage, 0xff, rays, rngs, &starts);
            for (uint32_t k = 0; k < WAVE_LANES; k++)
                starts.light[k] = rgb_gray(0);
            scenes_follow(skin->stage, 0xff, &starts, rngs, PATH_ROULETTE_BEGIN, light);
            for (uint32_t k = 0; k < WAVE_LANES; k++)
                sum[k] += (double)light[k][1] / each;
        }
        for (uint32_t k = 0; k < WAVE_LANES; k++)
            stat_add(&m, sum[k]);
    }
    return (struct scenes_mean){m.mean, stat_error(&m)};
}

/* --- in a closed body of one albedo the mean irradiance is flux / (area (1 - albedo)),
 * whatever is in it and wherever the light is --- */

enum content { EMPTY, BALL, SLABS };

static void balance(enum content content, float albedo, uint32_t samples, const char *name)
{
    struct scenes s;
    scenes_init(&s, 1, 1);
    s.scene.settings.max_bounces = 10000;
    const uint32_t wall = scenes_diffuse(&s, rgb_gray(albedo));
    scenes_box(&s, wall, vec3_make(0, 0, 0), vec3_make(1, 1, 1), true);
    s.scene.shapes[4].emission = rgb_gray((float)(1 / pi)); /* an exitance of 1 on 1 m^2 */
    if (content == BALL)
        scenes_ball(&s, wall, vec3_make(.45f, .5f, .55f), .3f, 12, .3f, false);
    if (content == SLABS) {
        scenes_box(&s, wall, vec3_make(.1f, .2f, .1f), vec3_make(.9f, .21f, .8f), false);
        scenes_box(&s, wall, vec3_make(.3f, .3f, .2f), vec3_make(.31f, .95f, .9f), false);
    }
    static struct skin skin;
    const double area = skin_make(&skin, scenes_stage(&s));
    const struct scenes_mean m = skin_mean(&skin, judge_samples(samples));
    judge_mean(m, (double)albedo / (pi * area * (1 - (double)albedo)), name);
    scenes_release(&s);
}

/* --- view factors of areas: a white receiver shows them after one bounce --- */

/* Looks down, so that the frame is [-1, 1]^2 at the height of 0. */
static void from_above(struct scenes *s)
{
    scenes_init(s, 8, 8);
    scenes_look(s, vec3_make(0, 1, 0), vec3_make(0, 0, 0), pi / 2);
    s->scene.settings.max_bounces = 1;
}

static void perpendicular_rectangle(void)
{
    struct scenes s;
    scenes_init(&s, 8, 8);
    scenes_look(&s, vec3_make(0, .01f, 0), vec3_make(0, 0, 0), 1e-3);
    s.scene.settings.max_bounces = 1;
    scenes_disc(&s, scenes_diffuse(&s, rgb_gray(1)), vec3_make(0, 0, 0), vec3_make(0, 1, 0), 1e-3f);
    scenes_quad(&s, scenes_diffuse(&s, rgb_gray(0)), vec3_make(.7f, 0, 0), vec3_make(0, 0, 2),
                vec3_make(0, 1.3f, 0))
        ->emission = rgb_gray(1);
    judge_scene(&s, 4096, .125876108, "A-04: wall beside the floor");
}

static void discs(float r1, float r2, float h, const char *name)
{
    struct scenes s;
    from_above(&s);
    const double a = (double)(r1 / h), b = (double)(r2 / h), x = 1 + (1 + b * b) / (a * a);
    const double factor = 0.5 * (x - sqrt(x * x - 4 * (b / a) * (b / a)));
    scenes_disc(&s, scenes_diffuse(&s, rgb_gray(1)), vec3_make(0, 0, 0), vec3_make(0, 1, 0), r1);
    scenes_disc(&s, scenes_diffuse(&s, rgb_gray(0)), vec3_make(0, h, 0), vec3_make(0, -1, 0), r2)
        ->emission = rgb_gray(1);
    /* E = pi F, radiance E / pi; and the frame is 4 m^2 */
    judge_scene(&s, 8192, factor * pi * (double)r1 * (double)r1 / 4, name);
}

static void cube_walls(int light, double factor, const char *name)
{
    struct scenes s;
    scenes_cube(&s, 8, 8, light);
    judge_scene(&s, 5120, factor, name);
}

/* --- whatever lights a sphere from inside, its own light is even --- */

static void integrating_sphere(float off)
{
    struct scenes s;
    char name[64];
    const double intensity = pi, flux = 4 * pi * intensity, albedo = .5;
    const vec3 seen = vec3_make(0, -1, 0), bulb = vec3_make(0, off, 0);
    scenes_init(&s, 8, 8);
    scenes_look(&s, vec3_make(.1f, .2f, 0), seen, 1e-3);
    s.scene.settings.max_bounces = 1000;
    scenes_sphere(&s, scenes_diffuse(&s, rgb_gray((float)albedo)), vec3_make(0, 0, 0), 1);
    struct light *light = scenes_light(&s, LIGHT_POINT);
    vec3_store(light->point.position, bulb);
    light->point.intensity = rgb_gray((float)intensity);
    const double d = 1 + (double)off; /* straight above what is seen */
    const double e = intensity / (d * d) + flux * albedo / (4 * pi * (1 - albedo));
    snprintf(name, sizeof name, "A-09: point light %g off the centre of a sphere", (double)off);
    judge_scene(&s, 4096, albedo * e / pi, name);
}

/* --- two spheres, one in the other, which emits --- */

static void concentric(void)
{
    const double r1 = .5, r2 = .8, f21 = .25, f22 = 1 - f21;
    const double b2 = r2 * f21 / (1 - r2 * f22 - r1 * r2 * f21), b1 = 1 + r1 * b2;
    for (int outwards = 0; outwards < 2; outwards++) {
        struct scenes s;
        scenes_init(&s, 8, 8);
        const vec3 from = vec3_make(1.5f, 0, 0);
        scenes_look(&s, from, from + vec3_make(outwards ? 1 : -1, .1f, 0), pi / 6);
        s.scene.settings.max_bounces = 10000;
        scenes_sphere(&s, scenes_diffuse(&s, rgb_gray((float)r1)), vec3_make(0, 0, 0), 1)
            ->emission = rgb_gray((float)(1 / pi));
        scenes_sphere(&s, scenes_diffuse(&s, rgb_gray((float)r2)), vec3_make(0, 0, 0), 2);
        judge_scene(&s, 4096, (outwards ? b2 : b1) / pi,
                    outwards ? "A-16: outer of two spheres" : "A-16: inner of two spheres");
    }
}

int main(void)
{
    perpendicular_rectangle();
    discs(1, 1, 2, "A-07: coaxial discs");
    discs(.8f, 2, 1.5f, "A-07: coaxial discs, the larger one shines");
    discs(1, .2f, 3, "A-07: coaxial discs, the smaller one shines");
    cube_walls(3, .199824896, "A-08: opposite wall of a cube");
    cube_walls(4, .200043776, "A-08: adjacent wall of a cube");
    integrating_sphere(0);
    integrating_sphere(.5f);
    integrating_sphere(-.7f);
    if (stat_is_long())
        balance(EMPTY, .5f, 780000, "A-15: empty cube");
    balance(BALL, .5f, 1400000, "A-15: a wavy ball in a cube");
    balance(SLABS, .8f, 780000, "A-15: slabs in a cube, albedo .8");
    concentric();
    return tap_done();
}
