/* bvh_prim.h - a ray made ready, and what a hit on one primitive is: the part of the tests that
 * decides; what walks the hierarchy (bvh_hit.c) only must not lose any. Private to the two.
 * SPDX-License-Identifier: MIT */
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
    const struct stage_block *blocks;
    struct tri_ray tri;
    float inv_z; /* 1 / the ray's direction along the axis in which it is longest */
    float t_max; /* the ray's, finite */
};

/* The tree that is walked: the world's (instance STAGE_NONE) or an instance's in its space. */
struct bvh_space {
    struct box8_ray box;
    uint32_t instance;
    uint32_t prim_begin; /* what a block's numbers count from */
    float t[2];          /* where the ray enters and leaves the instance's box in the world */
};

/* False when nothing can be hit: a ray that is no ray. */
static inline bool bvh_query_make(const struct stage *s, const struct ray *ray, struct bvh_query *q)
{
    const vec3 o = ray->origin, d = ray->dir;
    const vec3 zero = (o - o) + (d - d); /* a NaN for an infinity, too */
    if ((i32x4_mask(zero == 0) & 7) != 7 || !(ray->t_max > 0))
        return false;
    q->stage = s;
    q->first = stage_at(s, s->nodes);
    q->blocks = stage_at(s, s->blocks);
    q->tri = tri_ray_make(o, d);
    q->inv_z = 1 / d[q->tri.kz];
    if (d[q->tri.kz] == 0)
        return false;
    q->t_max = ray->t_max < FLT_MAX ? ray->t_max : FLT_MAX;
    return true;
}

static inline void bvh_world_make(const struct bvh_query *q, struct bvh_space *w)
{
    const float longest = __builtin_fabsf(q->tri.dir[q->tri.kz]);
    box8_ray_init(&w->box, q->tri.origin, q->tri.dir, longest, box8_error(q->tri.origin));
    w->instance = STAGE_NONE;
    w->prim_begin = 0;
    w->t[0] = 0;
    w->t[1] = FLT_MAX;
}

/* --- one primitive --- */

/* False: the ray passes the instance's box. */
bool bvh_space_make(const struct bvh_query *, const struct bvh_space *world, uint32_t instance,
                    struct bvh_space *);

/* The t of a primitive of the world, as its own test has it, made a hit's; false: it is none. */
bool bvh_prim_settle(const struct bvh_query *, vec3 lo, vec3 hi, float *t);

/* A triangle of an instance, in world space, that the ray meets. */
bool bvh_prim_in_instance(const struct bvh_query *, const struct bvh_space *, uint32_t index,
                          const struct stage_triangle *, float *t);

/* Any other kind; *prim: its number. */
bool bvh_prim_round(const struct bvh_query *, struct stage_place, float *t, uint32_t *prim);

/* All but always the hit is well inside the box: with less room than box_hit gives on each side
 * (its error is 5 u of the reach and 5 u of the way), t is between its distances, and stays. */
static inline bool settle_in_world(const struct bvh_query *q, vec3 lo, vec3 hi, float *t)
{
    const vec3 a = lo - q->tri.origin, b = hi - q->tri.origin, way = *t * q->tri.dir;
    const vec3 room = 4 * ROUND_UNIT * vec3_max(vec3_abs(a), vec3_abs(b));
    const i32x4 inside = (way >= a - room) & (way <= b + room);
    if (__builtin_expect((i32x4_mask(inside) & 7) == 7, 1))
        return *t < q->t_max;
    return bvh_prim_settle(q, lo, hi, t);
}

/* Of a triangle that the ray meets (tri_meets), in world space. A NaN is a miss. */
static inline __attribute__((always_inline)) bool
bvh_prim_triangle(const struct bvh_query *q, const struct stage_triangle *tri, float *t)
{
    *t = tri_plane_t(&q->tri, tri);
    if (!(*t > 0))
        return false;
    vec3 lo, hi;
    tri_bounds(tri, &lo, &hi);
    return settle_in_world(q, lo, hi, t);
}

#endif
