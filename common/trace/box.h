/* box.h - ray against axis-aligned box, conservative.
 *
 * Robust slab test: T. Ize, "Robust BVH Ray Traversal", JCGT 2(2), 2013. The far planes' distance is
 * padded by 2 gamma(3), so no box is missed that the exact ray touches. A NaN (0 * infinity: the ray
 * lies in the plane) must lose: the comparisons keep what was there.
 * SPDX-License-Identifier: MIT */
#ifndef COMMON_TRACE_BOX_H
#define COMMON_TRACE_BOX_H

#include "common/trace/ray.h"
#include "common/trace/round.h"

struct box_ray {
    float origin[3];
    float inv[3]; /* 1 / dir: infinite, with dir's sign, where dir is 0 */
    bool neg[3];  /* inv < 0: the upper plane is the near one */
};

static inline struct box_ray box_ray_make(const struct ray *r)
{
    struct box_ray b;
    for (int k = 0; k < 3; k++) {
        b.origin[k] = r->origin[k];
        b.inv[k] = 1 / r->dir[k];
        b.neg[k] = b.inv[k] < 0;
    }
    return b;
}

static inline bool box_hit(const struct box_ray *r, const float lo[3], const float hi[3],
                           float t_max, float *t)
{
    float t0 = 0, t1 = t_max;
    for (int k = 0; k < 3; k++) {
        const float near = ((r->neg[k] ? hi[k] : lo[k]) - r->origin[k]) * r->inv[k];
        const float far = ((r->neg[k] ? lo[k] : hi[k]) - r->origin[k]) * r->inv[k] *
                          (1 + 2 * round_gamma(3));
        t0 = near > t0 ? near : t0;
        t1 = far < t1 ? far : t1;
    }
    *t = t0;
    return t0 <= t1;
}

#endif
