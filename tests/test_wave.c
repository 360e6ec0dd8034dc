/* wave.c, path8.c, light8.c, surface8.h, warp8.h: a path has the same bits among others as by
 * itself, here followed ray by ray with the functions for one.
 * SPDX-License-Identifier: MIT */
#include "common/trace/wave.h"

#include <string.h>

#include "common/trace/bsdf.h"
#include "common/trace/bvh.h"
#include "common/trace/light.h"
#include "common/trace/light8.h"

#include "tests/dice.h"
#include "tests/scenes.h"
#include "tests/tap.h"

/* --- one path, alone --- */

struct alone {
    const struct stage *stage;
    struct rng rng;
    uint32_t roulette_begin;
    struct surface at;
    struct warp_frame frame;
    vec3 wo;
    rgb light, throughput;
    float scale, pdf_w;
    struct film_work work; /* rays after the first */
};

static const struct material *material_of(const struct alone *a)
{
    return (const struct material *)stage_at(a->stage, a->stage->materials) + a->at.material;
}

static float power(float a, float b)
{
    const float r = b / a;
    return 1 / (1 + r * r);
}

static void look_at_light(struct alone *a, uint32_t bounce)
{
    const struct material *m = material_of(a);
    const struct sobol_bits q = rng_pair_bits(&a->rng, rng_dimension(bounce, RNG_LIGHT));
    struct light_sample l;
    if (bsdf_is_delta(m) || !light_sample(a->stage, &a->at, q, &l))
        return;
    const vec3 wi = warp_to_local(&a->frame, l.wi);
    rgb f = bsdf_eval(m, a->wo, wi);
    f *= l.value;
    if (l.pdf_w != 0 && !rgb_is_black(f))
        f *= power(l.pdf_w, bsdf_pdf_w(m, a->wo, wi) * path_trust(a->stage)->bsdf);
    if (rgb_is_black(a->throughput * f))
        return;
    a->work.shadow_rays++;
    if (bvh_hit_any(a->stage, &l.shadow))
        return;
    a->light += a->throughput * f;
}

static bool scatter(struct alone *a, uint32_t bounce, struct ray *ray)
{
    struct bsdf_sample s;
    const float lobe = rng_single(&a->rng, rng_dimension(bounce, RNG_BSDF_LOBE));
    const struct square q = rng_pair(&a->rng, rng_dimension(bounce, RNG_BSDF_DIRECTION));
    if (!bsdf_sample(material_of(a), a->wo, lobe, q, &s))
        return false;
    a->throughput *= s.weight;
    a->scale = bounce == 0 ? rgb_max(a->throughput) : a->scale * s.scale;
    a->pdf_w = s.pdf_w;
    const vec3 dir = warp_to_world(&a->frame, s.wi);
    if (rgb_is_black(a->throughput) || !(vec3_dot(dir, a->at.ng) * s.wi[2] > 0))
        return false;
    const float q_on = 2 * (rgb_max(a->throughput) / a->scale);
    if (bounce >= a->roulette_begin && q_on < 1) {
        if (rng_single(&a->rng, rng_dimension(bounce, RNG_ROULETTE)) >= q_on)
            return false;
        a->throughput /= q_on;
    }
    *ray = surface_leave(&a->at, dir);
    return true;
}

/* False: into the sky. */
static bool arrive(struct alone *a, const struct ray *ray, bool first)
{
    struct ray_hit hit;
    if (!bvh_hit_closest(a->stage, ray, &hit)) {
        const rgb sky = path_beyond(a->stage, ray->dir, first ? 0 : a->pdf_w);
        a->light += first ? sky : a->throughput * sky;
        return false;
    }
    const struct surface from = a->at;
    a->at = surface_at(a->stage, ray, &hit);
    a->frame = warp_frame_make(a->at.ng);
    a->wo = warp_to_local(&a->frame, -ray->dir);
    a->at.lit = path_lit(a->stage, material_of(a), a->wo[2]);
    if (a->at.emitter == STAGE_NONE || !(a->wo[2] > 0))
        return true;
    const struct emitter *e =
        (const struct emitter *)stage_at(a->stage, a->stage->emitters) + a->at.emitter;
    const rgb found = vec3_load(e->radiance);
    if (first || a->pdf_w == 0) {
        a->light += first ? found : a->throughput * found;
        return true;
    }
    const float chosen = light_pdf_w(a->stage, &from, &a->at) * path_trust(a->stage)->light;
    a->light += a->throughput * found * power(a->pdf_w, chosen);
    return true;
}

static rgb radiance_alone(const struct stage *s, struct ray ray, struct rng rng,
                          uint32_t roulette_begin, struct film_work *work)
{
    struct alone a = {.stage = s,
                      .rng = rng,
                      .roulette_begin = roulette_begin,
                      .light = rgb_gray(0),
                      .throughput = rgb_gray(1)};
    if (!arrive(&a, &ray, true))
        return a.light;
    for (uint32_t bounce = 0; bounce < s->settings.max_bounces; bounce++) {
        look_at_light(&a, bounce);
        const bool goes_on = scatter(&a, bounce, &ray);
        a.work.bounce_rays += goes_on;
        if (!goes_on || !arrive(&a, &ray, false))
            break;
    }
    film_work_add(work, &a.work);
    return a.light;
}

/* --- whole paths --- */

enum room { BARE, LAMPS, BALLS, ROUND_LAMP, SHAPES, MANY, BSDF_ALONE, LIGHT_ALONE };

/* Every kind of shape; materials that let light through, that have lobes, that have neither; lights
 * of several kinds. */
static void add_shapes(struct scenes *s)
{
    const struct material rough = {.kind = MATERIAL_DIELECTRIC,
                                   .dielectric = {.ior = 1.4f, .alpha = .3f}},
                          pane = {.kind = MATERIAL_PANE, .pane = {.ior = 1.5f}},
                          plastic = {.kind = MATERIAL_PLASTIC,
                                     .plastic = {vec3_make(.2f, .5f, .6f), 1.5f, .1f}},
                          leaf = {.kind = MATERIAL_LEAF,
                                  .leaf = {vec3_make(.3f, .4f, .1f), vec3_make(.2f, .5f, .1f)}};
    const vec3 eta = vec3_make(.14f, .38f, 1.44f), k = vec3_make(3.98f, 2.39f, 1.6f);
    const uint32_t white = scenes_diffuse(s, rgb_gray(.8f));
    scenes_sphere(s, scenes_material(s, rough), vec3_make(.4f, .4f, .3f), .35f);
    scenes_sphere(s, scenes_material(s, plastic), vec3_make(.5f, 1.2f, 1), .3f);
    scenes_disc(s, scenes_material(s, leaf), vec3_make(-.4f, 1.2f, .4f), vec3_make(.6f, .8f, 0),
                .4f);
    scenes_disc(s, scenes_material(s, pane), vec3_make(0, .8f, 1.6f), vec3_make(0, 0, 1), .5f);
    scenes_cylinder(s, scenes_metal(s, eta, k, .2f), vec3_make(-.8f, .2f, 1),
                    vec3_make(-.7f, 1.2f, 1.2f), .15f);
    scenes_cylinder(s, white, vec3_make(.8f, .2f, 1.4f), vec3_make(.8f, 1.5f, 1.8f), .1f)
        ->emission = vec3_make(2, 1, .5f);
    scenes_disc(s, white, vec3_make(-.5f, .6f, -.9f), vec3_make(0, 0, 1), .3f)->emission =
        vec3_make(1, 2, 1);
    struct light *point = scenes_light(s, LIGHT_POINT);
    vec3_store(point->point.position, vec3_make(.1f, 1.5f, .6f));
    point->point.intensity = vec3_make(.2f, .1f, .3f);
    s->scene.shapes[2].material = scenes_material(s, plastic); /* a wall */
}

/* A box with coloured walls, one of them black, and a block that may be seen from inside. */
static void build(struct scenes *s, enum room room)
{
    scenes_init(s, 8, 8);
    s->scene.settings.max_bounces = 12;
    const uint32_t white = scenes_diffuse(s, rgb_gray(.7f));
    scenes_box(s, white, vec3_make(-1, 0, -1), vec3_make(1, 2, 3), true);
    s->scene.shapes[0].material = scenes_diffuse(s, vec3_make(.6f, 0, .1f));
    s->scene.shapes[1].material = scenes_diffuse(s, rgb_gray(0));
    s->scene.shapes[3].material = scenes_diffuse(s, vec3_make(.9f, .95f, .1f));
    scenes_box(s, white, vec3_make(-.6f, .01f, -.6f), vec3_make(-.1f, .9f, 0), room == BARE);
    for (int i = 0; i < (room == LAMPS ? 3 : 1); i++)
        scenes_quad(s, white, vec3_make(-.5f + .4f * (float)i, 1.9f, -.2f), vec3_make(.3f, 0, 0),
                    vec3_make(0, 0, .4f))
            ->emission = vec3_make(3, 2, (float)i);
    if (room == LAMPS)
        scenes_triangle(s, white, vec3_make(0, .5f, 0), vec3_make(.1f, .5f, 0),
                        vec3_make(0, .7f, .1f))
            ->emission = rgb_gray(.001f);
    if (room == BALLS) {
        scenes_sphere(s, scenes_glass(s, 1.5f), vec3_make(.4f, .4f, .3f), .35f);
        scenes_sphere(s, scenes_mirror(s, rgb_gray(.9f)), vec3_make(.3f, 1.2f, -.4f), .3f);
        s->scene.shapes[4].material = scenes_mirror(s, vec3_make(.5f, .8f, .6f));
    }
    if (room >= SHAPES)
        add_shapes(s);
    if (room == MANY)
        scenes_ball(s, white, vec3_make(0, 1.2f, 0), .25f, 12, .2f, false)->emission =
            rgb_gray(.5f);
    s->scene.settings.strategy = room == BSDF_ALONE    ? STRATEGY_BSDF
                                 : room == LIGHT_ALONE ? STRATEGY_LIGHT
                                                       : STRATEGY_MIS;
    if (room == ROUND_LAMP)
        scenes_sphere(s, white, vec3_make(.4f, 1.4f, .3f), .2f)->emission = vec3_make(1, 2, 6);
    scenes_sky(s, vec3_make(.2f, .3f, .5f));
}

static struct ray random_ray(struct dice *d)
{
    vec3 dir = {0}, origin = {0};
    for (int k = 0; k < 3; k++) {
        dir[k] = (float)dice_range(d, -1, 1);
        origin[k] = (float)dice_range(d, -.9, 1.5);
    }
    return (struct ray){origin, vec3_unit(dir), __builtin_inff(), 0, 0};
}

enum { OCTETS = 32, PATHS = OCTETS * WAVE_LANES };

struct lot { /* of paths that go through a wave together */
    const struct stage *stage;
    uint32_t roulette_begin;
    uint32_t which[OCTETS];
    struct ray rays[PATHS];
    struct rng rngs[PATHS];
    rgb radiance[PATHS];
    int other, lit, plain, diffuse, all;
    struct film_work together, alone;
};

static void go_together(struct lot *l, struct dice *d, uint32_t key)
{
    struct wave wave;
    wave_init(&wave, l->stage, l->roulette_begin, NULL, l->radiance);
    for (uint32_t n = 0; n < OCTETS; n++) {
        struct wave_starts starts;
        struct ray *rays = &l->rays[n * WAVE_LANES];
        struct rng *rngs = &l->rngs[n * WAVE_LANES];
        for (uint32_t i = 0; i < WAVE_LANES; i++) {
            rays[i] = random_ray(d);
            rngs[i] = rng_make(key, i, n, dice_bits(d) % 4096);
        }
        l->which[n] = n % 3 ? 0xff : 1 + dice_bits(d) % 0xff;
        wave_begin(l->stage, l->which[n], rays, rngs, &starts);
        wave_put(&wave, l->which[n], &starts, rngs, n * WAVE_LANES);
        l->plain += __builtin_popcount(starts.plain);
        l->diffuse += __builtin_popcount(starts.plain & starts.lanes.diffuse);
    }
    wave_finish(&wave);
    film_work_add(&l->together, &wave.work);
}

static void compare(struct lot *l)
{
    for (uint32_t i = 0; i < PATHS; i++) {
        if (!(l->which[i / WAVE_LANES] >> i % WAVE_LANES & 1))
            continue;
        const rgb one =
            radiance_alone(l->stage, l->rays[i], l->rngs[i], l->roulette_begin, &l->alone);
        l->other += memcmp(&one, &l->radiance[i], 3 * sizeof(float)) != 0;
        l->lit += !rgb_is_black(one);
        l->all++;
    }
}

static void paths_are_the_same(enum room room, const char *name)
{
    struct scenes s;
    build(&s, room);
    struct lot l = {.stage = scenes_stage(&s)};
    struct dice d = dice_make(room);
    for (uint32_t n = 0; n < 48; n++) {
        l.roulette_begin = n % 5 ? PATH_ROULETTE_BEGIN : UINT32_MAX;
        go_together(&l, &d, n);
        compare(&l);
    }
    const bool diffuse = room == BARE || room == LAMPS || room == ROUND_LAMP;
    ok(l.other == 0 && l.lit > l.all / 4 && l.diffuse > l.all / 4 &&
           (l.diffuse == l.plain) == diffuse,
       "%s: of %d paths in lanes %d differ from themselves alone (%d lit, %d begin in lanes, %d of "
       "these on diffuse surfaces)",
       name, l.all, l.other, l.lit, l.plain, l.diffuse);
    ok(l.together.bounce_rays == l.alone.bounce_rays &&
           l.together.shadow_rays == l.alone.shadow_rays,
       "%s: %lu and %lu rays, %lu and %lu of paths alone", name,
       (unsigned long)l.together.bounce_rays, (unsigned long)l.together.shadow_rays,
       (unsigned long)l.alone.bounce_rays, (unsigned long)l.alone.shadow_rays);
    ok(light8_can(l.stage) == (room < ROUND_LAMP) &&
           (l.stage->light_nodes.count > 0) == (room == MANY),
       "%s: its lights are in a %s", name,
       room == MANY        ? "tree"
       : room < ROUND_LAMP ? "table for lanes"
                           : "list");
    scenes_release(&s);
}

/* --- what no random number hits --- */

static const float odd[] = {
    0,  -0.f, 0x1p-149f, -0x1p-149f,       0x1p-126f,         1,
    -1, .5f,  -3e38f,    __builtin_inff(), -__builtin_inff(), __builtin_nanf("")};

static void odd_numbers_are_rounded_alike(void)
{
    int other = 0;
    for (size_t i = 0; i < countof(odd); i++)
        for (size_t k = 0; k < countof(odd); k++) {
            const f32x8 eight = surface8_round(f32x8_splat(odd[i]), f32x8_splat(odd[k]));
            const float one = round_along(vec3_splat(odd[i]), vec3_splat(odd[k]))[0];
            const float lane = eight[5];
            other += memcmp(&one, &lane, sizeof one) != 0;
        }
    ok(other == 0, "zeros, infinities and the least numbers are rounded as alone: %d differ",
       other);
}

static void squares_are_bent_alike(void)
{
    int other = 0;
    for (int i = 0; i < 16; i++)
        for (int k = 0; k < 16; k++) { /* the middle is among them */
            const struct square q = {(float)i / 16, (float)k / 16};
            const struct sobol8_square q8 = {f32x8_splat(q.u), f32x8_splat(q.v)};
            const struct vec8 c8 = warp8_cosine(q8);
            const struct sobol8_square t8 = warp8_triangle(q8);
            const vec3 c = warp_cosine(q), lane = vec8_lane(&c8, 3);
            const struct square t = warp_triangle(q);
            other += memcmp(&c, &lane, 3 * sizeof(float)) != 0 || t.u != t8.u[6] || t.v != t8.v[6];
        }
    ok(other == 0, "the square is bent as alone, its middle and its edges, too: %d differ", other);
}

int main(void)
{
    paths_are_the_same(BARE, "diffuse walls");
    paths_are_the_same(LAMPS, "seven lamps");
    paths_are_the_same(BALLS, "glass and mirrors");
    paths_are_the_same(ROUND_LAMP, "a round lamp");
    paths_are_the_same(SHAPES, "shapes and materials of many kinds");
    paths_are_the_same(MANY, "many lamps");
    paths_are_the_same(BSDF_ALONE, "light found by scattering alone");
    paths_are_the_same(LIGHT_ALONE, "light found by looking alone");
    odd_numbers_are_rounded_alike();
    squares_are_bent_alike();
    return tap_done();
}
