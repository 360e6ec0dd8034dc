/* Rows F-01, A-19 and F-02 of docs/accuracy.md: variance of one sample, by the way it was made. A
 * light aimed at, a direction drawn from the material, and both, as path.c does (MIS), at a single
 * point. Mirrors of many widths under lights of many sizes: E. Veach, "Robust Monte Carlo Methods
 * for Light Transport Simulation", Stanford 1997, section 9.3.1.
 * SPDX-License-Identifier: MIT */
#include "common/trace/path.h"

#include <math.h>

#include "common/trace/bsdf.h"
#include "common/trace/bvh.h"
#include "common/trace/light.h"
#include "tests/scenes.h"
#include "tests/stat/stat.h"
#include "tests/tap.h"

/* --- one sample of what is reflected at the first point of a ray, three ways --- */

static double aimed(const struct stage *s, const struct path_vertex *v, const struct rng *rng)
{
    struct light_sample light;
    if (!light_sample(s, &v->at, rng_pair_bits(rng, rng_dimension(0, RNG_LIGHT)), &light))
        return 0;
    const rgb f = bsdf_eval(v->material, v->wo, warp_to_local(&v->frame, light.wi)) * light.value;
    return f[0] > 0 && !bvh_hit_any(s, &light.shadow) ? (double)f[0] : 0;
}

static double drawn(const struct stage *s, const struct path_vertex *v, const struct rng *rng)
{
    struct bsdf_sample b;
    const struct square q = rng_pair(rng, rng_dimension(0, RNG_BSDF_DIRECTION));
    const float lobe = rng_single(rng, rng_dimension(0, RNG_BSDF_LOBE));
    if (!bsdf_sample(v->material, v->wo, lobe, q, &b))
        return 0;
    const struct ray ray = surface_leave(&v->at, warp_to_world(&v->frame, b.wi));
    struct ray_hit hit;
    if (!bvh_hit_closest(s, &ray, &hit))
        return 0;
    const struct surface on = surface_at(s, &ray, &hit);
    if (on.emitter == STAGE_NONE || vec3_dot(on.ng, ray.dir) > 0)
        return 0;
    const struct emitter *e = (const struct emitter *)stage_at(s, s->emitters) + on.emitter;
    return (double)(b.weight[0] * e->radiance[0]);
}

struct ways {
    struct stat_mean aimed, drawn, both;
};

/* Every sample has a pixel of its own, so that all are independent. */
static struct ways three_ways(const struct stage *stage, struct ray ray, uint32_t count)
{
    struct ways w = {.aimed = {0}};
    const struct rng first = rng_make(17, 0, 0, 0);
    struct wave_starts start;
    wave_begin(stage, 1, &ray, &first, &start);
    const struct path_vertex vertex = wave_first(stage, &start, 0);
    for (uint32_t i = 0; i < count; i++) {
        const struct rng rng = rng_make(17, i & 0xffff, i >> 16, 0);
        rgb light;
        scenes_follow(stage, 1, &start, &rng, UINT32_MAX, &light);
        stat_add(&w.both, (double)light[0]);
        stat_add(&w.aimed, aimed(stage, &vertex, &rng));
        stat_add(&w.drawn, drawn(stage, &vertex, &rng));
    }
    return w;
}

/* A ball of light above a floor at the origin, which is seen at an angle. */
static struct ray floor_and_ball(struct scenes *s, uint32_t floor, vec3 at, float radius,
                                 float radiance)
{
    s->scene.settings.max_bounces = 1;
    scenes_disc(s, floor, vec3_make(0, 0, 0), vec3_make(0, 1, 0), 1e-2f);
    scenes_sphere(s, scenes_diffuse(s, rgb_gray(0)), at, radius)->emission = rgb_gray(radiance);
    const vec3 eye = vec3_make(-2, 2, 0);
    return (struct ray){eye, vec3_unit(-eye), __builtin_inff(), 0, 0};
}

/* --- F-01, A-19: only directions, a small light --- */

static void small_lights(void)
{
    static const float radius[] = {.1f, .01f};
    for (size_t i = 0; i < countof(radius); i++) {
        struct scenes s;
        scenes_init(&s, 1, 1);
        const double p = (double)(radius[i] * radius[i]);
        const struct ray ray = floor_and_ball(&s, scenes_diffuse(&s, rgb_gray(1)),
                                              vec3_make(0, 1, 0), radius[i], (float)(1 / p));
        const uint32_t count = stat_tries(i ? 3000000 : 400000, i ? 20000000 : 4000000);
        const struct ways w = three_ways(scenes_stage(&s), ray, count);
        near(stat_variance(&w.drawn) * p / (1 - p), 1, STAT_SLOW == 1 ? .1 : .6,
             "F-01: radius %g: directions alone have relative variance (1 - p) / p = %.0f",
             (double)radius[i], (1 - p) / p);
        ok(stat_variance(&w.both) <= .05 * w.both.mean * w.both.mean &&
               fabs(w.both.mean - 1) < 3.9 * stat_error(&w.both) + 1e-5,
           "F-01: radius %g: with the light aimed at it is %.2g", (double)radius[i],
           stat_variance(&w.both));
        scenes_release(&s);
    }
}

/* --- F-02: Veach's plates --- */

struct cell { /* variances and squared mean, summed over points */
    double aimed, drawn, both, mu;
};

/* Light reflected into the middle, and into points from there outwards. */
static struct cell plate(float alpha, float radius, uint32_t count)
{
    enum { POINTS = 4 };
    struct cell c = {0, 0, 0, 0};
    for (int i = 0; i < POINTS; i++) {
        struct scenes s;
        scenes_init(&s, 1, 1);
        const uint32_t floor = scenes_metal(&s, rgb_gray(.2f), rgb_gray(3.9f), alpha);
        const vec3 at = vec3_make(2, 2 + .4f * (float)i * (radius + alpha), 0);
        const struct ray ray = floor_and_ball(&s, floor, at, radius, 1 / (radius * radius));
        const struct ways w = three_ways(scenes_stage(&s), ray, count);
        c.aimed += stat_variance(&w.aimed);
        c.drawn += stat_variance(&w.drawn);
        c.both += stat_variance(&w.both);
        c.mu += w.both.mean * w.both.mean;
        scenes_release(&s);
    }
    return c;
}

static void plates(void)
{
    static const float alpha[] = {1e-3f, 1e-2f, 3e-2f, 1e-1f}, radius[] = {.02f, .1f, .3f, .9f};
    double bound = -HUGE_VAL;
    for (size_t i = 0; i < countof(alpha) * countof(radius); i++) {
        const float a = alpha[i / 4], r = radius[i % 4];
        const struct cell c = plate(a, r, stat_tries(20000, 300000));
        const double best = fmin(c.aimed, c.drawn);
        bound = fmax(bound, (c.both - best) / c.mu);
    }
    ok(bound <= (STAT_SLOW == 1 ? .5 : 3),
       "F-02: V(MIS) <= V(best of the two) + mu^2 / 2 in 16 cells (+ %.3f mu^2)", bound);
}

int main(void)
{
    small_lights();
    plates();
    return tap_done();
}
