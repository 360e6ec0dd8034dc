/* light_tree.h, and F-31 of docs/accuracy.md: many lights are chosen as often as is said, all that
 * send light are chosen, and never worse than by power or all alike.
 * SPDX-License-Identifier: MIT */
#include "common/trace/light_tree.h"

#include <math.h>

#include "common/trace/bvh.h"
#include "common/trace/light.h"
#include "tests/catalog.h"
#include "tests/dice.h"
#include "tests/naive_path.h"
#include "tests/stat/chi2.h"
#include "tests/stat/means.h"
#include "tests/swarm.h"
#include "tests/tap.h"

static struct light_tree_pick pick(const struct stage *s, const struct surface *from, double u)
{
    struct light_tree_pick found;
    light_tree_pick(s, &from, &u, 1, &found);
    return found;
}

/* --- F-31 --- */

static void judge_swarm(uint32_t count, bool occluded)
{
    struct swarm w;
    const float x[] = {0, .1f, -.15f};
    double mass_off = 0, power = 0, uniform = 0, ours = 0;
    uint32_t missed = 0;
    bool better = true;
    swarm_init(&w, count, occluded, count + occluded);
    for (size_t i = 0; i < countof(x); i++) {
        const struct surface from = swarm_point(&w, vec3_make(x[i], 0, .3f * x[i]));
        const struct swarm_law law = swarm_law(&w, &from);
        mass_off = fmax(mass_off, fabs(law.mass - 1));
        missed += law.missed;
        better &= law.ours <= law.power && law.ours <= law.uniform;
        ours += law.ours / 3;
        power += law.power / 3;
        uniform += law.uniform / 3;
    }
    ok(mass_off < 1e-5 && missed == 0,
       "F-31: %u lights%s: probabilities sum to 1 (%.0e off), %u missed", count,
       occluded ? ", occluded" : "", mass_off, missed);
    ok(better, "F-31: %u lights%s: relative variance %.2f, by power %.2f, all alike %.2f", count,
       occluded ? ", occluded" : "", ours, power, uniform);
    swarm_release(&w);
}

/* Beside the sum over all lights, in double. */
static void mean_is_the_sum(uint32_t count)
{
    struct swarm w;
    struct stat_mean mean = {0};
    struct dice dice = dice_make(7);
    swarm_init(&w, count, true, 5);
    const struct surface from = swarm_point(&w, vec3_make(.1f, 0, 0));
    const double truth = swarm_law(&w, &from).irradiance;
    const uint32_t n = stat_tries(400000, 4000000);
    for (uint32_t i = 0; i < n; i++) {
        struct light_sample light;
        const struct sobol_bits bits = {dice_bits(&dice), dice_bits(&dice)};
        double e = 0;
        if (light_sample(w.stage, &from, bits, &light) && light.wi[1] > 0 &&
            !bvh_hit_any(w.stage, &light.shadow))
            e = (double)light.value[0] * (double)light.wi[1];
        stat_add(&mean, e);
    }
    const struct means m = means_from_truth(&mean, truth);
    ok(means_p(&m) > 0.01, "F-31: %u lights: %.5g is %.5g (p %.2f, detects %.2f %%)", count, truth,
       mean.mean, means_p(&m), 100 * means_detects(&m, 0.01) / truth);
    swarm_release(&w);
}

/* --- all kinds of lights, anywhere --- */

enum { KINDS = 7, MIXED = 100 * KINDS };

static vec3 anywhere(struct dice *dice, double reach)
{
    const double x = dice_range(dice, -reach, reach), y = dice_range(dice, -reach, reach);
    return vec3_make((float)x, (float)y, (float)dice_range(dice, -reach, reach));
}

static vec3 any_direction(struct dice *dice)
{
    for (;;) {
        const vec3 v = anywhere(dice, 1);
        if (vec3_dot(v, v) > .01f && vec3_dot(v, v) < 1)
            return vec3_unit(v);
    }
}

static void add_mixed(struct scenes *s, uint32_t black, int kind, struct dice *dice)
{
    const vec3 at = anywhere(dice, 3), n = any_direction(dice);
    const rgb bright = rgb_gray((float)pow(10, dice_range(dice, -2, 2)));
    const float size = (float)dice_range(dice, .01, .1);
    struct light *l;
    switch (kind) {
    case 0:
        scenes_sphere(s, black, at, size)->emission = bright;
        return;
    case 1:
        scenes_disc(s, black, at, n, size)->emission = bright;
        return;
    case 2:
        scenes_cylinder(s, black, at, at + size * n, .3f * size)->emission = bright;
        return;
    case 3:
        l = &s->scene.lights[s->scene.light_count++];
        *l = (struct light){.kind = LIGHT_SPOT};
        vec3_store(l->spot.position, at);
        vec3_store(l->spot.direction, n);
        l->spot.intensity = bright;
        l->spot.outer_rad = (float)dice_range(dice, .01, 3);
        return;
    case 4:
        l = &s->scene.lights[s->scene.light_count++];
        *l = (struct light){.kind = LIGHT_POINT};
        vec3_store(l->point.position, at);
        l->point.intensity = bright;
        return;
    default: /* a mesh's triangles come together */
        return;
    }
}

/* Triangles, spheres, discs, cylinders, spots and points, and a sun besides. */
static const struct stage *make_mixed(struct scenes *s, uint64_t seed)
{
    struct dice dice = dice_make(seed);
    scenes_init(s, 1, 1);
    s->scene.shapes = arena_new(&s->arena, struct shape, MIXED);
    s->scene.lights = arena_new(&s->arena, struct light, MIXED);
    const uint32_t black = scenes_diffuse(s, rgb_gray(0));
    for (int i = 0; i < MIXED; i++)
        if (i % KINDS < 5 && s->scene.shape_count < SCENES_MAX_SHAPES - 1)
            add_mixed(s, black, i % KINDS, &dice);
    const uint32_t triangles = 300;
    const struct scenes_mesh m = scenes_mesh(s, black, 3 * triangles, triangles);
    for (uint32_t i = 0; i < 3 * triangles; i++) {
        const vec3 to = i % 3 ? vec3_load(m.vertices[i / 3 * 3]) : anywhere(&dice, 3);
        vec3_store(m.vertices[i], to + (i % 3 ? anywhere(&dice, .1) : vec3_make(0, 0, 0)));
        m.triangles[i / 3][i % 3] = i;
    }
    m.shape->emission = rgb_gray(3);
    struct light *sun = &s->scene.lights[s->scene.light_count++];
    *sun = (struct light){.kind = LIGHT_SUN};
    sun->sun.direction[1] = -1;
    sun->sun.radius_rad = .1f;
    sun->sun.radiance = rgb_gray(10);
    return scenes_stage(s);
}

static struct surface any_receiver(struct dice *dice)
{
    static const float lit[] = {1, -1, 0};
    return (struct surface){.p = anywhere(dice, 3.5),
                            .ng = any_direction(dice),
                            .prim = STAGE_NONE,
                            .lit = lit[dice_bits(dice) % 3]};
}

static void picks_follow(void)
{
    struct scenes s;
    struct dice dice = dice_make(11);
    const struct stage *stage = make_mixed(&s, 1);
    const uint32_t lights = stage->far_begin, n = max_u32(stat_tries(100000, 1000000), 50000);
    double *due = arena_new(&s.arena, double, lights), worst = 1, off = 0, mass = 0;
    uint32_t *seen = arena_new(&s.arena, uint32_t, lights), bad_rest = 0;
    enum { POINTS = 6 };
    ok(stage->light_nodes.count > 0 && lights > 512, "%u lights of all kinds make a tree", lights);
    for (int k = 0; k < POINTS; k++) {
        const struct surface from = any_receiver(&dice);
        double sum = 0;
        for (uint32_t i = 0; i < lights; i++) {
            const double p = light_tree_probability(stage, &from, i);
            due[i] = p * n;
            sum += p;
            seen[i] = 0;
        }
        mass = fmax(mass, fabs(sum - 1));
        for (uint32_t i = 0; i < n; i++) {
            const struct light_tree_pick found = pick(stage, &from, dice_unit(&dice));
            seen[found.emitter]++;
            off = fmax(off, fabs(found.probability * n / due[found.emitter] - 1));
            bad_rest += !(found.rest >= 0 && found.rest < 1);
        }
        worst = fmin(worst, chi2_test(due, seen, lights).p);
    }
    ok(mass < 1e-12, "from anywhere their probabilities sum to 1 (%.0e off)", mass);
    ok(worst > stat_sidak(.01, POINTS), "they are picked as often (p %.3f)", worst);
    ok(off < 1e-9 && bad_rest == 0, "the probability picked is the one asked (%.0e)", off);
    scenes_release(&s);
}

/* The square's u lies in u's part, at `rest` of it: how often rest < 1/2 is a half. */
static void rest_is_uniform(void)
{
    struct scenes s;
    struct dice dice = dice_make(12);
    const struct stage *stage = make_mixed(&s, 2);
    const struct surface from = any_receiver(&dice);
    struct stat_mean low = {0}, square = {0};
    for (int i = 0; i < 100000; i++) {
        const double rest = pick(stage, &from, dice_unit(&dice)).rest;
        stat_add(&low, rest);
        stat_add(&square, rest * rest);
    }
    ok(fabs(low.mean - .5) < 4 * stat_error(&low) &&
           fabs(square.mean - 1 / 3.) < 4 * stat_error(&square),
       "what is left of the number is uniform");
    scenes_release(&s);
}

/* Sends one of the points of an emitter, at weights of the square, light to the receiver? */
static bool sends(const struct stage *s, const struct emitter *e, const struct surface *from,
                  struct dice *dice)
{
    vec3 at = vec3_load(e->at), n = {0};
    const struct stage_id id = {e->prim, e->place, STAGE_NONE};
    if (e->kind == EMITTER_PRIM) {
        const vec3 w = any_direction(dice);
        const float u = dice_float(dice), v = dice_float(dice) * (1 - u);
        struct surface on;
        if (id.place.kind == STAGE_TRIANGLE)
            on = surface_on_triangle(s, id, u, v);
        else if (id.place.kind == STAGE_SPHERE)
            on = surface_on_sphere(s, id, w);
        else if (id.place.kind == STAGE_CYLINDER)
            on = surface_on_cylinder(s, id, u, w);
        else
            on = surface_on_disc(
                s, id,
                vec3_load(
                    ((const struct stage_disc *)stage_at(s, s->discs))[id.place.index].center));
        at = on.p;
        n = on.ng;
    }
    const vec3 d = at - from->p;
    const float height = vec3_dot(d, from->ng);
    if (height * from->lit < 0 || height == 0)
        return false;
    if (e->kind == EMITTER_SPOT) {
        const struct stage_spot *spot = (const struct stage_spot *)stage_at(s, s->spots) + e->index;
        const vec3 off = -vec3_unit(d) - vec3_load(spot->direction);
        return vec3_dot(off, off) < 2 * spot->outer;
    }
    return e->kind == EMITTER_POINT || vec3_dot(d, n) < 0;
}

static void support_is_complete(void)
{
    struct scenes s;
    struct dice dice = dice_make(13);
    const struct stage *stage = make_mixed(&s, 3);
    const struct emitter *emitters = stage_at(stage, stage->emitters);
    const uint32_t points = stat_tries(300, 10000);
    uint64_t missed = 0, sent = 0, spared = 0;
    for (uint32_t k = 0; k < points; k++) {
        struct surface from = any_receiver(&dice);
        if (k % 2) /* the horizon goes through a light */
            from.p = vec3_load(emitters[stage->far_begin - 1 - dice_bits(&dice) % 100].at);
        for (uint32_t i = 0; i < stage->far_begin; i++) {
            const bool chosen = light_tree_probability(stage, &from, i) > 0;
            const bool shines = sends(stage, &emitters[i], &from, &dice);
            missed += shines && !chosen;
            sent += shines;
            spared += !chosen;
        }
    }
    ok(missed == 0 && sent > 0, "whatever sends light has a chance: %lu lights, from %u points",
       (unsigned long)sent, points);
    ok(spared > sent / 100, "what is behind and what turns its back has none (%lu)",
       (unsigned long)spared);
    scenes_release(&s);
}

/* --- whole paths --- */

/* A floor, and a pane of ground glass with lamps on both sides: beside the oracle, which samples
 * directions alone. */
static void paths_agree(void)
{
    struct scenes s;
    struct dice dice = dice_make(14);
    scenes_init(&s, 8, 8);
    scenes_look(&s, vec3_make(0, .5f, 3), vec3_make(0, .2f, 0), .5);
    s.scene.settings.max_bounces = 4;
    const uint32_t black = scenes_diffuse(&s, rgb_gray(0)), glass = scenes_glass(&s, 1.5f);
    s.scene.materials[glass].dielectric.alpha = .4f;
    scenes_quad(&s, scenes_diffuse(&s, rgb_gray(.6f)), vec3_make(-3, -.5f, 3), vec3_make(6, 0, 0),
                vec3_make(0, 0, -6));
    scenes_quad(&s, glass, vec3_make(-1, -.5f, 0), vec3_make(2, 0, 0), vec3_make(0, 2, 0));
    const uint32_t lamps = 600;
    const struct scenes_mesh m = scenes_mesh(&s, black, 3 * lamps, lamps);
    for (uint32_t i = 0; i < lamps; i++) {
        const vec3 at = vec3_make((float)dice_range(&dice, -2, 2), (float)dice_range(&dice, 1, 2),
                                  (float)dice_range(&dice, -2, 2));
        const vec3 corner[3] = {at, at + vec3_make(.5f, 0, .1f), at + vec3_make(0, .1f, .6f)};
        for (uint32_t k = 0; k < 3; k++) {
            vec3_store(m.vertices[3 * i + k], corner[k]);
            m.triangles[i][k] = 3 * i + k;
        }
    }
    m.shape->emission = rgb_gray(2);
    const struct stage *stage = scenes_stage(&s);
    struct film film;
    scenes_render(stage, stat_tries(1024, 8192), &film);
    const struct scenes_mean ours = scenes_mean(&film, 1);
    const struct stat_mean naive = naive_path_mean(stage, stat_tries(600000, 6000000), 5);
    const double error = hypot(ours.error, stat_error(&naive));
    ok(fabs(ours.mean - naive.mean) < 3.9 * error && stage->light_nodes.count > 0,
       "600 lamps on both sides of ground glass: %.5f is %.5f by directions alone (detects %.2f "
       "%%)",
       ours.mean, naive.mean, 623 * error / naive.mean);
    film_release(&film);
    scenes_release(&s);
}

/* --- what can go wrong --- */

static struct scenes points_of(uint32_t count, vec3 (*at)(uint32_t), float (*intensity)(uint32_t))
{
    struct scenes s;
    scenes_init(&s, 1, 1);
    scenes_disc(&s, scenes_diffuse(&s, rgb_gray(1)), vec3_make(0, 0, 0), vec3_make(0, 1, 0), 1);
    s.scene.lights = arena_new(&s.arena, struct light, count);
    s.scene.light_count = count;
    for (uint32_t i = 0; i < count; i++) {
        s.scene.lights[i].kind = LIGHT_POINT;
        s.scene.lights[i].point.intensity = rgb_gray(intensity(i));
        vec3_store(s.scene.lights[i].point.position, at(i));
    }
    return s;
}

static vec3 at_one_place(uint32_t i)
{
    return vec3_make(0, 1, 0) + 0 * (float)i;
}

static vec3 nearer_and_nearer(uint32_t i)
{
    return vec3_make(0, ldexpf(1, 59 - (int)(i % 120)), 0);
}

static vec3 far_apart(uint32_t i)
{
    return vec3_make(i & 1 ? 1e18f : -1e18f, i & 2 ? 1e18f : 1e-18f, i & 4 ? 1e18f : 0);
}

static float one(uint32_t i)
{
    return i < UINT32_MAX ? 1 : 0;
}

static float none(uint32_t i)
{
    return i < UINT32_MAX ? 0 : 1;
}

static float of_all_sizes(uint32_t i)
{
    return powf(10, (float)(i % 36) - 18);
}

static void judge_points(struct scenes s, const char *name)
{
    const struct stage *stage = scenes_stage(&s);
    const struct surface from = {.p = vec3_make(.25f, 0, 0), .ng = vec3_make(0, 1, 0), .lit = 1};
    const uint32_t *parents = stage_at(stage, stage->light_parents);
    const struct emitter *emitters = stage_at(stage, stage->emitters);
    uint32_t deepest = 0, never = 0;
    double mass = 0;
    for (uint32_t i = 0; i < stage->far_begin; i++) {
        const double p = light_tree_probability(stage, &from, i);
        uint32_t depth = 0;
        for (uint32_t slot = emitters[i].slot; slot != STAGE_NONE;
             slot = parents[slot / STAGE_LANES])
            depth++;
        deepest = depth > deepest ? depth : deepest;
        never += !(p > 0);
        mass += p;
    }
    ok(fabs(mass - 1) < 1e-9 && never == 0 && deepest <= LIGHT_TREE_DEPTH,
       "%s: probabilities sum to 1 (%.0e off), none is 0, %u levels", name, fabs(mass - 1),
       deepest);
    scenes_release(&s);
}

static void odd_places(void)
{
    judge_points(points_of(1000, at_one_place, one), "1000 lights at one place");
    judge_points(points_of(1000, at_one_place, none), "1000 lights that do not shine");
    judge_points(points_of(1200, nearer_and_nearer, one), "lights from 2^59 m down to 2^-60 m");
    judge_points(points_of(600, far_apart, of_all_sizes), "the farthest lights, of all sizes");

    struct scenes s = points_of(1000, at_one_place, one);
    const struct stage *stage = scenes_stage(&s);
    const struct surface *from =
        &(struct surface){.p = vec3_make(0, 1, 0), .ng = vec3_make(0, 1, 0)};
    struct light_sample light;
    ok(pick(stage, from, .5).emitter < 1000 &&
           !light_sample(stage, from, (struct sobol_bits){1u << 31, 0}, &light),
       "from where a light is, one is picked and sends nothing");
    const struct surface under = {.p = vec3_make(0, 2, 0), .ng = vec3_make(0, 1, 0), .lit = 1};
    ok(pick(stage, &under, .5).emitter == STAGE_NONE &&
           !light_sample(stage, &under, (struct sobol_bits){1u << 31, 0}, &light) &&
           light_tree_probability(stage, &under, 0) == 0,
       "where all lights are behind the surface, none is picked");
    scenes_release(&s);
}

/* Eight walks side by side are eight walks. */
static void walks_are_their_own(void)
{
    struct scenes s;
    struct dice dice = dice_make(15);
    const struct stage *stage = make_mixed(&s, 4);
    int bad = 0;
    for (int i = 0; i < 1000; i++) {
        struct surface at[LIGHT_TREE_WALKS];
        const struct surface *from[LIGHT_TREE_WALKS];
        uint32_t bits[LIGHT_TREE_WALKS];
        struct light_pick all[LIGHT_TREE_WALKS], one_alone;
        for (int k = 0; k < LIGHT_TREE_WALKS; k++) {
            at[k] = any_receiver(&dice);
            from[k] = &at[k];
            bits[k] = dice_bits(&dice);
        }
        light_pick(stage, from, bits, LIGHT_TREE_WALKS, all);
        for (int k = 0; k < LIGHT_TREE_WALKS; k++) {
            light_pick(stage, &from[k], &bits[k], 1, &one_alone);
            bad += !(one_alone.emitter == all[k].emitter && one_alone.rest == all[k].rest &&
                     one_alone.probability == all[k].probability);
        }
    }
    ok(bad == 0, "walks side by side find what each finds alone");
    scenes_release(&s);
}

int main(void)
{
    static const uint32_t quick[] = {1000, 10000}, whole[] = {512, 1000, 10000, 100000, 1000000};
    const bool all = stat_is_long() && STAT_SLOW == 1;
    for (size_t i = 0; i < (all ? countof(whole) : countof(quick)); i++)
        for (int occluded = 0; occluded < 2; occluded++)
            judge_swarm(all ? whole[i] : quick[i], occluded);
    mean_is_the_sum(1000);
    mean_is_the_sum(10000);
    picks_follow();
    rest_is_uniform();
    support_is_complete();
    paths_agree();
    odd_places();
    walks_are_their_own();
    return tap_done();
}
