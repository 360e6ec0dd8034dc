/* bvh_prim.h - a ray made ready, and what a hit on one primitive is: the part of the tests that
 * decides; what walks the hierarchy (bvh_walk.h, bvh_batch.c) only must not lose any. Private to
 * these. SPDX-License-Identifier: MIT */
#ifndef COMMON_TRACE_BVH_PRIM_H
#define COMMON_TRACE_BVH_PRIM_H

#include "common/trace/bvh.h"

#include "common/trace/box.h"
#include "common/trace/box8.h"
#include "common/trace/tri.h"

/* What does not change along the way of one ray. */
struct bvh_query {
    const struct stage *stage;
    const unsigned char *first; /* node */
    struct tri_ray tri;
    float t_max; /* the ray's, finite */
};

/* The inside of an instance: its tree is walked in object space. */
struct bvh_space {
    struct box8_ray box;
    uint32_t instance;
    uint32_t prim_begin; /* what a block's numbers count from */
    float t[2];          /* where the ray enters and leaves the instance's box in the world */
};

/* Whether anything can be hit. */
static inline bool bvh_is_ray(const struct ray *ray)
{
    const vec3 o = ray->origin, d = ray->dir;
    const vec3 zero = (o - o) + (d - d); /* a NaN for an infinity, too */
    return (i32x4_mask(zero == 0) & 7) == 7 && ray->t_max > 0;
}

/* False when nothing can be hit. */
static inline bool bvh_query_make(const struct stage *s, const struct ray *ray, struct bvh_query *q,
                                  struct box8_ray *world)
{
    if (!bvh_is_ray(ray))
        return false;
    q->stage = s;
    q->first = stage_at(s, s->nodes);
    q->tri = tri_ray_make(ray);
    q->t_max = ray->t_max < FLT_MAX ? ray->t_max : FLT_MAX;
    box8_ray_init(world, ray->origin, ray->dir, box8_error(ray->origin));
    return q->tri.shear[2] == 1;
}

/* --- one primitive --- */

/* False: the ray passes the instance's box. */
bool bvh_space_make(const struct bvh_query *, const struct box8_ray *world, uint32_t instance,
                    struct bvh_space *);

/* From here on t is that of the hit, in (0, t_max), or 0: there is none. */

/* Of a primitive of the world, whose own test has found t. */
float bvh_prim_settle(const struct bvh_query *, vec3 lo, vec3 hi, float t);

/* Of a triangle of an instance, in world space, that the ray meets. */
float bvh_prim_in_instance(const struct bvh_query *, const struct bvh_space *, uint32_t index,
                           const struct stage_triangle *);

/* Of any other kind; *prim: its number. */
float bvh_prim_round(const struct bvh_query *, struct stage_place, uint32_t *prim);

/* All but always the hit is well inside the box: with less room than box_hit gives on each side
 * (its error is 5 u of the reach and 5 u of the way), t is between its distances, and stays. */
static inline float settle_in_world(const struct bvh_query *q, vec3 lo, vec3 hi, float t)
{
    const vec3 o = q->tri.ray->origin, a = lo - o, b = hi - o, way = t * q->tri.ray->dir;
    const vec3 room = 4 * ROUND_UNIT * vec3_max(vec3_abs(a), vec3_abs(b));
    const i32x4 inside = (way >= a - room) & (way <= b + room);
    if (__builtin_expect((i32x4_mask(inside) & 7) == 7, 1))
        return t < q->t_max ? t : 0;
    return bvh_prim_settle(q, lo, hi, t);
}

/* Of a triangle that the ray meets (tri_meets), in world space. */
static inline __attribute__((always_inline)) float
bvh_prim_triangle(const struct bvh_query *q, const struct stage_triangle *tri)
{
    const float t = tri_plane_t(&q->tri, tri);
    if (!(t > 0)) /* or a NaN */
        return 0;
    vec3 lo, hi;
    tri_bounds(tri, &lo, &hi);
    return settle_in_world(q, lo, hi, t);
}

#endif
