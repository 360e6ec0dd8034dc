/* The document's lights, and how often each emitter is picked.
 * SPDX-License-Identifier: MIT */
#include "common/trace/prep_plan.h"

#include <string.h>

#include "common/trace/fmath.h"
#include "common/trace/light8.h"

#define PI 3.14159265358979323846

/* Half the diagonal of everything: what a distant light shines on. */
static double scene_radius(const struct stage *head)
{
    double sum = 0;
    for (int k = 0; k < 3; k++) {
        const double side = (double)head->bounds[1][k] - (double)head->bounds[0][k];
        sum += side * side;
    }
    return __builtin_sqrt(sum) / 2;
}

/* 1 - cos angle = 2 sin^2 (angle / 2), which has all its digits. */
static float cap_of(float angle_rad)
{
    float s, c;
    fmath_sincos(angle_rad / 2, &s, &c);
    return 2 * s * s;
}

/* --- one emitter each; they return its power --- */

static double make_point(struct emitter *e, const struct light *l)
{
    *e = (struct emitter){.kind = EMITTER_POINT};
    vec3_store(e->radiance, l->point.intensity);
    memcpy(e->at, l->point.position, sizeof e->at);
    return 4 * PI * (double)rgb_luminance(l->point.intensity);
}

/* Between the angles the intensity falls by s^2 (3 - 2 s), s linear in the cosine: on the average
 * over solid angle a half. */
static double make_spot(struct prep_plan *p, struct emitter *e, const struct light *l)
{
    *e = (struct emitter){.kind = EMITTER_SPOT, .index = (uint32_t)p->head.spots.count++};
    struct stage_spot *spot = &p->spots[e->index];
    *spot =
        (struct stage_spot){.inner = cap_of(l->spot.inner_rad), .outer = cap_of(l->spot.outer_rad)};
    memcpy(spot->direction, l->spot.direction, sizeof spot->direction);
    vec3_store(e->radiance, l->spot.intensity);
    memcpy(e->at, l->spot.position, sizeof e->at);
    return PI * ((double)spot->inner + (double)spot->outer) *
           (double)rgb_luminance(l->spot.intensity);
}

static double make_distant(struct emitter *e, const struct light *l, double radius)
{
    *e = (struct emitter){.kind = EMITTER_DISTANT};
    vec3_store(e->radiance, l->distant.irradiance);
    memcpy(e->at, l->distant.direction, sizeof e->at);
    return PI * radius * radius * (double)rgb_luminance(l->distant.irradiance);
}

/* A disc of radiance L and angular radius a makes an irradiance of pi L sin^2 a. */
static double make_sun(struct emitter *e, const struct light *l, double radius)
{
    const float cap = cap_of(l->sun.radius_rad);
    const float projected = FMATH_PI * cap * (2 - cap);
    *e = (struct emitter){.kind = EMITTER_SUN, .cap = cap};
    const rgb radiance = l->sun.radiance + l->sun.irradiance / projected;
    vec3_store(e->radiance, radiance);
    memcpy(e->at, l->sun.direction, sizeof e->at);
    return PI * radius * radius * (double)(rgb_luminance(radiance) * projected);
}

/* --- their order --- */

enum rank { RANK_PLACE, RANK_FAR, RANK_BEYOND, RANK_NONE };

static enum rank rank_of(const struct scene *scene, const struct light *l)
{
    rgb pixel;
    switch (l->kind) {
    case LIGHT_POINT:
    case LIGHT_SPOT:
        return RANK_PLACE;
    case LIGHT_DISTANT:
        return RANK_FAR;
    case LIGHT_SUN:
        return RANK_BEYOND;
    case LIGHT_ENVIRONMENT:
        return prep_map_is_uniform(scene, l, &pixel) ? RANK_NONE : RANK_BEYOND;
    case LIGHT_SKY:
        return RANK_NONE;
    }
    __builtin_unreachable();
}

static double make_emitter(struct prep_plan *p, struct emitter *e, const struct light *l,
                           struct arena *scratch)
{
    const double radius = scene_radius(&p->head);
    switch (l->kind) {
    case LIGHT_POINT:
        return make_point(e, l);
    case LIGHT_SPOT:
        return make_spot(p, e, l);
    case LIGHT_DISTANT:
        return make_distant(e, l, radius);
    case LIGHT_SUN:
        return make_sun(e, l, radius);
    case LIGHT_ENVIRONMENT:
        return PI * radius * radius * prep_map_make(p, e, l, scratch);
    case LIGHT_SKY:
        break;
    }
    __builtin_unreachable();
}

static void add_lights(struct prep_plan *p, enum rank rank, struct arena *scratch)
{
    for (uint32_t i = 0; i < p->scene->light_count; i++) {
        const struct light *l = &p->scene->lights[i];
        if (rank_of(p->scene, l) != rank)
            continue;
        const uint64_t at = p->head.emitters.count++;
        p->power[at] = make_emitter(p, &p->emitters[at], l, scratch);
        p->emitters[at].prim = STAGE_NONE;
    }
}

/* The same radiance from everywhere. */
static void add_skies(struct prep_plan *p)
{
    for (uint32_t i = 0; i < p->scene->light_count; i++) {
        const struct light *l = &p->scene->lights[i];
        rgb pixel;
        if (l->kind == LIGHT_SKY)
            p->head.sky += l->sky.radiance;
        else if (l->kind == LIGHT_ENVIRONMENT && prep_map_is_uniform(p->scene, l, &pixel))
            p->head.sky += l->environment.scale * pixel;
    }
}

/* --- the table --- */

/* The table of floats has this many steps that are all exact. */
enum { PICK_STEPS = 1 << 24 };

/* Chosen in proportion to power; all alike when none has any. Every emitter gets a step of the
 * table, however weak it is: one that is never chosen would be missing, since nothing else finds a
 * point or a distant light. (More than 2^23 emitters are surfaces, which directions find, too.) */
static void pick_emitters(struct prep_plan *p)
{
    const uint64_t n = p->head.emitters.count;
    double total = 0, sum = 0;
    for (uint64_t i = 0; i < n; i++)
        total += p->power[i];
    const bool usable = total > 0 && total - total == 0;
    const uint64_t reserved = n <= PICK_STEPS / 2 ? 1 : 0;
    for (uint64_t i = 0; i < n; i++) {
        sum += usable ? p->power[i] / total : 1 / (double)n;
        const double share = (double)(PICK_STEPS - reserved * n) * (sum < 1 ? sum : 1);
        const uint64_t steps = i + 1 < n ? (uint64_t)share + reserved * (i + 1) : PICK_STEPS;
        p->pick_cdf[i + 1] = (float)steps / (float)PICK_STEPS;
        p->emitters[i].pick = p->pick_cdf[i + 1] - p->pick_cdf[i];
    }
}

/* From so many emitters on that have a place, one is picked by the tree (docs/design.md). */
enum { TREE_FROM = 512 };

static bool fit_lanes(const struct prep_plan *p)
{
    return p->head.settings.strategy == STRATEGY_MIS && /* lanes know no other */
           light8_fit(p->emitters, p->head.emitters.count);
}

void prep_lights(struct prep_plan *p, struct arena *scratch)
{
    add_skies(p);
    prep_map_open(p, scratch);
    add_lights(p, RANK_PLACE, scratch);
    p->head.far_begin = (uint32_t)p->head.emitters.count;
    add_lights(p, RANK_FAR, scratch);
    p->head.beyond_begin = (uint32_t)p->head.emitters.count;
    add_lights(p, RANK_BEYOND, scratch);
    pick_emitters(p);
    p->head.lamps.count = fit_lanes(p);
    if (p->head.far_begin >= TREE_FROM && !p->head.lamps.count)
        prep_light_tree(p, scene_radius(&p->head), scratch);
}
