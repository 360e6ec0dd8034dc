/* SPDX-License-Identifier: MIT */
#include "common/trace/bvh_prim.h"

#include "common/trace/cylinder.h"

/* One box alone, by the test of eight. */
static bool box_alone(const struct box8_ray *r, vec3 lo, vec3 hi, float t[2])
{
    _Alignas(32) float plane[BOX8_PLANES][8] = {{0}};
    box8_store(plane, 0, lo, hi);
    f32x8 near, far;
    const uint32_t hits = box8_hit(r, (const float(*)[8])plane, FLT_MAX, &near, &far);
    t[0] = near[0];
    t[1] = far[0];
    return hits & 1;
}

/* The ray in object space has the same t. Its error: its own rounding, and what the primitives'
 * tests err by in world space, where they are made (box8.h; the vertices are rounded there, too),
 * seen from here. */
bool bvh_space_make(const struct bvh_query *q, const struct box8_ray *world, uint32_t instance,
                    struct bvh_space *space)
{
    const struct stage_instance *of = stage_instance_at(q->stage, instance);
    const vec3 lo = vec3_load(of->lo), hi = vec3_load(of->hi);
    if (!box_alone(world, lo, hi, space->t))
        return false;
    vec3 origin = {0}, dir = {0};
    for (int k = 0; k < 3; k++) {
        const double *m = of->to_object[k];
        double o = m[3], d = 0;
        for (int j = 0; j < 3; j++) {
            o += m[j] * (double)q->tri.ray->origin[j];
            d += m[j] * (double)q->tri.ray->dir[j];
        }
        origin[k] = (float)o;
        dir[k] = (float)d;
    }
    const float reach = box8_reach(vec3_max(vec3_abs(lo), vec3_abs(hi)));
    const float error = BOX8_PAD * (reach + box8_reach(q->tri.ray->origin));
    box8_ray_init(&space->box, origin, dir, box8_error(origin) + error * vec3_load(of->spread));
    space->instance = instance;
    space->prim_begin = of->prim_begin;
    return true;
}

/* A hit lies between where the ray enters the primitive's own box and where it leaves it. Rounding
 * could place it before, and then a tree that skips boxes behind the nearest hit would find one or
 * the other of two near hits as its shape has it; a grazing ray's, far beside the primitive. */
static float settle(const struct bvh_query *q, const float own[2], float t)
{
    const float in = t < own[0] ? own[0] : t > own[1] ? own[1] : t;
    return in > 0 && in < q->t_max ? in : 0;
}

float bvh_prim_settle(const struct bvh_query *q, vec3 lo, vec3 hi, float t)
{
    const struct box_ray box =
        box_ray_make(q->tri.ray->origin, q->tri.ray->dir, q->tri.row[2] / STAGE_LANES);
    float own[2];
    return box_hit(&box, lo, hi, own) ? settle(q, own, t) : 0;
}

/* In object space a triangle has its own box, too: the one that the nodes above are made of. */
static float settle_in_object(const struct bvh_query *q, const struct bvh_space *space,
                              uint32_t index, float t)
{
    const struct stage_triangle tri = stage_triangle_at(q->stage, index, STAGE_NONE);
    vec3 lo, hi;
    float own[2];
    tri_bounds(&tri, &lo, &hi);
    if (!box_alone(&space->box, lo, hi, own))
        return 0;
    own[0] = own[0] > space->t[0] ? own[0] : space->t[0];
    own[1] = own[1] < space->t[1] ? own[1] : space->t[1];
    return own[0] <= own[1] ? settle(q, own, t) : 0;
}

/* A copy's hit; and then in object space. */
float bvh_prim_in_instance(const struct bvh_query *q, const struct bvh_space *space, uint32_t index,
                           const struct stage_triangle *tri)
{
    const float t = bvh_prim_triangle(q, tri);
    return t > 0 ? settle_in_object(q, space, index, t) : 0;
}

/* In the box of a ball. */
static float settle_in_ball(const struct bvh_query *q, const float center[3], float radius, float t)
{
    vec3 lo, hi;
    sphere_bounds(center, radius, &lo, &hi);
    return settle_in_world(q, lo, hi, t);
}

static float settle_in_cylinder(const struct bvh_query *q, const struct stage_cylinder *c, float t)
{
    vec3 lo, hi;
    cylinder_bounds(c, &lo, &hi);
    return settle_in_world(q, lo, hi, t);
}

float bvh_prim_round(const struct bvh_query *q, struct stage_place place, uint32_t *prim)
{
    const struct ray *ray = q->tri.ray;
    const struct stage *s = q->stage;
    float t;
    switch ((enum stage_kind)place.kind) {
    case STAGE_SPHERE: {
        const struct stage_sphere *p =
            (const struct stage_sphere *)stage_at(s, s->spheres) + place.index;
        *prim = p->prim;
        return sphere_hit(ray, p, &t) ? settle_in_ball(q, p->center, p->radius, t) : 0;
    }
    case STAGE_DISC: {
        const struct stage_disc *p = (const struct stage_disc *)stage_at(s, s->discs) + place.index;
        *prim = p->prim;
        return sphere_disc_hit(ray, p, &t) ? settle_in_ball(q, p->center, p->radius, t) : 0;
    }
    case STAGE_CYLINDER: {
        const struct stage_cylinder *p =
            (const struct stage_cylinder *)stage_at(s, s->cylinders) + place.index;
        *prim = p->prim;
        return cylinder_hit(ray, p, &t) ? settle_in_cylinder(q, p, t) : 0;
    }
    case STAGE_TRIANGLE:
        break;
    }
    __builtin_unreachable();
}

bool bvh_hit_prim(const struct stage *s, const struct ray *ray, struct ray_hit *hit)
{
    struct bvh_query q;
    struct box8_ray world;
    struct bvh_space inner;
    if (!bvh_query_make(s, ray, &q, &world))
        return false;
    hit->u = hit->v = hit->t = 0;
    if (hit->place.kind != STAGE_TRIANGLE) {
        hit->t = bvh_prim_round(&q, hit->place, &hit->prim);
        return hit->t > 0;
    }
    if (hit->prim == ray->from - 1 || hit->prim == ray->to - 1)
        return false;
    const struct stage_triangle tri = stage_triangle_at(s, hit->place.index, hit->instance);
    const struct tri_edges e = tri_edges_make(&q.tri, &tri);
    if (!tri_meets(e))
        return false;
    tri_weights(e, &hit->u, &hit->v);
    if (hit->instance == STAGE_NONE)
        hit->t = bvh_prim_triangle(&q, &tri);
    else if (bvh_space_make(&q, &world, hit->instance, &inner))
        hit->t = bvh_prim_in_instance(&q, &inner, hit->place.index, &tri);
    return hit->t > 0;
}
