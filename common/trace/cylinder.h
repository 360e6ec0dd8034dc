/* cylinder.h - ray against the side of a cylinder, open at both ends: in double, as in sphere.h and
 * for its reasons.
 *
 * a is the axis, f leads from its first end to the ray's origin, d is the ray's direction. n = d x
 * a and m = f x a are what of d and f lies across the axis, turned by a right angle and |a| times
 * as long; the ray passes the axis at the distance |f . n| / |n|. A ray nearly along the axis keeps
 * its digits, for products of two floats are exact in double. The discriminant comes from that
 * distance and the roots without cancellation, as in sphere.h.
 * SPDX-License-Identifier: MIT */
#ifndef COMMON_TRACE_CYLINDER_H
#define COMMON_TRACE_CYLINDER_H

#include "common/trace/sphere.h"

static inline void cylinder_axis(const struct stage_cylinder *c, double a[3])
{
    for (int k = 0; k < 3; k++)
        a[k] = (double)c->axis[k];
}

static inline void cylinder_cross(const double a[3], const double b[3], double out[3])
{
    for (int k = 0; k < 3; k++) {
        const int i = (k + 1) % 3, j = (k + 2) % 3;
        out[k] = a[i] * b[j] - a[j] * b[i];
    }
}

static inline double cylinder_area(const struct stage_cylinder *c)
{
    double a[3];
    cylinder_axis(c, a);
    return 2 * 3.14159265358979323846 * (double)c->radius * __builtin_sqrt(sphere_dot(a, a));
}

/* The two rims are circles, which reach radius sin(axis, k) along k. Rounded outwards, so that what
 * is inside stays inside: by what the sums in double may be off, where their terms cancel, and on
 * the way to float. */
static inline void cylinder_bounds(const struct stage_cylinder *c, vec3 *lo, vec3 *hi)
{
    *lo = *hi = vec3_make(0, 0, 0);
    double a[3];
    cylinder_axis(c, a);
    const double aa = sphere_dot(a, a), radius = (double)c->radius;
    for (int k = 0; k < 3; k++) {
        const double i = a[(k + 1) % 3], j = a[(k + 2) % 3];
        const double reach = radius * __builtin_sqrt((i * i + j * j) / aa);
        const double at = (double)c->from[k];
        const double slack = 0x1p-50 * (__builtin_fabs(at) + __builtin_fabs(a[k]) + radius);
        (*lo)[k] = round_down((float)(at + (a[k] < 0 ? a[k] : 0) - reach - slack));
        (*hi)[k] = round_up((float)(at + (a[k] > 0 ? a[k] : 0) + reach + slack));
    }
}

/* Where the ray first meets the side at a t > 0, from outside or inside. False, with *t as it was,
 * where it does not; for a ray along the axis; for a NaN. */
static inline bool cylinder_root(const struct ray *r, const struct stage_cylinder *c, double *t)
{
    double f[3], d[3], a[3], m[3], n[3];
    sphere_relative(r, c->from, f, d);
    cylinder_axis(c, a);
    cylinder_cross(f, a, m);
    cylinder_cross(d, a, n);
    const double nn = sphere_dot(n, n), aa = sphere_dot(a, a), passing = sphere_dot(f, n);
    const double rr = (double)c->radius * (double)c->radius;
    const double discriminant = aa * (nn * rr - passing * passing);
    if (!(nn > 0 && discriminant >= 0))
        return false;
    /* Of |m + t n|^2 = aa rr. The second one is the later, or else behind the origin. */
    const double b = -sphere_dot(m, n), root = __builtin_sqrt(discriminant);
    const double q = b >= 0 ? b + root : b - root;
    const double roots[2] = {(sphere_dot(m, m) - aa * rr) / q, q / nn};
    const double fa = sphere_dot(f, a), da = sphere_dot(d, a);
    for (int i = 0; i < 2; i++) {
        const double height = fa + roots[i] * da; /* times |a| */
        if (roots[i] > 0 && height >= 0 && height <= aa) {
            *t = roots[i];
            return true;
        }
    }
    return false;
}

/* The nearest t > 0. */
static inline bool cylinder_hit(const struct ray *r, const struct stage_cylinder *c, float *t)
{
    double root;
    if (!cylinder_root(r, c, &root))
        return false;
    *t = (float)root;
    return *t > 0;
}

#endif
