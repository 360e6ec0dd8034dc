/* shading.h - a shading normal that is fit for use: seen from where the viewer is, and reflecting
 * to where light can come from.
 *
 * Interpolated and mapped normals are of a surface that is not there. Two normals then say on which
 * side of the surface a direction is, and where they disagree, light would pass walls or be lost.
 * path_shade.h has the rules; here is what keeps surfaces from going black at their rims.
 * SPDX-License-Identifier: MIT */
#ifndef COMMON_TRACE_SHADING_H
#define COMMON_TRACE_SHADING_H

#include "common/vec.h"

/* The reflected ray rises at least so far above the surface, or half as far as the viewer. */
#define SHADING_LEAST_RISE 0x1p-5f

/* ns, or where the direction in which it reflects the viewer would go below the surface, the normal
 * that reflects to just above it: the half vector of the viewer and of that direction, raised. It
 * is continuous, and leaves ng itself as it is. ns and wo on ng's side, but ns may look away from
 * the viewer. All unit; wo . ng > 0. The result is on the sides of both ng and wo. */
static inline vec3 shading_bend(vec3 ns, vec3 ng, vec3 wo)
{
    const float up = 0.5f * vec3_dot(wo, ng);
    const float least = up < SHADING_LEAST_RISE ? up : SHADING_LEAST_RISE;
    const vec3 r = 2 * vec3_dot(ns, wo) * ns - wo;
    const float rise = vec3_dot(r, ng);
    if (rise >= least)
        return ns;
    return vec3_unit(wo + vec3_unit(r + (least - rise) * ng));
}

/* ns, or where it is not above the surface, or all but level with it, raised to just above it. */
static inline vec3 shading_rise(vec3 ns, vec3 ng)
{
    const float least = 0x1p-10f, rise = vec3_dot(ns, ng);
    return rise < least ? vec3_unit(ns + (least - rise) * ng) : ns;
}

/* A local direction on the wrong side of z, moved to just on the right one: side is 1 or -1. */
static inline vec3 shading_raise(vec3 w, float side)
{
    const float z = 0x1p-10f, rr = w[0] * w[0] + w[1] * w[1];
    if (side * w[2] > 0)
        return w;
    const float k = rr > 0 ? __builtin_sqrtf((1 - z * z) / rr) : 0;
    return k > 0 ? vec3_make(k * w[0], k * w[1], side * z)
                 : vec3_make(__builtin_sqrtf(1 - z * z), 0, side * z);
}

#endif
