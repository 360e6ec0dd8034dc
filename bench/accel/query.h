/* query.h - what the structures share in finding a hit: the ray made ready, the triangle test.
 *
 * A triangle's hit is that of the core (bvh_hit.c): t by tri.h, moved into the interval in which
 * the ray is in the triangle's own box. So the point at t is near that box, up to roundings;
 * query.slack bounds them. A plane is met `slack` too early on the way in and too late on the way
 * out, hence a ray that hits a triangle at t is at t in every cell which holds that part of the
 * triangle's box, also on borders and along edges. A structure that visits all cells but those
 * which begin after the best hit finds exactly the hit.
 *
 * The bound: box.h widens by gamma(5) of the reach (largest distance from origin to box) along two
 * axes and the far distance by 2 gamma(3); a moved origin and its difference to a plane are three
 * more roundings of numbers up to the reach. gamma(24) of |origin| + |bounds| is beyond their sum.
 * SPDX-License-Identifier: MIT */
#ifndef BENCH_ACCEL_QUERY_H
#define BENCH_ACCEL_QUERY_H

#include <float.h>

#include "bench/accel/accel.h"
#include "common/trace/box.h"
#include "common/trace/tri.h"

struct query {
    const float (*v)[3][3];
    struct tri_ray tri;
    struct box_ray box;
    bool down[3];           /* the ray runs against the axis */
    float begin[3], end[3]; /* the origin, moved by the slack along the ray, against it */
    float slack;
    float t_max; /* the ray's, finite */
    struct ray_hit best;
};

static inline bool query_is_ray(const struct ray *r)
{
    float longest = 0;
    for (int k = 0; k < 3; k++) {
        const float d = __builtin_fabsf(r->dir[k]);
        if (!(__builtin_fabsf(r->origin[k]) <= FLT_MAX && d <= FLT_MAX))
            return false;
        longest = d > longest ? d : longest;
    }
    return longest > 0 && r->t_max > 0;
}

/* The largest coordinate, without its sign. */
static inline float query_extent(const struct accel_box *b)
{
    float most = 0;
    for (int k = 0; k < 3; k++) {
        const float lo = __builtin_fabsf(b->lo[k]), hi = __builtin_fabsf(b->hi[k]);
        most = lo > most ? lo : most;
        most = hi > most ? hi : most;
    }
    return most;
}

/* False when nothing can be hit. */
static inline bool query_make(struct query *q, struct accel_mesh mesh,
                              const struct accel_box *bounds, const struct ray *ray)
{
    if (!mesh.count || !query_is_ray(ray))
        return false;
    *q = (struct query){.v = mesh.v, .tri = tri_ray_make(ray)};
    q->box = box_ray_make(ray->origin, ray->dir, q->tri.row[2] / STAGE_LANES);
    q->t_max = ray->t_max < FLT_MAX ? ray->t_max : FLT_MAX;
    q->best = (struct ray_hit){.t = q->t_max, .prim = STAGE_NONE};
    const vec3 o = ray->origin;
    const struct accel_box at = {{o[0], o[1], o[2]}, {o[0], o[1], o[2]}};
    q->slack = round_gamma(24) * (query_extent(&at) + query_extent(bounds));
    for (int k = 0; k < 3; k++) {
        q->down[k] = q->box.inv[k] < 0;
        q->begin[k] = q->down[k] ? o[k] - q->slack : o[k] + q->slack;
        q->end[k] = q->down[k] ? o[k] + q->slack : o[k] - q->slack;
    }
    return true;
}

/* Keeps the nearer hit, among equals the one with the smaller number. */
static inline void query_triangle(struct query *q, uint32_t prim)
{
    struct stage_triangle tri;
    memcpy(&tri, q->v[prim], sizeof tri);
    const struct tri_edges e = tri_edges_make(&q->tri, &tri);
    if (!tri_meets(e))
        return;
    vec3 lo, hi;
    float own[2], t = tri_plane_t(&q->tri, &tri);
    tri_bounds(&tri, &lo, &hi);
    if (!(t > 0) || !box_hit(&q->box, lo, hi, own))
        return;
    t = t < own[0] ? own[0] : t > own[1] ? own[1] : t;
    if (!(t > 0) || t > q->best.t || (t == q->best.t && prim > q->best.prim))
        return;
    q->best = (struct ray_hit){.t = t, .prim = prim};
    tri_weights(e, &q->best.u, &q->best.v);
}

static inline void query_triangles(struct query *q, const uint32_t *prims, uint32_t count)
{
    for (uint32_t i = 0; i < count; i++)
        query_triangle(q, prims[i]);
}

static inline bool query_done(const struct query *q, struct ray_hit *hit)
{
    *hit = q->best;
    return q->best.prim != STAGE_NONE && q->best.t < q->t_max;
}

/* Where the ray meets a plane across axis k, at the earliest and at the latest. A NaN (0 *
 * infinity: the ray lies in the plane) says nothing; comparisons must keep what they have. */
static inline float query_earliest(const struct query *q, int k, float plane)
{
    return (plane - q->begin[k]) * q->box.inv[k];
}

static inline float query_latest(const struct query *q, int k, float plane)
{
    return (plane - q->end[k]) * q->box.inv[k];
}

/* t: where the ray is in the box, not beyond the best hit. */
static inline bool query_box(const struct query *q, const float lo[3], const float hi[3],
                             float t[2])
{
    float t0 = 0, t1 = q->best.t;
    for (int k = 0; k < 3; k++) {
        const float near = query_earliest(q, k, q->down[k] ? hi[k] : lo[k]);
        const float far = query_latest(q, k, q->down[k] ? lo[k] : hi[k]);
        t0 = near > t0 ? near : t0;
        t1 = far < t1 ? far : t1;
    }
    t[0] = t0;
    t[1] = t1;
    return t0 <= t1;
}

/* --- a node that waits while the ray is in its neighbour --- */

struct query_visit {
    uint32_t node;
    float begin, end; /* where the ray is in it */
};

/* Starts at the root. False when the ray misses everything. */
static inline bool query_enter(struct query *q, struct accel_mesh mesh,
                               const struct accel_box *bounds, const struct ray *ray,
                               struct query_visit *root)
{
    float t[2];
    if (!query_make(q, mesh, bounds, ray) || !query_box(q, bounds->lo, bounds->hi, t))
        return false;
    *root = (struct query_visit){0, t[0], t[1]};
    return true;
}

/* A plane cuts v into two children, first and first + 1, and is met between early and late. v
 * becomes the one the ray comes to first (first + 1 when it runs down), or the only one it meets;
 * if it meets both, the other goes on the stack. Returns the new top. */
static inline struct query_visit *query_cut(struct query_visit *v, struct query_visit *top,
                                            uint32_t first, bool down, float early, float late)
{
    const bool enters_near = !(late < v->begin), enters_far = !(early > v->end);
    if (enters_near && enters_far) {
        *top++ = (struct query_visit){first + !down, early > v->begin ? early : v->begin, v->end};
        v->end = late < v->end ? late : v->end;
    }
    v->node = first + (enters_near ? down : !down);
    return top;
}

#endif
