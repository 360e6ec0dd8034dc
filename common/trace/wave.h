/* wave.h - eight paths on the way at once: their rays are traced together (bvh_hit_closest_8),
 * their random numbers are made together, and their vertices are treated together where they are
 * plain (path8.h). Where a path has ended another takes its place, at its own first bounce. What
 * comes out for one does not depend on the others.
 *
 *     wave_begin    camera rays -> starts, for a path and its sibling each
 *     wave_put      paths from starts into the wave, which goes on until there is room for them
 *     wave_finish   until all have ended: then every path's radiance is where wave_init was told
 *
 * One thread; the caller's storage, nothing to release.
 * SPDX-License-Identifier: MIT */
#ifndef COMMON_TRACE_WAVE_H
#define COMMON_TRACE_WAVE_H

#include "common/layers.h"
#include "common/trace/cone.h"
#include "common/trace/path.h"
#include "common/trace/path8.h"
#include "common/trace/path_media.h"
#include "common/trace/rng.h"
#include "common/trace/sampler.h"

enum { WAVE_LANES = 8 };

/* Camera rays: what paths and their siblings (rng.h) share. Bit i and number i are ray i's. */
struct wave_starts {
    uint32_t met;          /* a surface: there is a vertex */
    uint32_t ends;         /* nothing else comes along the ray */
    uint32_t plain;        /* the vertex is in lanes */
    rgb light[WAVE_LANES]; /* of the sky, or of the vertex itself */
    struct film_work work; /* that they have taken: only one of two siblings counts it */
    struct path8_vertex lanes;
    struct path_vertex vertices[WAVE_LANES]; /* those that are not plain */
    /* In a scene with media alone: what each path starts with anew. */
    vec3 origins[WAVE_LANES];    /* of the camera rays */
    struct ray rays[WAVE_LANES]; /* behind what masks let them through */
    struct ray_hit hits[WAVE_LANES];
    struct cone cones[WAVE_LANES]; /* of the rays where they have arrived; see cone.h */
};

/* light[k][n]: of the light that path n finds, what was scattered at most k times. */
struct wave_terms {
    uint32_t count; /* of those asked for; then paths have numbers below WAVE_LANES */
    rgb light[LAYERS_MAX_BOUNCES][WAVE_LANES];
};

/* By lane: bit i and number i are lane i's. */
struct wave {
    const struct stage *stage;
    uint32_t roulette_begin;
    uint32_t max_bounces;     /* the settings'; the caller may set another before paths are put */
    uint32_t cut;             /* not 0: of the paths so far, some have ended there alone */
    rgb *radiance;            /* by the path's number; the caller's */
    struct film_work work;    /* of all paths so far, but for their starts */
    struct wave_terms *terms; /* or NULL; the caller's */

    uint32_t going; /* lanes with a path that has a vertex to go on from */
    uint32_t plain; /* where the path is: in lanes, or in paths */
    struct path8 lanes;
    struct path8_vertex vertices[2]; /* one is where the lanes are, the other for the next */
    struct path paths[WAVE_LANES];
    struct path_media media[WAVE_LANES];  /* of paths in a scene with media */
    uint32_t number[WAVE_LANES];          /* the path's */
    struct cone cones[WAVE_LANES];        /* of the rays that have led to the vertices */
    struct material textured[WAVE_LANES]; /* the vertices' materials, of those with textures */
    u32x8 bounce;
    struct rng8 rng;             /* at the bounce where the lane is */
    struct rng rngs[WAVE_LANES]; /* the same, at the first bounce */

    /* A bounce's random numbers: made for all at once, which costs less than for two of them alone.
     */
    struct sobol8_bits lamp;
    struct path8_draw draw;

    struct ray rays[WAVE_LANES], shadows[WAVE_LANES];
};

/* The rays whose bit is set in `which`; their directions are unit. rngs: of the paths that start
 * there, of either of two siblings. */
void wave_begin(const struct stage *, uint32_t which, const struct ray rays[],
                const struct rng rngs[], struct wave_starts *);

/* Of a ray that met a surface; its material as it lies in the stage. */
struct path_vertex wave_first(const struct stage *, const struct wave_starts *, uint32_t i);

/* radiance[n]: one unbiased estimate of what arrives along the ray of path n, cut at
 * settings.max_bounces scattering events. roulette_begin: the first bounce after which a path may
 * be ended by chance; UINT32_MAX for never. terms: NULL, or their light is filled. */
void wave_init(struct wave *, const struct stage *, uint32_t roulette_begin, struct wave_terms *,
               rgb radiance[]);

/* For each bit i of `which`: path number + i, along ray i, with the numbers of rngs[i]. */
void wave_put(struct wave *, uint32_t which, const struct wave_starts *, const struct rng rngs[],
              uint32_t number);

void wave_finish(struct wave *);

/* --- of wave.c alone: what it does otherwise (wave_otherwise.c) --- */

void wave_choose_materials(struct wave *); /* in scenes where some are made of others */
void wave_apply_textures(struct wave *);   /* in scenes with some */
void wave_draw_otherwise(struct wave *);
uint32_t wave_smooth_alone(const struct wave *, uint32_t next);

/* Of a step, before its rays are traced: those along which paths look at lights, and go on. */
static inline void wave_count(struct wave *w, uint32_t lamps, uint32_t next)
{
    struct film_work *work = &w->work;
    work->plain_vertices += (uint64_t)__builtin_popcount(w->going & w->plain);
    work->other_vertices += (uint64_t)__builtin_popcount(w->going & ~w->plain);
    work->shadow_rays += (uint64_t)__builtin_popcount(lamps);
    work->bounce_rays += (uint64_t)__builtin_popcount(next);
}

/* By other samplers than Sobol's: all numbers of a bounce, whether there is a use for them or not.
 */
static inline bool wave_has_drawn_otherwise(struct wave *w)
{
    if (sampler_is_sobol(&w->stage->settings))
        return false;
    wave_draw_otherwise(w);
    return true;
}

/* The paths that have a next ray and go on: of Whitted's those from smooth surfaces (T. Whitted,
 * "An Improved Illumination Model for Shaded Display", CACM 23(6), 1980). */
static inline uint32_t wave_kept(const struct wave *w, uint32_t next)
{
    const bool whitted = w->stage->settings.integrator == INTEGRATOR_WHITTED;
    return __builtin_expect(whitted, false) ? wave_smooth_alone(w, next) : next;
}

#endif
