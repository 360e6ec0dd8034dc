/* box.h - ray against axis-aligned box: never misses a box whose primitive the ray's own test hits.
 *
 * T. Ize, "Robust BVH Ray Traversal", JCGT 2(2), 2013, pads the far distance for the roundings of the
 * slab test. That is not enough: the triangle test (tri.h) decides with sheared vertices, each off
 * by up to gamma(4) (|x| + |shear z|) (x, z: its distance from the origin), so it may accept a ray that
 * passes the box at that distance (Woop et al. 2013, section 3.3). Each slab is widened
 * by it; a box that starts far behind the ray's origin is where that shows.
 *
 * Monotone: the entry into a box is not after the entry into a box inside it, bit for bit, since every
 * operation is. A NaN (0 * infinity: the ray lies in the plane) must lose: the
 * comparisons keep what was there.
 * SPDX-License-Identifier: MIT */
#ifndef COMMON_TRACE_BOX_H
#define COMMON_TRACE_BOX_H

#include "common/trace/ray.h"
#include "common/trace/round.h"

struct box_ray {
    float origin[3];
    float inv[3];   /* 1 / dir: infinite, with dir's sign, where dir is 0 */
    float shear[3]; /* error of a slab in parts of the distance along z */
    bool neg[3];    /* inv < 0: the upper plane is the near one */
    int z;          /* the axis along which the ray is longest */
};

static inline struct box_ray box_ray_make(const struct ray *r)
{
    struct box_ray b;
    float longest = 0;
    b.z = 0;
    for (int k = 0; k < 3; k++) {
        const float d = __builtin_fabsf(r->dir[k]);
        b.z = d > longest ? k : b.z;
        longest = d > longest ? d : longest;
    }
    for (int k = 0; k < 3; k++) {
        b.origin[k] = r->origin[k];
        b.inv[k] = 1 / r->dir[k];
        b.neg[k] = b.inv[k] < 0;
        b.shear[k] = round_gamma(5) * __builtin_fabsf(r->dir[k] / longest);
    }
    return b;
}

/* The distance from the origin to the farther plane. */
static inline float box_reach(float lo, float hi)
{
    const float a = __builtin_fabsf(lo), b = __builtin_fabsf(hi);
    return a > b ? a : b;
}

/* t: where the ray enters and leaves, within [0, t_max]. t_max must be finite, for a ray beside the
 * box and parallel to it enters at infinity. */
static inline bool box_hit(const struct box_ray *r, const float lo[3], const float hi[3],
                           float t_max, float t[2])
{
    const float along = box_reach(lo[r->z] - r->origin[r->z], hi[r->z] - r->origin[r->z]);
    float t0 = 0, t1 = t_max;
    for (int k = 0; k < 3; k++) {
        float a = lo[k] - r->origin[k], b = hi[k] - r->origin[k];
        const float error = round_gamma(5) * box_reach(a, b) + r->shear[k] * along;
        a -= error;
        b += error;
        const float near = (r->neg[k] ? b : a) * r->inv[k];
        const float far = (r->neg[k] ? a : b) * r->inv[k] * (1 + 2 * round_gamma(3));
        t0 = near > t0 ? near : t0;
        t1 = far < t1 ? far : t1;
    }
    t[0] = t0;
    t[1] = t1;
    return t0 <= t1;
}

#endif
