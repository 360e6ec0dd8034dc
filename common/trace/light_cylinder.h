/* light_cylinder.h - a cylinder as a light: how a point of what is seen of it is chosen.
 *
 * The viewer is at the distance D from the axis, and r is the radius. Round the axis an arc is
 * seen, up to where the tangents touch, at the angle from the viewer whose cosine is r / D. Along
 * it, a place at the height h over the viewer's foot on the axis is d = sqrt(D^2 + h^2) away from
 * them.
 *
 *   across: uniform in the sine of the angle, that is over the width that is seen;
 *   along:  uniform in h / d, whose change with h is D^2 / d^3. Seen under the cosine D / d and
 *           from d away, a thin cylinder fills solid angle at a rate in proportion to that.
 *
 * So a thin cylinder is chosen uniformly by solid angle, however long it is and however near, and a
 * thick one nearly so. All in double, and differences of near values in a form without them.
 * SPDX-License-Identifier: MIT */
#ifndef COMMON_TRACE_LIGHT_CYLINDER_H
#define COMMON_TRACE_LIGHT_CYLINDER_H

#include "common/trace/cylinder.h"
#include "common/trace/sobol.h"

struct light_cylinder {
    vec3 toward; /* unit, from the axis to the viewer */
    vec3 axis;   /* unit */
    float sine;  /* of half the arc; 0 from inside, where the cylinder does not shine */
    double radius, length;
    double distance, low;   /* D; h of the first end */
    double sine_low, width; /* h / d of the first end; and how much more it is at the other */
};

static inline struct light_cylinder light_cylinder_make(const struct stage_cylinder *c, vec3 from)
{
    struct light_cylinder v = {.sine = 0};
    double a[3], f[3];
    cylinder_axis(c, a);
    for (int k = 0; k < 3; k++)
        f[k] = (double)from[k] - (double)c->from[k];
    const double aa = sphere_dot(a, a), up = sphere_dot(f, a) / aa;
    for (int k = 0; k < 3; k++)
        f[k] -= up * a[k];
    const double DD = sphere_dot(f, f), D = __builtin_sqrt(DD);
    v.radius = (double)c->radius;
    v.length = __builtin_sqrt(aa);
    if (!(D > v.radius))
        return v;
    for (int k = 0; k < 3; k++) {
        v.toward[k] = (float)(f[k] / D);
        v.axis[k] = (float)(a[k] / v.length);
    }
    v.sine = (float)__builtin_sqrt((D - v.radius) * (D + v.radius) / DD);
    const double h0 = -up * v.length, h1 = (1 - up) * v.length;
    const double d0 = __builtin_sqrt(DD + h0 * h0), d1 = __builtin_sqrt(DD + h1 * h1);
    v.distance = D;
    v.low = h0;
    v.sine_low = h0 / d0;
    v.width = h0 * h1 > 0 ? DD * v.length * (h0 + h1) / ((h1 * d0 + h0 * d1) * d0 * d1)
                          : h1 / d1 - h0 / d0;
    return v;
}

/* For surface_on_cylinder. */
static inline float light_cylinder_along(const struct light_cylinder *v, float u)
{
    const double more = (double)u * v->width, sine = v->sine_low + more;
    const double cosine_low =
        v->distance / __builtin_sqrt(v->distance * v->distance + v->low * v->low);
    const double square = cosine_low * cosine_low - more * (2 * v->sine_low + more);
    const double h = v->distance * sine / __builtin_sqrt(square > 0 ? square : 0);
    const double along = (h - v->low) / v->length;
    return along > 1 ? 1 : along > 0 ? (float)along : 0;
}

static inline vec3 light_cylinder_outward(const struct light_cylinder *v, float u)
{
    const float sine = (2 * u - 1) * v->sine;
    return v->toward * __builtin_sqrtf(1 - sine * sine) + vec3_cross(v->axis, v->toward) * sine;
}

/* 1 / pdf_a at the point that d leads to from the viewer, with the normal ng; infinite where none
 * is chosen. */
static inline float light_cylinder_area(const struct light_cylinder *v, vec3 d, vec3 ng)
{
    const float cosine = vec3_dot(ng, v->toward);
    if (!(v->sine > 0 && cosine > 0))
        return __builtin_inff();
    const double h = (double)vec3_dot(d, v->axis), DD = v->distance * v->distance;
    const double dd = DD + h * h;
    const double along = v->width * dd * __builtin_sqrt(dd) / DD;
    return (float)(along * 2 * v->radius * (double)v->sine / (double)cosine);
}

#endif
