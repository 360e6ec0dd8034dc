/* box.h - ray against axis-aligned box: never misses a box whose primitive the ray's own test hits.
 *
 * T. Ize, "Robust BVH Ray Traversal", JCGT 2(2), 2013, pads the far distance for the roundings of
 * the slab test. That is not enough: the triangle test (tri.h) decides with sheared vertices, each
 * off by up to gamma(4) (|x| + |shear z|) (x, z: its distance from the origin), so it may accept a
 * ray that passes the box at that distance (Woop et al. 2013, section 3.3). Each slab is widened by
 * it; a box that starts far behind the ray's origin is where that shows.
 *
 * Monotone: the entry into a box is not after the entry into a box inside it, bit for bit, since
 * every operation is. A NaN (0 * infinity: the ray lies in the plane) must lose: the comparisons
 * keep what was there. SPDX-License-Identifier: MIT */
#ifndef COMMON_TRACE_BOX_H
#define COMMON_TRACE_BOX_H

#include <float.h>

#include "common/trace/ray.h"
#include "common/trace/round.h"
#include "common/trace/simd.h"

struct box_ray {
    vec3 origin;
    vec3 inv;   /* 1 / dir: infinite, with dir's sign, where dir is 0 */
    vec3 shear; /* error of a slab in parts of the distance along z */
    int z;      /* the axis along which the ray is longest */
};

/* z: the first of the axes along which |dir| is largest. */
static inline struct box_ray box_ray_make(vec3 origin, vec3 dir, int z)
{
    const vec3 d = vec3_abs(dir);
    return (struct box_ray){origin, 1 / dir, round_gamma(5) * (d / d[z]), z};
}

/* t: where the ray enters and leaves, not below 0; FLT_MAX at most. */
static inline bool box_hit(const struct box_ray *r, vec3 lo, vec3 hi, float t[2])
{
    const vec3 none = {0}, most = vec3_make(FLT_MAX, FLT_MAX, FLT_MAX);
    const i32x4 back = r->inv < none;
    const vec3 a = lo - r->origin, b = hi - r->origin;
    const vec3 reach = vec3_max(vec3_abs(a), vec3_abs(b));
    const vec3 error = round_gamma(5) * reach + r->shear * reach[r->z];
    const vec3 first = a - error, last = b + error;
    const vec3 near = vec3_max(vec3_choose(back, last, first) * r->inv, none);
    const vec3 far =
        vec3_min(vec3_choose(back, first, last) * r->inv * (1 + 2 * round_gamma(3)), most);
    const float near01 = near[0] > near[1] ? near[0] : near[1];
    const float far01 = far[0] < far[1] ? far[0] : far[1];
    t[0] = near01 > near[2] ? near01 : near[2];
    t[1] = far01 < far[2] ? far01 : far[2];
    return t[0] <= t[1];
}

#endif
