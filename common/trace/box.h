/* box.h - ray against axis-aligned box, conservative: whatever a primitive test of this library finds
 * inside a box, at the t it finds, is inside for box_hit, too.
 *
 * Robust slab test: T. Ize, "Robust BVH Ray Traversal", JCGT 2(2), 2013. He widens the far planes for
 * the rounding of the slab test itself. We also make good for t: it is rounded to a float, so the
 * point it names lies beside the primitive by 2^-24 t |dir|. The ray is therefore taken for a thin
 * cone: near planes are met by its fast side, far planes by its slow one. That costs nothing per box.
 * A NaN (0 * infinity: the ray lies in the plane) must lose: the comparisons keep what was there.
 * SPDX-License-Identifier: MIT */
#ifndef COMMON_TRACE_BOX_H
#define COMMON_TRACE_BOX_H

#include "common/trace/ray.h"
#include "common/trace/round.h"

struct box_ray {
    float near_origin[3], far_origin[3];
    float near_inv[3], far_inv[3]; /* 1 / speed along the axis, of the cone's fast and slow side */
    uint32_t neg[3];               /* 1: the upper plane is the near one */
};

/* The greatest distance between the ray's origin and the bounds, along any axis. */
static inline float box_reach(const struct ray *r, const float bounds[2][3])
{
    float reach = 0;
    for (int k = 0; k < 3; k++)
        for (int side = 0; side < 2; side++) {
            const float d = __builtin_fabsf(bounds[side][k] - r->origin[k]);
            reach = d > reach ? d : reach;
        }
    return reach;
}

/* bounds: of all boxes the ray will be held against. dir has a component that is not subnormal.
 *
 * The cone's slope: gamma(8) for the rounding of t (1) and of a slab distance (6: speed and its inverse,
 * difference, product); and 2^-40 of the fastest axis for the primitive tests' own errors, which
 * are below 2^-46 of the distance. Where the ray moves along an axis no faster than the cone
 * widens it stays within the width at its end, which is added to the origin instead (twice,
 * as that is rounded, too), and the speed counts as 0. */
static inline struct box_ray box_ray_make(const struct ray *r, const float bounds[2][3])
{
    struct box_ray b;
    float speed = 0;
    for (int k = 0; k < 3; k++) {
        const float d = __builtin_fabsf(r->dir[k]);
        speed = d > speed ? d : speed;
    }
    for (int k = 0; k < 3; k++) {
        const float d = __builtin_fabsf(r->dir[k]);
        const float sign = __builtin_signbit(r->dir[k]) ? -1 : 1;
        const float widening = round_gamma(8) * d + 0x1p-40f * speed;
        b.neg[k] = sign < 0;
        b.near_origin[k] = b.far_origin[k] = r->origin[k];
        if (d > 4 * widening) {
            b.near_inv[k] = sign / (d + widening);
            b.far_inv[k] = sign / (d - widening);
        } else {
            const float width = 2 * (8 * 0x1p-40f) * box_reach(r, bounds);
            b.near_origin[k] += sign * width;
            b.far_origin[k] -= sign * width;
            b.near_inv[k] = b.far_inv[k] = sign * __builtin_inff();
        }
    }
    return b;
}

/* plane[0], plane[1]: lower and upper corner. *t: where the ray enters, 0 from inside. */
static inline bool box_hit(const struct box_ray *r, const float plane[2][3], float t_max, float *t)
{
    float t0 = 0, t1 = t_max;
    for (int k = 0; k < 3; k++) {
        const float near = (plane[r->neg[k]][k] - r->near_origin[k]) * r->near_inv[k];
        const float far = (plane[1 - r->neg[k]][k] - r->far_origin[k]) * r->far_inv[k];
        t0 = near > t0 ? near : t0;
        t1 = far < t1 ? far : t1;
    }
    *t = t0;
    return t0 <= t1;
}

#endif
