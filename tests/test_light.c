/* light.h: every light is sampled as its density says, from everywhere, at any corner of the
 * square.
 * SPDX-License-Identifier: MIT */
#include "common/trace/light.h"

#include <math.h>

#include "common/trace/bvh.h"
#include "common/trace/render.h"
#include "tests/catalog.h"
#include "tests/cylinder_view.h"
#include "tests/dice.h"
#include "tests/naive_path.h"
#include "tests/scenes.h"
#include "tests/stat/sphere_chi2.h"
#include "tests/stat/stat.h"
#include "tests/tap.h"

/* A black receiver at the origin facing up, and lights round it. */
static uint32_t begin(struct scenes *s)
{
    scenes_init(s, 1, 1);
    const uint32_t black = scenes_diffuse(s, rgb_gray(0));
    scenes_disc(s, black, vec3_make(0, 0, 0), vec3_make(0, 1, 0), 1e-3f);
    return black;
}

static struct surface receiver_of(const struct stage *stage)
{
    return surface_on_disc(stage, catalog_id(stage, 0), vec3_make(0, 0, 0));
}

struct scenery {
    const struct stage *stage;
    struct surface from;
};

static struct sobol_bits bits_of(struct square q)
{
    return (struct sobol_bits){(uint32_t)((double)q.u * 0x1p32), (uint32_t)((double)q.v * 0x1p32)};
}

static bool direction_sample(const void *what, struct square q, vec3 *w, float *pdf_w)
{
    const struct scenery *c = what;
    struct light_sample light;
    if (!light_sample(c->stage, &c->from, bits_of(q), &light))
        return false;
    *w = light.wi;
    *pdf_w = light.pdf_w;
    return true;
}

/* The lights are chosen apart from each other, so the first one met is the only one. */
static float direction_pdf_w(const void *what, vec3 w)
{
    const struct scenery *c = what;
    const struct ray ray = surface_leave(&c->from, w);
    struct ray_hit hit;
    if (!bvh_hit_closest(c->stage, &ray, &hit)) {
        float sum = 0; /* suns, too, are apart from each other */
        for (uint32_t e = c->stage->beyond_begin; e < c->stage->emitters.count; e++) {
            float pdf_w = 0;
            if (!rgb_is_black(light_beyond(c->stage, e, w, &pdf_w)))
                sum += pdf_w;
        }
        return sum;
    }
    const struct surface at = surface_at(c->stage, &ray, &hit);
    if (at.emitter == STAGE_NONE || vec3_dot(at.ng, w) > 0)
        return 0;
    return light_pdf_w(c->stage, &c->from, &at);
}

static void judge(struct scenes *s, float pdf_most, const char *name)
{
    const struct stage *stage = scenes_stage(s);
    const struct scenery c = {stage, receiver_of(stage)};
    const struct sphere_chi2 t = {
        direction_sample, direction_pdf_w, &c, 3, pdf_most, NULL, 0, false, 0};
    const struct sphere_chi2_result r = sphere_chi2_run(&t, 300000 / STAT_SLOW, 1);
    ok(r.chi2.p > stat_sidak(0.01, 14), "F-03: %s: directions follow the pdf (p %.3f)", name,
       r.chi2.p);
    ok(fabs(r.mass_off) < fmax(2e-3, 4 * r.mass_sd), "F-03: %s: pdf integrates to 1 (%.5f off)",
       name, r.mass_off);
    ok(r.pdf_off < 1e-4, "F-03: %s: pdf sampled is pdf asked (%.1e)", name, r.pdf_off);
    scenes_release(s);
}

static void add_sun(struct scenes *s, vec3 direction, float radius_rad, float radiance)
{
    struct light *sun = scenes_light(s, LIGHT_SUN);
    vec3_store(sun->sun.direction, vec3_unit(direction));
    sun->sun.radius_rad = radius_rad;
    sun->sun.radiance = rgb_gray(radiance);
}

static void directions_follow(void)
{
    struct scenes s;
    uint32_t black = begin(&s);
    scenes_triangle(&s, black, vec3_make(-1, .5f, -1), vec3_make(2, 1, 0), vec3_make(0, 2, 1))
        ->emission = rgb_gray(1);
    judge(&s, 0, "triangle");
    black = begin(&s);
    scenes_triangle(&s, black, vec3_make(-9, 3, -1), vec3_make(5, 20, -9), vec3_make(-2, 9, 9))
        ->emission = rgb_gray(1);
    judge(&s, 0, "triangle beyond where it is near");
    black = begin(&s);
    scenes_quad(&s, black, vec3_make(.02f, 0, -1), vec3_make(0, 0, 2), vec3_make(0, 1, .5f))
        ->emission = rgb_gray(1);
    judge(&s, 0, "quad that stands beside");
    black = begin(&s);
    scenes_quad(&s, black, vec3_make(-1, .05f, -1), vec3_make(3, 0, 0), vec3_make(0, .1f, 2))
        ->emission = rgb_gray(1);
    judge(&s, 0, "quad close overhead");
    black = begin(&s);
    scenes_disc(&s, black, vec3_make(.5f, 1, 0), vec3_make(-1, -1, .5f), 1)->emission = rgb_gray(1);
    judge(&s, 0, "disc");
    black = begin(&s);
    scenes_sphere(&s, black, vec3_make(0, 1, .4f), 1)->emission = rgb_gray(1);
    judge(&s, 0, "sphere close by");
    black = begin(&s);
    scenes_sphere(&s, black, vec3_make(3, 2, -1), 1)->emission = rgb_gray(1);
    judge(&s, 0, "sphere");
    black = begin(&s);
    scenes_cylinder(&s, black, vec3_make(-1, 2, 0), vec3_make(1, 1, .5f), .3f)->emission =
        rgb_gray(1);
    judge(&s, 5, "cylinder");
    black = begin(&s);
    scenes_cylinder(&s, black, vec3_make(-2, 1.1f, 1), vec3_make(2, 1.1f, 0), 1)->emission =
        rgb_gray(1);
    judge(&s, 2, "cylinder close by");
    black = begin(&s);
    scenes_sphere(&s, black, vec3_make(3, 2, -1), 1)->emission = rgb_gray(1);
    scenes_sphere(&s, black, vec3_make(-3, 2, -1), .5f)->emission = rgb_gray(20);
    scenes_quad(&s, black, vec3_make(0, 1, 1), vec3_make(1, 0, 0), vec3_make(0, 0, 2))->emission =
        rgb_gray(.3f);
    scenes_disc(&s, black, vec3_make(0, 1, -3), vec3_make(0, 0, 1), 1)->emission = rgb_gray(2);
    judge(&s, 0, "sphere, sphere, quad and disc together");
    begin(&s);
    add_sun(&s, vec3_make(-.3f, -1, .2f), .3f, 2);
    judge(&s, 0, "sun");
    begin(&s);
    add_sun(&s, vec3_make(.5f, -1, 0), 1.5707963f, 2);
    judge(&s, 0, "sun as large as half of the sky");
    black = begin(&s);
    add_sun(&s, vec3_make(-.3f, -1, .2f), .2f, 1);
    add_sun(&s, vec3_make(.6f, -.1f, .5f), .5f, 1);
    scenes_quad(&s, black, vec3_make(0, 1, 1), vec3_make(1, 0, 0), vec3_make(0, 0, 2))->emission =
        rgb_gray(.3f);
    judge(&s, 0, "two suns and a quad");
}

/* From a point whose distance to the sphere is no more than rounding: still a density. */
static void tiny_and_far_spheres(void)
{
    static const float radius[] = {1e-6f, 1e-3f, 0.999f};
    static const float distance[] = {1, 1e4f, 1e8f};
    struct dice dice = dice_make(9);
    bool good = true;
    double off = 0;
    for (size_t i = 0; i < countof(radius); i++)
        for (size_t j = 0; j < countof(distance); j++) {
            struct scenes s;
            const uint32_t black = begin(&s);
            scenes_sphere(&s, black, vec3_make(0, distance[j], 0), radius[i])->emission =
                rgb_gray(1);
            const struct stage *stage = scenes_stage(&s);
            const struct surface from = receiver_of(stage);
            double sum = 0;
            for (int k = 0; k < 1000; k++) {
                struct square q;
                q.u = dice_float(&dice);
                q.v = dice_float(&dice);
                struct light_sample light;
                good &= light_sample(stage, &from, bits_of(q), &light) && light.pdf_w > 0;
                good &= vec3_dot(light.wi, vec3_make(0, 1, 0)) > 0;
                sum += (double)(light.value[0]) / 1000;
            }
            const double sine = (double)radius[i] / (double)distance[j];
            const double solid = 2 * 3.14159265358979 * sine * sine / (1 + sqrt(1 - sine * sine));
            off = fmax(off, fabs(sum / solid - 1));
            scenes_release(&s);
        }
    ok(good && off < 1e-5, "spheres down to 1e-14 rad fill the solid angle they should (%.1e)",
       off);
}

/* The mean of a radiance of 1 over its density is the solid angle that is seen. */
static void cylinders_fill_their_solid_angle(void)
{
    static const struct {
        vec3 ends[2];
        float radius;
    } table[] = {
        {{{-1, 2, 0}, {1, 1, .5f}}, .3f},     {{{-2, 1.05f, 0}, {2, 1.05f, 0}}, 1},
        {{{.2f, 1, 0}, {.4f, 3, .1f}}, .01f}, {{{0, 1e4f, 0}, {5, 1e4f, 1}}, 1e-3f},
        {{{0, 1e8f, 0}, {10, 1e8f, 0}}, .1f}, {{{-100, 2, 3}, {200, 1, 4}}, .5f},
        {{{.02f, 1, 0}, {.02f, 9, 0}}, .01f}, {{{1e-3f, 1, 0}, {1e-3f, 2, 1e-3f}}, 1e-6f},
    };
    enum { N = STAT_SLOW == 1 ? 1000 : 200 };
    for (size_t i = 0; i < countof(table); i++) {
        struct scenes s;
        const uint32_t black = begin(&s);
        scenes_cylinder(&s, black, table[i].ends[0], table[i].ends[1], table[i].radius)->emission =
            rgb_gray(1);
        const struct stage *stage = scenes_stage(&s);
        const struct surface from = receiver_of(stage);
        double sum = 0;
        for (int k = 0; k < N * N; k++) {
            struct light_sample light;
            const struct square q = {((float)(k / N) + .5f) / N, ((float)(k % N) + .5f) / N};
            if (light_sample(stage, &from, bits_of(q), &light))
                sum += (double)light.value[0] / ((double)N * N);
        }
        const double solid =
            cylinder_view_make(table[i].ends, table[i].radius, vec3_make(0, 1, 0), 1000)
                .solid_angle;
        near(sum / solid, 1, STAT_SLOW == 1 ? 1e-4 : 1e-3,
             "cylinder %zu fills its solid angle of %.3g sr", i, solid);
        scenes_release(&s);
    }
}

/* Every sample at every corner is finite; and where it is chosen, the light is seen unoccluded. */
static void corners_are_finite(void)
{
    static const uint32_t edge[] = {0,          1,          0x3fffffff, 0x80000000,
                                    0xbfffffff, 0xfffffffe, 0xffffffff};
    struct scenes s;
    const uint32_t black = begin(&s);
    scenes_sphere(&s, black, vec3_make(3, 2, -1), 1)->emission = rgb_gray(1);
    scenes_sphere(&s, black, vec3_make(-1, 1, -1), 1e-5f)->emission = rgb_gray(1e10f);
    scenes_quad(&s, black, vec3_make(0, 1, 1), vec3_make(1, 0, 0), vec3_make(0, 0, 2))->emission =
        rgb_gray(.3f);
    scenes_disc(&s, black, vec3_make(0, 1, -3), vec3_make(0, 0, 1), 1)->emission = rgb_gray(2);
    scenes_cylinder(&s, black, vec3_make(2, 1, 1), vec3_make(1.5f, 2, 1.2f), .1f)->emission =
        rgb_gray(2);
    struct light *bulb = scenes_light(&s, LIGHT_POINT), *sun = scenes_light(&s, LIGHT_DISTANT);
    vec3_store(bulb->point.position, vec3_make(-2, 1, 2));
    bulb->point.intensity = rgb_gray(1);
    vec3_store(sun->distant.direction, vec3_make(0, -.6f, .8f));
    sun->distant.irradiance = rgb_gray(1);
    add_sun(&s, vec3_make(0, -1, .1f), 1e-4f, 1e6f);
    add_sun(&s, vec3_make(.1f, -1, .1f), .02f, 1);
    struct light *spot = scenes_light(&s, LIGHT_SPOT);
    vec3_store(spot->spot.position, vec3_make(2, 1, -2));
    vec3_store(spot->spot.direction, vec3_unit(vec3_make(-2, -1, 2)));
    spot->spot.intensity = rgb_gray(1);
    spot->spot.outer_rad = 1e-3f;
    const struct stage *stage = scenes_stage(&s);
    const struct surface from = receiver_of(stage);
    int bad = 0, dark = 0;
    const float *cdf = stage_at(stage, stage->pick_cdf);
    for (size_t n = 0; n < countof(edge) * countof(edge) * stage->emitters.count; n++) {
        /* The corners of each emitter's part of the square */
        const size_t e = n / 49;
        const double begin_u = (double)cdf[e] * 0x1p32, end_u = (double)cdf[e + 1] * 0x1p32;
        const double u = begin_u + (end_u - begin_u) * (edge[n % 7] * 0x1p-32);
        struct light_sample light;
        if (!light_sample(stage, &from, (struct sobol_bits){(uint32_t)u, edge[n / 7 % 7]}, &light))
            continue;
        dark += bvh_hit_any(stage, &light.shadow);
        bad += !(light.value[0] > 0 && isfinite(light.value[0]) && light.pdf_w >= 0 &&
                 isfinite(light.pdf_w) && fabsf(vec3_length(light.wi) - 1) < 1e-6f);
    }
    ok(bad == 0, "F-20: corners of the unit square give finite samples (%d bad)", bad);
    ok(dark == 0, "no light is in its own shadow, not at its corners (%d are)", dark);
    scenes_release(&s);
}

/* The table is sampled as often as it says, and the density asked contains the same share. */
static void picks_follow_table(void)
{
    enum { LIGHTS = 40 };
    struct scenes s;
    const uint32_t black = begin(&s);
    for (int i = 0; i < LIGHTS; i++) /* on a ring, seen alike; powers over three decades */
        scenes_sphere(&s, black, vec3_make(5 * (float)cos(i * .15), 3, 5 * (float)sin(i * .15)),
                      .1f)
            ->emission = rgb_gray(powf(10, (float)(i % 4)));
    const struct stage *stage = scenes_stage(&s);
    const struct surface from = receiver_of(stage);
    const struct emitter *emitters = stage_at(stage, stage->emitters);
    const uint32_t n = 1u << 15;
    uint32_t seen[LIGHTS] = {0};
    double due[LIGHTS], chosen[LIGHTS] = {0}, off = 0;
    for (uint32_t i = 0; i < n; i++) {
        const uint32_t bits = i * 0x9e3779b1u; /* all of [0, 2^32) evenly */
        struct light_sample light;
        if (!light_sample(stage, &from, (struct sobol_bits){bits, 1u << 31}, &light))
            continue;
        for (int k = 0; k < LIGHTS; k++) {
            struct surface at =
                surface_on_sphere(stage, catalog_id(stage, emitters[k].prim), -light.wi);
            at.emitter = (uint32_t)k;
            const vec3 d = vec3_unit(at.p - from.p);
            if (vec3_dot(d, light.wi) > 0.9997f) {
                seen[k]++;
                chosen[k] = (double)light.pdf_w / (double)light_pdf_w(stage, &from, &at);
            }
        }
    }
    for (int k = 0; k < LIGHTS; k++) {
        due[k] = n * (double)emitters[k].pick;
        off = fmax(off, fabs(chosen[k] - 1));
    }
    bool right = true;
    for (int k = 0; k < LIGHTS; k++)
        right &= fabs(seen[k] - due[k]) < 8 + 1e-3 * due[k];
    ok(right, "40 lights are picked as often as their share");
    ok(off < 1e-4, "the share is in the density (%.1e)", off);
    scenes_release(&s);
}

/* Suns found by directions alone give what suns sampled and found by directions give. */
static void suns_on_metal(void)
{
    struct scenes s;
    scenes_init(&s, 8, 8);
    scenes_look(&s, vec3_make(0, 1, 1), vec3_make(0, 0, 0), .02);
    s.scene.settings.max_bounces = 1;
    scenes_disc(&s, scenes_metal(&s, rgb_gray(.2f), rgb_gray(3), .3f), vec3_make(0, 0, 0),
                vec3_make(0, 1, 0), 1);
    add_sun(&s, vec3_make(.1f, -1, 1), .2f, 3);
    add_sun(&s, vec3_make(0, -1, 1), .5f, 1);
    const struct stage *stage = scenes_stage(&s);
    struct film film;
    scenes_render(stage, STAT_SLOW == 1 ? 2048 : 64, &film);
    const struct scenes_mean ours = scenes_mean(&film, 1);
    const struct stat_mean naive = naive_path_mean(stage, 400000 / STAT_SLOW, 3);
    const double error = hypot(ours.error, stat_error(&naive));
    ok(fabs(ours.mean - naive.mean) < 3.9 * error &&
           (STAT_SLOW > 1 || 6.2 * error < .02 * naive.mean),
       "two suns that overlap, on rough metal: %.5f is %.5f by directions alone (detects %.2f %%)",
       ours.mean, naive.mean, 620 * error / naive.mean);
    film_release(&film);
    scenes_release(&s);
}

/* At the middle of a mirror the sun is seen as it is. */
static void sun_is_seen(void)
{
    struct scenes s;
    rgb seen[2];
    for (int i = 0; i < 2; i++) {
        scenes_init(&s, 1, 1);
        scenes_look(&s, vec3_make(0, 0, 0), vec3_make(0, -1, -1), 1e-3);
        scenes_disc(&s, scenes_mirror(&s, rgb_gray(.5f)), vec3_make(0, -1, -1), vec3_make(0, 1, 0),
                    .1f);
        add_sun(&s, vec3_make(0, -1, i ? 1.1f : 1), .01f, 1000);
        const struct stage *stage = scenes_stage(&s);
        seen[i] = render_sample(stage, 0, 0, 0);
        scenes_release(&s);
    }
    ok(fabsf(seen[0][1] - 500) < 1e-3f && seen[1][1] == 0,
       "a mirror shows the sun, and only there");
}

static void spot_ends(void)
{
    static const float x[] = {0.57735f - 1e-5f, 0.57735f + 1e-5f, 5};
    struct light_sample light;
    struct scenes s;
    begin(&s);
    struct light *spot = scenes_light(&s, LIGHT_SPOT);
    spot->spot.intensity = rgb_gray(1);
    spot->spot.outer_rad = spot->spot.inner_rad = 0.52359878f;
    bool lit[3];
    for (int i = 0; i < 3; i++) {
        vec3_store(spot->spot.position, vec3_make(x[i], 1, 0));
        spot->spot.direction[1] = -1;
        const struct stage *stage = scenes_stage(&s);
        const struct surface from = receiver_of(stage);
        lit[i] = light_sample(stage, &from, (struct sobol_bits){0, 0}, &light);
    }
    ok(lit[0] && !lit[1] && !lit[2], "beyond its outer angle a spot has no light");
    scenes_release(&s);
}

int main(void)
{
    suns_on_metal();
    sun_is_seen();
    spot_ends();
    directions_follow();
    tiny_and_far_spheres();
    cylinders_fill_their_solid_angle();
    corners_are_finite();
    picks_follow_table();
    return tap_done();
}
