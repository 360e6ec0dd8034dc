/* sampler.h - which points a document's random numbers are (settings.sampler).
 *
 *     sobol        those of rng.h
 *     independent  every number is a hash of its place alone
 *     stratified   jittered: in each block of 4^k points of a replicate every cell of a grid of 2^k
 * x 2^k, every 4^k-th part of a single number, has one point, in random order. 4^k is the largest
 * power of 4 that the target's spp fills, at most 1024. (The classical way, which has to know the
 * number of samples: R. Cook, "Stochastic Sampling in Computer Graphics", ACM TOG 5(1), 1986.)
 *
 * The latter two are for comparisons. Numbers are pure functions of their place with all of them,
 * and the dimension map is the same.
 * SPDX-License-Identifier: MIT */
#ifndef COMMON_TRACE_SAMPLER_H
#define COMMON_TRACE_SAMPLER_H

#include "common/scene.h"
#include "common/trace/rng.h"

/* Of the two that are not Sobol's. points: how many of a replicate are used in all. */
struct sobol8_bits sampler_other_pair(const struct scene_settings *, const struct rng8 *,
                                      uint32_t dimension, uint32_t points);
u32x8 sampler_other_single(const struct scene_settings *, const struct rng8 *, uint32_t dimension,
                           uint32_t points);

static inline bool sampler_is_sobol(const struct scene_settings *s)
{
    return __builtin_expect(s->sampler == SAMPLER_SOBOL, true);
}

static inline uint32_t sampler_points(const struct scene_settings *s)
{
    return s->target.spp / FILM_REPLICATES;
}

static inline struct sobol8_bits sampler_pair_bits(const struct scene_settings *s,
                                                   const struct rng8 *r, uint32_t dimension)
{
    return sampler_is_sobol(s) ? rng8_pair_bits(r, dimension)
                               : sampler_other_pair(s, r, dimension, sampler_points(s));
}

static inline struct sobol8_square sampler_square(struct sobol8_bits b)
{
    return (struct sobol8_square){sobol8_float(b.u), sobol8_float(b.v)};
}

static inline struct sobol8_square sampler_pair(const struct scene_settings *s,
                                                const struct rng8 *r, uint32_t dimension)
{
    return sampler_is_sobol(s)
               ? rng8_pair(r, dimension)
               : sampler_square(sampler_other_pair(s, r, dimension, sampler_points(s)));
}

static inline f32x8 sampler_single(const struct scene_settings *s, const struct rng8 *r,
                                   uint32_t dimension)
{
    return sampler_is_sobol(s)
               ? rng8_single(r, dimension)
               : sobol8_float(sampler_other_single(s, r, dimension, sampler_points(s)));
}

/* What siblings share: the elders' pairs. */
struct sobol8_square sampler_elders(const struct scene_settings *, const struct rng_pixel *,
                                    uint32_t dimension);

static inline struct sobol8_square sampler_filter(const struct scene_settings *s,
                                                  const struct rng_pixel *p)
{
    return sampler_is_sobol(s) ? rng_pixel_filter(p) : sampler_elders(s, p, RNG_FILTER);
}

#endif
