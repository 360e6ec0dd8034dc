/* path.h - the path integrator: light along rays, by following them through the scene.
 *
 * J. Kajiya, "The Rendering Equation", SIGGRAPH 1986, with next-event estimation and multiple
 * importance sampling (E. Veach, L. Guibas, "Optimally Combining Sampling Techniques for Monte
 * Carlo Rendering", SIGGRAPH 1995, power heuristic).
 *
 * Up to eight paths go in step, so that their rays are traced together (bvh_hit_closest_8). What
 * comes out for one does not depend on the others.
 * SPDX-License-Identifier: MIT */
#ifndef COMMON_TRACE_PATH_H
#define COMMON_TRACE_PATH_H

#include "common/trace/ray.h"
#include "common/trace/rng.h"
#include "common/trace/stage.h"
#include "common/trace/surface.h"
#include "common/trace/warp.h"

enum {
    PATH_WAVE = 8,           /* the most paths at once */
    PATH_ROULETTE_BEGIN = 1, /* the first bounce after which a path may be ended by chance */
};

struct path_vertex { /* where a ray has arrived */
    struct surface at;
    struct warp_frame frame;
    const struct material *material;
    vec3 wo; /* where the ray came from; local */
};

struct path_raised { /* beside a vertex in a scene with details (path_shade.h) */
    bool is;         /* light from below the triangle and above the frame's plane is gathered at: */
    vec3 p;
};

struct path_start {            /* a camera ray: what a path and its sibling (rng.h) share */
    rgb light;                 /* of the sky, or of the vertex itself */
    bool ends;                 /* nothing else comes along the ray */
    struct path_vertex vertex; /* where it is scattered, unless it ends */
    struct path_raised raised;
};

/* The rays' directions: unit. */
void path_begin(const struct stage *, const struct ray rays[], uint32_t count,
                struct path_start starts[]);

/* radiance[i]: one unbiased estimate of what arrives along starts[i], with the numbers of rngs[i],
 * cut at settings.max_bounces scattering events. roulette_begin: the first bounce after which a
 * path may be ended by chance; UINT32_MAX for never. */
void path_radiance(const struct stage *, const struct path_start starts[], const struct rng rngs[],
                   uint32_t count, uint32_t roulette_begin, rgb radiance[]);

#endif
