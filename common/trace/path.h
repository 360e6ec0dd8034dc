/* path.h - the path integrator: light along a ray, by following it through the scene.
 *
 * J. Kajiya, "The Rendering Equation", SIGGRAPH 1986, with next-event estimation and multiple
 * importance sampling (E. Veach, L. Guibas, "Optimally Combining Sampling Techniques for Monte
 * Carlo Rendering", SIGGRAPH 1995, power heuristic).
 * SPDX-License-Identifier: MIT */
#ifndef COMMON_TRACE_PATH_H
#define COMMON_TRACE_PATH_H

#include "common/trace/ray.h"
#include "common/trace/rng.h"
#include "common/trace/stage.h"
#include "common/trace/surface.h"
#include "common/trace/warp.h"

/* The first bounce after which a path may be ended by chance. */
enum { PATH_ROULETTE_BEGIN = 1 };

struct path_vertex { /* where a ray has arrived */
    struct surface at;
    struct warp_frame frame;
    const struct material *material;
    vec3 wo; /* where the ray came from; local */
};

/* A camera ray: what a path and its sibling (rng.h) have in common. */
struct path_start {
    rgb light;                 /* of the sky, or of the vertex itself */
    bool ends;                 /* nothing else comes along the ray */
    struct path_vertex vertex; /* where it is scattered, unless it ends */
};

/* The ray's direction: unit. */
void path_begin(const struct stage *, struct ray, struct path_start *);

/* One unbiased estimate of the radiance that arrives along the ray, cut at
 * settings.max_bounces scattering events. roulette_begin: the first bounce after which a path may
 * be ended by chance; UINT32_MAX for never. */
rgb path_radiance(const struct stage *, const struct path_start *, const struct rng *,
                  uint32_t roulette_begin);

#endif
