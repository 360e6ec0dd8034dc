/* sphere.h - ray against sphere and disc: in double, because a sphere far away or far off needs it
 * and there are few of them.
 *
 * E. Haines et al., "Precision Improvements for Ray/Sphere Intersection", Ray Tracing Gems 7, 2019:
 * the discriminant from the perpendicular distance, the roots without cancellation.
 * SPDX-License-Identifier: MIT */
#ifndef COMMON_TRACE_SPHERE_H
#define COMMON_TRACE_SPHERE_H

#include "common/trace/ray.h"
#include "common/trace/round.h"
#include "common/trace/stage.h"

static inline double sphere_dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static inline void sphere_relative(const struct ray *r, const float center[3], double f[3],
                                   double d[3])
{
    for (int k = 0; k < 3; k++) {
        f[k] = (double)r->origin[k] - (double)center[k];
        d[k] = (double)r->dir[k];
    }
}

/* Of a sphere, and of a disc of any direction; rounded outwards, so that what is inside stays
 * inside. */
static inline void sphere_bounds(const float center[3], float radius, vec3 *lo, vec3 *hi)
{
    const vec3 c = vec3_load(center), up = vec3_make(1, 1, 1);
    *lo = round_along(c - radius, -up);
    *hi = round_along(c + radius, up);
}

/* The nearest t > 0 from outside or inside. False for a NaN. */
static inline bool sphere_hit(const struct ray *r, const struct stage_sphere *s, float *t)
{
    double f[3], d[3], l[3];
    sphere_relative(r, s->center, f, d);
    const double radius = (double)s->radius;
    const double a = sphere_dot(d, d), b = -sphere_dot(f, d);
    for (int k = 0; k < 3; k++)
        l[k] = f[k] + b / a * d[k];
    const double discriminant = radius * radius - sphere_dot(l, l);
    if (!(discriminant >= 0))
        return false;
    const double root = __builtin_sqrt(a * discriminant);
    const double q = b >= 0 ? b + root : b - root;
    const double c = sphere_dot(f, f) - radius * radius;
    double t0 = c / q, t1 = q / a;
    if (t0 > t1) {
        const double swap = t0;
        t0 = t1;
        t1 = swap;
    }
    *t = (float)(t0 > 0 ? t0 : t1);
    return *t > 0;
}

static inline bool sphere_disc_hit(const struct ray *r, const struct stage_disc *s, float *t)
{
    double f[3], d[3];
    sphere_relative(r, s->center, f, d);
    const double n[3] = {(double)s->normal[0], (double)s->normal[1], (double)s->normal[2]};
    const double at = -sphere_dot(n, f) / sphere_dot(n, d);
    *t = (float)at;
    if (!(*t > 0))
        return false;
    for (int k = 0; k < 3; k++)
        f[k] += at * d[k];
    return sphere_dot(f, f) <= (double)s->radius * (double)s->radius;
}

#endif
