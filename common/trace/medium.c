/* SPDX-License-Identifier: MIT */
#include "common/trace/medium.h"

#include "common/trace/bvh.h"
#include "common/trace/fmath.h"
#include "common/trace/surface.h"

static const struct material *material_at(const struct stage *s, uint32_t i)
{
    return (const struct material *)stage_at(s, s->materials) + i;
}

bool medium_is_body(const struct material *m)
{
    return m->kind == MATERIAL_DIELECTRIC;
}

static float ior_of(const struct material *m)
{
    return m->dielectric.ior;
}

uint32_t medium_uses(const struct scene *scene)
{
    uint32_t uses = 0;
    for (uint32_t i = 0; i < scene->material_count; i++) {
        const struct material *m = &scene->materials[i];
        if (!medium_is_body(m))
            continue;
        uses |= rgb_is_black(m->inside.absorption) ? 0 : MEDIUM_ABSORBS;
        uses |= m->inside.priority ? MEDIUM_ORDERED : 0;
    }
    return uses;
}

/* --- which body counts --- */

/* The place in the list of the body that fills space, STAGE_BODIES: none does. `but`: a place that
 * is passed over. */
static uint32_t innermost(const struct stage *s, const struct stage_bodies *b, uint32_t but)
{
    uint32_t best = STAGE_BODIES, most = 0;
    for (uint32_t i = 0; i < b->count; i++) {
        const uint32_t priority =
            s->media & MEDIUM_ORDERED ? material_at(s, b->material[i])->inside.priority : 0;
        if (i != but && (best == STAGE_BODIES || priority >= most)) {
            best = i;
            most = priority;
        }
    }
    return best;
}

/* The last entry of a material; STAGE_BODIES: none. */
static uint32_t find(const struct stage_bodies *b, uint32_t material)
{
    for (uint32_t i = b->count; i > 0; i--)
        if (b->material[i - 1] == material)
            return i - 1;
    return STAGE_BODIES;
}

static float ior_at(const struct stage *s, const struct stage_bodies *b, uint32_t place)
{
    return place == STAGE_BODIES ? 1 : ior_of(material_at(s, b->material[place]));
}

/* The list as it was before the ray left a body that is not in it: entered before all others. */
static struct stage_bodies as_if_inside(const struct stage_bodies *b, uint32_t material)
{
    struct stage_bodies all = {.count = 1, .material = {material}};
    for (uint32_t i = 0; i < b->count && all.count < STAGE_BODIES; i++)
        all.material[all.count++] = b->material[i];
    return all;
}

static bool leaves(const struct stage *s, const struct stage_bodies *b, uint32_t material,
                   float *ratio)
{
    const uint32_t place = find(b, material);
    if (place == STAGE_BODIES) {
        if (b->missed > 0 || b->count == STAGE_BODIES)
            return false;
        const struct stage_bodies all = as_if_inside(b, material);
        return leaves(s, &all, material, ratio);
    }
    if (innermost(s, b, STAGE_BODIES) != place)
        return false;
    *ratio = ior_of(material_at(s, material)) / ior_at(s, b, innermost(s, b, place));
    return true;
}

bool medium_meets(const struct stage *s, const struct stage_bodies *b, uint32_t material,
                  bool entering, float *ratio)
{
    const struct material *m = material_at(s, material);
    if (!(s->media & MEDIUM_ORDERED)) {
        *ratio = ior_of(m);
        return true;
    }
    if (!entering)
        return leaves(s, b, material, ratio);
    const uint32_t place = innermost(s, b, STAGE_BODIES);
    if (b->count == STAGE_BODIES ||
        (place != STAGE_BODIES &&
         material_at(s, b->material[place])->inside.priority > m->inside.priority))
        return false;
    *ratio = ior_of(m) / ior_at(s, b, place);
    return true;
}

void medium_cross(struct stage_bodies *b, uint32_t material, bool entering)
{
    if (entering) {
        if (b->count < STAGE_BODIES)
            b->material[b->count++] = material;
        else
            b->missed++;
        return;
    }
    const uint32_t place = find(b, material);
    if (place == STAGE_BODIES) {
        b->missed -= b->missed > 0;
        return;
    }
    b->count--;
    for (uint32_t i = place; i < b->count; i++)
        b->material[i] = b->material[i + 1];
}

/* --- what they do --- */

rgb medium_passed(const struct stage *s, const struct stage_bodies *b, float distance)
{
    const uint32_t place = innermost(s, b, STAGE_BODIES);
    if (place == STAGE_BODIES)
        return rgb_gray(1);
    const rgb absorption = material_at(s, b->material[place])->inside.absorption;
    float left[3];
    for (int c = 0; c < 3; c++) /* what absorbs nothing may be infinite */
        left[c] = absorption[c] > 0 ? fmath_exp(-absorption[c] * distance) : 1;
    return vec3_load(left);
}

struct stage_bodies medium_around(const struct stage *s, vec3 point)
{
    /* Along nothing that is likely to be built along. Of bodies, those that are left and were not
     * entered on the way contain the point, the innermost is left first. */
    const vec3 dir = vec3_unit(vec3_make(0.3571f, 0.8173f, 0.4519f));
    struct stage_bodies entered = {0}, around = {0};
    struct ray ray = {point, dir, __builtin_inff(), 0, 0};
    struct ray_hit hit;
    for (uint32_t n = 0; n < MEDIUM_MOST_HIDDEN && bvh_hit_closest(s, &ray, &hit); n++) {
        const struct surface at = surface_at(s, &ray, &hit);
        ray = surface_leave(&at, dir);
        if (!medium_is_body(material_at(s, at.material)))
            continue;
        const bool entering = vec3_dot(dir, at.ng) < 0;
        if (entering || find(&entered, at.material) != STAGE_BODIES)
            medium_cross(&entered, at.material, entering);
        else if (around.count < STAGE_BODIES)
            around = as_if_inside(&around, at.material);
    }
    return around;
}
