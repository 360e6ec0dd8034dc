/* path_mask.h - rays in scenes with masks: past what lets them through.
 *
 * A ray that is followed goes on by chance, straight and without having been scattered; a shadow
 * ray is weakened by what it passes, which needs no chance. Only for stages that say `masked`.
 * SPDX-License-Identifier: MIT */
#ifndef COMMON_TRACE_PATH_MASK_H
#define COMMON_TRACE_PATH_MASK_H

#include "common/film.h"
#include "common/trace/ray.h"
#include "common/trace/rng.h"

/* Rays of paths, ray i with the numbers of path i, after bounce[i] scattering events. */
struct path_mask_rays {
    const struct rng *rngs;
    u32x8 bounce;
    struct ray *rays;
    struct ray_hit *hits;
    struct film_work *work; /* counts on */
};

struct path_mask_ray { /* one of them, from where it has met so many masks */
    const struct rng *rng;
    uint32_t bounce, crossing;
    struct ray *ray;
    struct ray_hit *hit;
    struct film_work *work;
};

/* It has met *hit. False: nothing stops it. */
bool path_mask_stops(const struct stage *, const struct path_mask_ray *);

/* found: bit i of those that have a hit, hits[i] the closest; returns the same for those that are
 * stopped, hits[i] then the first that does it, and rays[i] as it was traced last. */
uint32_t path_mask_pass(const struct stage *, uint32_t found, const struct path_mask_rays *);

/* The share of light that passes along a shadow ray. work: counts on. */
float path_mask_share(const struct stage *, struct ray shadow, struct film_work *work);

#endif
