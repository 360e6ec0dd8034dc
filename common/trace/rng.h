/* rng.h - random numbers as a pure function of (seed, pixel, sample, dimension).
 *
 * There is no state: whoever asks for the same number gets the same bits, in any order. Sample i
 * of a pixel is point i / 8 of replicate i mod 8 (film.h); a replicate is a scramble of its own.
 *
 * The dimension map is fixed. A number that a path does not need is not made, and shifts no other:
 *
 *     0                     the pixel filter, a pair
 *     1 + 5 bounce + p      purpose p below, at each bounce; a pair or a single number
 * SPDX-License-Identifier: MIT */
#ifndef COMMON_TRACE_RNG_H
#define COMMON_TRACE_RNG_H

#include "common/film.h"
#include "common/trace/sobol.h"

enum rng_purpose {
    RNG_LIGHT_PICK,     /* 32 bits: which emitter */
    RNG_LIGHT_POSITION, /* pair: where on it */
    RNG_BSDF_DIRECTION, /* pair */
    RNG_BSDF_LOBE,      /* single: reflection or refraction */
    RNG_ROULETTE,       /* single */
};

enum { RNG_FILTER = 0, RNG_PURPOSES = RNG_ROULETTE + 1 };

struct rng {
    uint64_t key;            /* of the pixel's replicate */
    uint32_t index_reversed; /* of the sample in its replicate, bits written backwards */
};

/* A bijection whose every output bit depends on every input bit: D. Stafford, "Better Bit Mixing",
 * 2011 (https://zimbry.blogspot.com/2011/09/better-bit-mixing-improving-on.html), variant 13. */
static inline uint64_t rng_mix(uint64_t x)
{
    x = (x ^ x >> 30) * 0xbf58476d1ce4e5b9u;
    x = (x ^ x >> 27) * 0x94d049bb133111ebu;
    return x ^ x >> 31;
}

static inline struct rng rng_make(uint64_t seed, uint32_t x_px, uint32_t y_px, uint32_t sample)
{
    const uint64_t frame = 0, replicate = sample % FILM_REPLICATES;
    uint64_t key = rng_mix(seed + 0x9e3779b97f4a7c15u);
    key = rng_mix(key ^ ((uint64_t)y_px << 32 | x_px));
    key = rng_mix(key ^ (frame << 8 | replicate));
    return (struct rng){key, sobol_reverse(sample / FILM_REPLICATES)};
}

static inline uint32_t rng_dimension(uint32_t bounce, enum rng_purpose purpose)
{
    return 1 + bounce * RNG_PURPOSES + purpose;
}

/* The seeds of a dimension: the splitmix sequence that starts at the key (G. Steele, D. Lea,
 * C. Flood, "Fast Splittable Pseudorandom Number Generators", OOPSLA 2014). */
static inline uint64_t rng_seeds(const struct rng *r, uint32_t dimension)
{
    return rng_mix(r->key + (dimension + 1) * 0x9e3779b97f4a7c15u);
}

static inline struct square rng_pair(const struct rng *r, uint32_t dimension)
{
    const uint64_t h = rng_seeds(r, dimension);
    const uint32_t third = (uint32_t)(h * 0xd1342543de82ef95u >> 32);
    return sobol_pair(r->index_reversed, (uint32_t)h, (uint32_t)(h >> 32), third);
}

static inline uint32_t rng_bits(const struct rng *r, uint32_t dimension)
{
    const uint64_t h = rng_seeds(r, dimension);
    return sobol_first_bits(r->index_reversed, (uint32_t)h, (uint32_t)(h >> 32));
}

static inline float rng_single(const struct rng *r, uint32_t dimension)
{
    return sobol_float(rng_bits(r, dimension));
}

#endif
