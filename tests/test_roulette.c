/* Rows A-18, F-04 and F-05 of docs/accuracy.md: what Russian roulette does to lengths and variance
 * of paths, and what endless paths cost.
 *
 * In a box of mirrors that shine, a path's light is known from its length alone, so roulette is all
 * the chance there is. Its rule here has no q to choose (path.c): with reflectance a the
 * throughput, relative to the first scattering's, is a, a^2, ...; below a half the chance to go on
 * is twice that, and from there on a, which is always above a^2. SPDX-License-Identifier: MIT */
#include "common/trace/path.h"

#include <math.h>

#include "tests/scenes.h"
#include "tests/stat/chi2.h"
#include "tests/stat/means.h"
#include "tests/tap.h"

enum { MOST = 4096 }; /* scatterings looked at */

struct lengths {         /* of paths in the box, as the rule has it */
    double chance[MOST]; /* of exactly so many scatterings */
    double light[MOST];  /* what such a path brings: grows with their number */
    double mean, variance, rays;
};

static void lengths_make(struct lengths *l, double a)
{
    double throughput = 1, alive = 1, light = 1, square = 0;
    *l = (struct lengths){.rays = 1};
    for (int n = 0; n < MOST; n++) {
        throughput *= a;
        const double q = n >= PATH_ROULETTE_BEGIN ? fmin(1, 2 * throughput / a) : 1;
        l->chance[n] = alive * (1 - q);
        l->light[n] = light;
        l->mean += l->chance[n] * light;
        square += l->chance[n] * light * light;
        alive *= q;
        l->rays += alive;
        throughput /= q;
        light += throughput;
    }
    l->variance = square - l->mean * l->mean;
}

/* How many scatterings a path had that brought so much; MOST: no path brings that. */
static int length_of(const struct lengths *l, double light)
{
    int begin = 0, end = MOST; /* light[begin] <= light < light[end], nearly */
    while (end - begin > 1) {
        const int middle = begin + (end - begin) / 2;
        if (l->light[middle] <= light * (1 + 1e-4))
            begin = middle;
        else
            end = middle;
    }
    return fabs(l->light[begin] - light) < 1e-4 * light ? begin : MOST;
}

static void mirrors(struct scenes *s, float r)
{
    scenes_init(s, 1, 1);
    s->scene.settings.max_bounces = 10000;
    scenes_box(s, scenes_mirror(s, rgb_gray(r)), vec3_make(-1, -1, -1), vec3_make(1, 2, 3), true);
    for (uint32_t i = 0; i < s->scene.shape_count; i++)
        s->scene.shapes[i].emission = rgb_gray(1);
}

struct walk { /* many paths along one ray */
    struct stat_mean light;
    const struct lengths *lengths; /* or NULL: they are not asked for */
    uint32_t seen[MOST + 1];       /* by length */
};

/* Paths with the numbers of pixels of their own: independent of each other. */
static void walk(const struct stage *stage, struct ray ray, uint32_t roulette_begin, uint32_t count,
                 struct walk *w)
{
    struct wave_starts starts;
    struct ray rays[WAVE_LANES];
    struct rng first[WAVE_LANES];
    for (uint32_t i = 0; i < WAVE_LANES; i++) {
        rays[i] = ray;
        first[i] = rng_make(9, 0, 0, i);
    }
    wave_begin(stage, 0xff, rays, first, &starts);
    for (uint32_t i = 0; i < count; i += WAVE_LANES) {
        struct rng rngs[WAVE_LANES];
        rgb light[WAVE_LANES];
        for (uint32_t k = 0; k < WAVE_LANES; k++)
            rngs[k] = rng_make(9, (i + k) & 0xffff, (i + k) >> 16, 0);
        scenes_follow(stage, 0xff, &starts, rngs, roulette_begin, light);
        for (uint32_t k = 0; k < WAVE_LANES; k++) {
            stat_add(&w->light, (double)light[k][0]);
            if (w->lengths)
                w->seen[length_of(w->lengths, (double)light[k][0])]++;
        }
    }
}

static struct ray some_ray(void)
{
    return (struct ray){vec3_make(0, 0, 0), vec3_unit(vec3_make(.3f, .5f, 1)), __builtin_inff(), 0,
                        0};
}

/* --- A-18, F-04 --- */

static void lengths_and_variance(float a)
{
    const double slack = STAT_SLOW == 1 ? .05 : .5;
    static struct lengths l;
    static struct walk w;
    struct scenes s;
    mirrors(&s, a);
    lengths_make(&l, (double)a);
    w = (struct walk){.lengths = &l};
    const uint32_t count = stat_tries(60000, 400000) / WAVE_LANES * WAVE_LANES;
    walk(scenes_stage(&s), some_ray(), PATH_ROULETTE_BEGIN, count, &w);
    double due[MOST + 1] = {0}, rays = 0;
    for (int n = 0; n <= MOST; n++) {
        due[n] = n < MOST ? l.chance[n] * count : 0;
        rays += (n + 1.0) * w.seen[n] / count;
    }
    const struct chi2 lengths = chi2_test(due, w.seen, MOST + 1);
    const struct means m = means_from_truth(&w.light, 1 / (1 - (double)a));
    ok(lengths.p > stat_sidak(0.01, 5),
       "F-04: reflectance %g: lengths are those of the rule (p %.3f, detects %.3f rms)", (double)a,
       lengths.p, chi2_detects(&lengths, count, stat_sidak(0.01, 5)));
    ok(means_p(&m) > stat_sidak(0.01, 5), "F-04: their light is 1 / (1 - %g) (detects %.2f %%)",
       (double)a, 100 * (1 - (double)a) * means_detects(&m, stat_sidak(0.01, 5)));
    near(stat_variance(&w.light) / l.variance, 1, slack, "A-18: its variance is %.4g", l.variance);
    near(rays / l.rays, 1, slack, "F-04: a path has %.4g rays in the mean", l.rays);
    /* What A-18 has for q = a from the first bounce on. */
    const double mean = 1 / (1 - (double)a);
    ok(l.variance * l.rays < (double)a * mean * mean * mean,
       "F-04: variance x length is below that of the constant q = %g", (double)a);
    scenes_release(&s);
}

/* --- F-05 --- */

static void furnace(struct scenes *s, float albedo)
{
    scenes_init(s, 1, 1);
    s->scene.settings.max_bounces = 10000;
    scenes_box(s, scenes_diffuse(s, rgb_gray(albedo)), vec3_make(-1, -1, -1), vec3_make(1, 1, 1),
               true);
    for (uint32_t i = 0; i < s->scene.shape_count; i++)
        s->scene.shapes[i].emission = rgb_gray(1);
}

/* `gate`: the smallest bias to be found. 10000 bounces leave out less than 1e-4. */
static void nearly_endless(struct scenes *s, double truth, uint32_t count, double gate,
                           const char *name)
{
    static struct walk w;
    w = (struct walk){.lengths = NULL};
    walk(scenes_stage(s), some_ray(), PATH_ROULETTE_BEGIN, count, &w);
    const struct means m = means_from_truth(&w.light, truth);
    const double found = means_detects(&m, 1e-4) / truth;
    ok(means_p(&m) > 1e-4 && found < gate * (STAT_SLOW == 1 ? 1 : 8),
       "F-05: %s: %g is %.6g (detects %.2f %%)", name, truth, w.light.mean, 100 * found);
    scenes_release(s);
}

/* Work is rays. Without roulette there are as many as bounces are allowed. */
static void without_roulette(void)
{
    static struct walk none, usual;
    static struct lengths l;
    struct scenes s;
    furnace(&s, .99f);
    const struct stage *stage = scenes_stage(&s);
    lengths_make(&l, (double).99f);
    walk(stage, some_ray(), UINT32_MAX, stat_tries(160, 1600), &none);
    walk(stage, some_ray(), PATH_ROULETTE_BEGIN, stat_tries(4000, 40000), &usual);
    const double ratio = stat_variance(&none.light) * (s.scene.settings.max_bounces + 1) /
                         (stat_variance(&usual.light) * l.rays);
    ok(ratio < 3, "F-05: albedo .99: variance x rays without roulette is %.2f of that with it",
       ratio);
    scenes_release(&s);
}

int main(void)
{
    static const float a[] = {.5f, .8f, .9f, .95f, .99f};
    struct scenes s;
    for (size_t i = 0; i < countof(a); i++)
        lengths_and_variance(a[i]);
    furnace(&s, .99f);
    nearly_endless(&s, 100, stat_tries(20000, 450000), stat_is_long() ? .005 : .03, "albedo .99");
    without_roulette();
    mirrors(&s, .999f);
    nearly_endless(&s, 1000 * (1 - pow(.999, 10001)), stat_tries(6000, 110000),
                   stat_is_long() ? .01 : .05, "mirrors of .999");
    return tap_done();
}
