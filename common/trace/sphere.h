/* sphere.h - ray against sphere and disc: in double, because a sphere far away or far off needs it and
 * there are few of them.
 *
 * E. Haines et al., "Precision Improvements for Ray/Sphere Intersection", Ray Tracing Gems 7, 2019: the
 * discriminant from the perpendicular distance, the roots without cancellation.
 * SPDX-License-Identifier: MIT */
#ifndef COMMON_TRACE_SPHERE_H
#define COMMON_TRACE_SPHERE_H

#include "common/trace/ray.h"
#include "common/trace/stage.h"

static inline double sphere_dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* The ray's origin seen from the centre, and its direction. */
static inline void sphere_relative(const struct ray *r, const float center[3], double f[3],
                                   double d[3])
{
    for (int k = 0; k < 3; k++) {
        f[k] = (double)r->origin[k] - (double)center[k];
        d[k] = (double)r->dir[k];
    }
}

/* The smallest t > 0 where the ray meets the sphere, from outside or inside; 0: nowhere. Touching
 * counts. A NaN anywhere gives 0. */
static inline double sphere_t(const struct ray *r, const struct stage_sphere *s)
{
    double f[3], d[3], l[3];
    sphere_relative(r, s->center, f, d);
    const double radius = (double)s->radius;
    const double a = sphere_dot(d, d), b = -sphere_dot(f, d);
    for (int k = 0; k < 3; k++)
        l[k] = f[k] + b / a * d[k];
    const double discriminant = radius * radius - sphere_dot(l, l);
    if (!(discriminant >= 0))
        return 0;
    const double root = __builtin_sqrt(a * discriminant);
    const double q = b >= 0 ? b + root : b - root;
    const double c = sphere_dot(f, f) - radius * radius;
    /* q / a is the farther root when the centre is ahead, else both lie behind or c / q is ahead. */
    const double t0 = b >= 0 ? c / q : q / a, t1 = b >= 0 ? q / a : c / q;
    return t0 > 0 ? t0 : t1 > 0 ? t1 : 0;
}

/* The same for a disc; 0 for a ray in its plane. */
static inline double sphere_disc_t(const struct ray *r, const struct stage_disc *s)
{
    double f[3], d[3];
    sphere_relative(r, s->center, f, d);
    const double n[3] = {(double)s->normal[0], (double)s->normal[1], (double)s->normal[2]};
    const double t = -sphere_dot(n, f) / sphere_dot(n, d);
    for (int k = 0; k < 3; k++)
        f[k] += t * d[k];
    return t > 0 && sphere_dot(f, f) <= (double)s->radius * (double)s->radius ? t : 0;
}

#endif
