/* naive_hit.h - the oracle of ray intersection: every primitive, in double, by other formulas
 * than the core's (Moller and Trumbore 1997; the quadratic; the plane; a circle
 * in the plane across the axis). Shares with it the stage
 * only.
 *
 * Float and double may disagree about a ray that all but grazes something. Such a ray is
 * `doubtful`: for some primitive not farther than the hit it passes within 1e-5 of the reach (the
 * largest distance from origin to primitive, per coordinate) of an edge or silhouette, meets the
 * surface at a sine below 1e-2, or starts or ends (t_max) within that distance of the surface,
 * divided by the sine.
 * SPDX-License-Identifier: MIT */
#ifndef TESTS_NAIVE_HIT_H
#define TESTS_NAIVE_HIT_H

#include "common/trace/ray.h"
#include "common/trace/stage.h"

struct naive_hit {
    double t;       /* of the nearest hit; +infinity without one */
    double t_reach; /* the hit primitive's reach, as a t: float rounding is in proportion to it */
    uint32_t prim;
    bool hit, doubtful;
};

struct naive_hit naive_hit_closest(const struct stage *, const struct ray *);

#endif
