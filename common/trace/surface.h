/* surface.h - a hit -> the surface point, with bounds on its rounding error, and rays that
 * leave it without meeting it again.
 *
 * No epsilon: every point carries a bound on the absolute error of its coordinates, derived
 * from the arithmetic that made it (M. Pharr, W. Jakob, G. Humphreys, "Physically Based
 * Rendering", 4th ed., section 6.8). A new ray starts just outside that box, on the side of the
 * geometric normal it leaves to.
 * SPDX-License-Identifier: MIT */
#ifndef COMMON_TRACE_SURFACE_H
#define COMMON_TRACE_SURFACE_H

#include "common/trace/ray.h"
#include "common/trace/round.h"
#include "common/trace/stage.h"

struct surface {
    vec3 p;       /* on the primitive */
    vec3 p_error; /* |true - p| <= p_error, per coordinate */
    vec3 ng;      /* unit geometric normal of the front side (not flipped to the viewer) */
    uint32_t prim;
    uint32_t material;
    uint32_t emitter; /* or STAGE_NONE */
    float lit;        /* from where light counts: 1 from the front alone, -1 from the back, 0 from
                       * both. For who knows the material to set; 0 till then */
};

/* The very ray that was traced: what is met is computed from it anew where t is not exact enough. A
 * point all but on an edge of a triangle is moved off it, by no more than its error (surface.c).
 */
struct surface surface_at(const struct stage *, const struct ray *, const struct ray_hit *);

/* Of a triangle, so near that it has to be looked at more closely: surface_at does. */
static inline bool surface_is_near_edge(const struct ray_hit *hit)
{
    const float near = 0x1p-12f;
    return hit->u < near || hit->v < near || 1 - hit->u - hit->v < near;
}

/* The same for who knows the shape: material and emitter are STAGE_NONE. */
struct surface surface_point_at(const struct stage *, const struct ray *, const struct ray_hit *);

/* A point chosen on a primitive by light sampling, with the same guarantees. What shape it is of is
 * not looked up: material and emitter are STAGE_NONE. */
struct surface surface_on_triangle(const struct stage *, struct stage_id, float u, float v);
struct surface surface_on_sphere(const struct stage *, struct stage_id, vec3 outward_unit);
struct surface surface_on_disc(const struct stage *, struct stage_id, vec3 p);
/* along: 0 at the first end, 1 at the other; outward: at right angles to the axis or nearly so. */
struct surface surface_on_cylinder(const struct stage *, struct stage_id, float along,
                                   vec3 outward);

/* s.p moved along ng, to the side of dir, until the box of its error is left behind (PBRT 4,
 * section 6.8.6); rounded outwards. */
static inline vec3 surface_outside(const struct surface *s, vec3 p_error, vec3 dir)
{
    const float distance = vec3_dot(vec3_abs(s->ng), p_error);
    const vec3 offset = s->ng * (vec3_dot(dir, s->ng) < 0 ? -distance : distance);
    return round_along(s->p + offset, offset);
}

/* The ray from s along dir, t_max infinite. */
static inline struct ray surface_leave(const struct surface *s, vec3 dir)
{
    return (struct ray){surface_outside(s, s->p_error, dir), dir, __builtin_inff(), s->prim + 1, 0};
}

/* Segments for any-hit tests, dir not unit, t_max 1: they end just before `to`, so that the
 * surface `to` lies on does not shadow itself, and neither does a neighbour in its plane.
 *
 * A segment's direction is rounded, so that its end lies up to gamma(1) |d| beside the target; t of
 * the target's own surface is rounded to float, and a hit may be moved to where the ray enters the
 * primitive's box, by gamma(3) at most. All are lengths along the segment. */
static inline struct ray surface_to_surface(const struct surface *from, const struct surface *to)
{
    const vec3 way = to->p - from->p;
    const vec3 origin = surface_outside(from, from->p_error, way);
    const float blur = round_gamma(6) * vec3_length(way);
    const vec3 target = surface_outside(to, to->p_error + vec3_make(blur, blur, blur), -way);
    return (struct ray){origin, target - origin, 1, from->prim + 1, to->prim + 1};
}

static inline struct ray surface_to_point(const struct surface *from, vec3 to)
{
    const vec3 origin = surface_outside(from, from->p_error, to - from->p);
    return (struct ray){origin, to - origin, 1, from->prim + 1, 0};
}

#endif
