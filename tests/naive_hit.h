/* naive_hit.h - intersection by trying every primitive: the oracles of the BVH.
 *
 * naive_hit_closest and _any use the core's primitive tests, so the BVH must agree to the last bit.
 * naive_hit_textbook shares nothing with the core: T. Moeller, B. Trumbore, "Fast, Minimum
 * Storage Ray-Triangle Intersection", 1997, the quadratic formula and the plane equation, in long double.
 * SPDX-License-Identifier: MIT */
#ifndef TESTS_NAIVE_HIT_H
#define TESTS_NAIVE_HIT_H

#include "common/trace/ray.h"
#include "common/trace/stage.h"

bool naive_hit_closest(const struct stage *, const struct ray *, struct ray_hit *);
bool naive_hit_any(const struct stage *, const struct ray *);

struct naive_hit {
    bool hit;
    double t;
    uint32_t prim;
    bool doubtful; /* some primitive in front of the hit was met or missed by less than 1e-7 of its
                    * size, or t_max or 0 is that near: a float hit may rightly differ */
};

struct naive_hit naive_hit_textbook(const struct stage *, const struct ray *);

#endif
