/* path_mask.h - rays in scenes with masks: past what lets them through.
 *
 * A ray that is followed goes on by chance, straight and without having been scattered; a shadow
 * ray is weakened by what it passes, which needs no chance. Only for stages that say `masked`.
 * SPDX-License-Identifier: MIT */
#ifndef COMMON_TRACE_PATH_MASK_H
#define COMMON_TRACE_PATH_MASK_H

#include "common/trace/ray.h"
#include "common/trace/rng.h"

/* Rays of paths, each with the path's numbers, after so many scattering events. */
struct path_mask_rays {
    struct ray *rays;       /* as they were traced; then as they were traced last */
    struct ray_hit *hits;   /* the closest; then the first that stops the ray */
    const struct rng *rngs; /* of ray i: rngs[of ? of[i] : i] */
    const uint32_t *of;
    uint32_t bounce, count;
};

/* found: bit i of those that have a hit. Returns the same for those that are stopped. */
uint32_t path_mask_pass(const struct stage *, const struct path_mask_rays *, uint32_t found);

/* The share of light that passes along a shadow ray. */
float path_mask_share(const struct stage *, struct ray shadow);

#endif
