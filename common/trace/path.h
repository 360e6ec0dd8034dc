/* path.h - the path integrator: light along rays, by following them through the scene.
 *
 * J. Kajiya, "The Rendering Equation", SIGGRAPH 1986, with next-event estimation and multiple
 * importance sampling (E. Veach, L. Guibas, "Optimally Combining Sampling Techniques for Monte
 * Carlo Rendering", SIGGRAPH 1995, power heuristic).
 *
 * Up to eight paths go in step, so that their rays are traced together (bvh_hit_closest_8), and so
 * that vertices that are alike are treated in the lanes of vectors (path8.h). What comes out for
 * one does not depend on the others. SPDX-License-Identifier: MIT */
#ifndef COMMON_TRACE_PATH_H
#define COMMON_TRACE_PATH_H

#include "common/trace/path8.h"
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

/* Camera rays: what paths and their siblings (rng.h) share. Bit i and number i are ray i's. */
struct path_starts {
    uint32_t ends;        /* nothing else comes along the ray */
    uint32_t plain;       /* the vertex, where it is scattered unless it ends, is in lanes */
    rgb light[PATH_WAVE]; /* of the sky, or of the vertex itself */
    struct path8_vertex lanes;
    struct path_vertex vertices[PATH_WAVE]; /* those that are not plain */
};

/* The rays whose bit is set in `which`; their directions are unit. */
void path_begin(const struct stage *, uint32_t which, const struct ray rays[],
                struct path_starts *);

/* radiance[i], for each bit of `which`: one unbiased estimate of what arrives along ray i, with the
 * numbers of rngs[i], cut at settings.max_bounces scattering events. roulette_begin: the first
 * bounce after which a path may be ended by chance; UINT32_MAX for never. */
void path_radiance(const struct stage *, uint32_t which, const struct path_starts *,
                   const struct rng rngs[], uint32_t roulette_begin, rgb radiance[]);

#endif
