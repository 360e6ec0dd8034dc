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

#include "common/layers.h"
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
    uint32_t met;         /* a surface: there is a vertex */
    uint32_t ends;        /* nothing else comes along the ray */
    uint32_t plain;       /* the vertex is in lanes */
    rgb light[PATH_WAVE]; /* of the sky, or of the vertex itself */
    struct path8_vertex lanes;
    struct path_vertex vertices[PATH_WAVE]; /* those that are not plain */
};

/* light[k][i]: of the light that path i finds, what was scattered at most k times. */
struct path_terms {
    uint32_t count; /* of those asked for */
    rgb light[LAYERS_MAX_BOUNCES][PATH_WAVE];
};

/* The rays whose bit is set in `which`; their directions are unit. */
void path_begin(const struct stage *, uint32_t which, const struct ray rays[],
                struct path_starts *);

/* Of one that met a surface. */
struct path_vertex path_first(const struct stage *, const struct path_starts *, uint32_t i);

/* radiance[i], for each bit of `which`: one unbiased estimate of what arrives along ray i, with the
 * numbers of rngs[i], cut at settings.max_bounces scattering events. roulette_begin: the first
 * bounce after which a path may be ended by chance; UINT32_MAX for never. terms: NULL, or their
 * light is filled. */
void path_radiance(const struct stage *, uint32_t which, const struct path_starts *,
                   const struct rng rngs[], uint32_t roulette_begin, struct path_terms *terms,
                   rgb radiance[]);

#endif
