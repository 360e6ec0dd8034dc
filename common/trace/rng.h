/* rng.h - random numbers as a pure function of (seed, pixel, sample, dimension).
 *
 * There is no state: whoever asks for the same number gets the same bits, in any order. Sample i
 * of a pixel is point i / 8 of replicate i mod 8 (film.h); a replicate is a scramble of its own.
 *
 * Points 2 k and 2 k + 1 of a replicate, samples 16 k + r and 16 k + 8 + r, are siblings: they
 * start with the same camera ray. Its place in the pixel is drawn from their elder, which is point
 * k of the replicate (rng_elder); all other numbers are their own.
 *
 * The dimension map is fixed. A number that a path does not need is not made, and shifts no other:
 *
 *     0                     the pixel filter, a pair
 *     1 + 4 bounce + p      purpose p below, at each bounce; a pair or a single number
 *     2^20 + 4 bounce       which material of those that make up one; a single number
 *     2^31 + 2^16 bounce + n    whether the n-th mask that the ray meets after so many bounces
 *                           stops it (from 2^16 masks on numbers are used again; behind the k-th
 *                           surface that is not there, path_media.h, n counts on from 2^8 k); a
 *                           single number
 *     2^30                  the place on the lens, a pair: the elder's, like the filter's
 *
 * sampler.h has other numbers for the same map.
 * SPDX-License-Identifier: MIT */
#ifndef COMMON_TRACE_RNG_H
#define COMMON_TRACE_RNG_H

#include "common/film.h"
#include "common/trace/sobol.h"
#include "common/trace/sobol8.h"

enum rng_purpose {
    RNG_LIGHT,          /* pair: which emitter, and where on it */
    RNG_BSDF_DIRECTION, /* pair */
    RNG_BSDF_LOBE,      /* single: reflection or refraction */
    RNG_ROULETTE,       /* single */
};

enum { RNG_FILTER = 0, RNG_LENS = 1 << 30, RNG_PURPOSES = RNG_ROULETTE + 1 };

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

static inline uint64_t rng_pixel_key(uint64_t seed, uint32_t x_px, uint32_t y_px)
{
    const uint64_t key = rng_mix(seed + 0x9e3779b97f4a7c15u);
    return rng_mix(key ^ ((uint64_t)y_px << 32 | x_px));
}

static inline uint64_t rng_replicate_key(uint64_t pixel_key, uint64_t replicate)
{
    const uint64_t frame = 0;
    return rng_mix(pixel_key ^ (frame << 8 | replicate));
}

static inline struct rng rng_make(uint64_t seed, uint32_t x_px, uint32_t y_px, uint32_t sample)
{
    return (struct rng){
        rng_replicate_key(rng_pixel_key(seed, x_px, y_px), sample % FILM_REPLICATES),
        sobol_reverse(sample / FILM_REPLICATES)};
}

static inline struct rng rng_elder(const struct rng *r)
{
    return (struct rng){r->key, r->index_reversed << 1};
}

static inline uint32_t rng_dimension(uint32_t bounce, enum rng_purpose purpose)
{
    return 1 + bounce * RNG_PURPOSES + purpose;
}

static inline uint32_t rng_dimension_choice(uint32_t bounce)
{
    return (1u << 20) + bounce * RNG_PURPOSES; /* as far apart as the others: rng8_next_bounce */
}

static inline uint32_t rng_dimension_mask(uint32_t bounce, uint32_t crossing)
{
    return (1u << 31) + (bounce << 16) + (crossing & 0xffff);
}

/* The seeds of a dimension: the splitmix sequence that starts at the key (G. Steele, D. Lea,
 * C. Flood, "Fast Splittable Pseudorandom Number Generators", OOPSLA 2014). */
static inline uint64_t rng_seeds(const struct rng *r, uint32_t dimension)
{
    return rng_mix(r->key + (dimension + 1) * 0x9e3779b97f4a7c15u);
}

/* --- one alone: what each number is. The core draws eight at once, below --- */

struct rng_pair_seeds {
    uint32_t shuffle, scramble_u, scramble_v;
};

static inline struct rng_pair_seeds rng_pair_seeds(const struct rng *r, uint32_t dimension)
{
    const uint64_t h = rng_seeds(r, dimension);
    const uint32_t third = (uint32_t)(h * 0xd1342543de82ef95u >> 32);
    return (struct rng_pair_seeds){(uint32_t)h, (uint32_t)(h >> 32), third};
}

static inline struct square rng_pair(const struct rng *r, uint32_t dimension)
{
    const struct rng_pair_seeds s = rng_pair_seeds(r, dimension);
    return sobol_pair(r->index_reversed, s.shuffle, s.scramble_u, s.scramble_v);
}

static inline struct sobol_bits rng_pair_bits(const struct rng *r, uint32_t dimension)
{
    const struct rng_pair_seeds s = rng_pair_seeds(r, dimension);
    return sobol_pair_bits(r->index_reversed, s.shuffle, s.scramble_u, s.scramble_v);
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

/* --- eight at once: the same bits --- */

struct rng8 {
    u64x4 key[2]; /* of lanes 0 to 3, 4 to 7 */
    u32x8 index_reversed;
};

/* Lanes from count on are as lane 0. */
static inline void rng8_make(struct rng8 *to, const struct rng r[], uint32_t count)
{
    struct rng from[8];
    for (uint32_t i = 0; i < 8; i++)
        from[i] = r[i < count ? i : 0];
    for (int i = 0; i < 2; i++)
        to->key[i] =
            (u64x4){from[4 * i].key, from[4 * i + 1].key, from[4 * i + 2].key, from[4 * i + 3].key};
    to->index_reversed =
        (u32x8){from[0].index_reversed, from[1].index_reversed, from[2].index_reversed,
                from[3].index_reversed, from[4].index_reversed, from[5].index_reversed,
                from[6].index_reversed, from[7].index_reversed};
}

static inline void rng8_set_lane(struct rng8 *r, uint32_t i, const struct rng *from)
{
    r->key[i / 4][i % 4] = from->key;
    r->index_reversed[i] = from->index_reversed;
}

/* A bounce further: what was dimension rng_dimension(n + 1, p) is rng_dimension(n, p) now. So lanes
 * at different bounces draw at once. */
static inline void rng8_next_bounce(struct rng8 *r)
{
    for (int i = 0; i < 2; i++)
        r->key[i] += RNG_PURPOSES * 0x9e3779b97f4a7c15u;
}

static inline u64x4 rng8_mix(u64x4 x)
{
    x = (x ^ x >> 30) * 0xbf58476d1ce4e5b9u;
    x = (x ^ x >> 27) * 0x94d049bb133111ebu;
    return x ^ x >> 31;
}

/* The lower, the upper halves of eight numbers. */
static inline u32x8 rng8_low(const u64x4 x[2])
{
    return __builtin_shufflevector((u32x8)x[0], (u32x8)x[1], 0, 2, 4, 6, 8, 10, 12, 14);
}

static inline u32x8 rng8_high(const u64x4 x[2])
{
    return __builtin_shufflevector((u32x8)x[0], (u32x8)x[1], 1, 3, 5, 7, 9, 11, 13, 15);
}

/* As rng_pair_seeds. */
static inline void rng8_seeds(const struct rng8 *r, uint32_t dimension, struct sobol8_seeds *s)
{
    const uint64_t step = (dimension + 1) * 0x9e3779b97f4a7c15u;
    const u64x4 h[2] = {rng8_mix(r->key[0] + step), rng8_mix(r->key[1] + step)};
    const u64x4 third[2] = {h[0] * 0xd1342543de82ef95u, h[1] * 0xd1342543de82ef95u};
    s->shuffle = rng8_low(h);
    s->scramble_u = rng8_high(h);
    s->scramble_v = rng8_high(third);
}

static inline struct sobol8_bits rng8_pair_bits(const struct rng8 *r, uint32_t dimension)
{
    struct sobol8_seeds s;
    rng8_seeds(r, dimension, &s);
    return sobol8_pair_bits(r->index_reversed, &s);
}

static inline struct sobol8_square rng8_pair(const struct rng8 *r, uint32_t dimension)
{
    struct sobol8_seeds s;
    rng8_seeds(r, dimension, &s);
    return sobol8_pair(r->index_reversed, &s);
}

static inline f32x8 rng8_single(const struct rng8 *r, uint32_t dimension)
{
    struct sobol8_seeds s;
    rng8_seeds(r, dimension, &s);
    return sobol8_float(sobol8_first_bits(r->index_reversed, s.shuffle, s.scramble_u));
}

/* --- the eight replicates of a pixel --- */

struct rng_pixel {
    struct rng replicate[FILM_REPLICATES]; /* at any index */
    struct sobol8_seeds filter;            /* of the dimension RNG_FILTER, by replicate */
};

static inline void rng_pixel_init(struct rng_pixel *p, uint64_t seed, uint32_t x_px, uint32_t y_px)
{
    const uint64_t key = rng_pixel_key(seed, x_px, y_px);
    struct rng8 eight;
    for (uint32_t i = 0; i < FILM_REPLICATES; i++)
        p->replicate[i] = (struct rng){rng_replicate_key(key, i), 0};
    rng8_make(&eight, p->replicate, FILM_REPLICATES);
    rng8_seeds(&eight, RNG_FILTER, &p->filter);
}

/* All go to point `index` of theirs: samples 8 index to 8 index + 7 of the pixel. */
static inline void rng_pixel_go(struct rng_pixel *p, uint32_t index)
{
    const uint32_t reversed = sobol_reverse(index);
    for (uint32_t i = 0; i < FILM_REPLICATES; i++)
        p->replicate[i].index_reversed = reversed;
}

/* The elders' pairs for the filter: the same for both siblings. */
static inline struct sobol8_square rng_pixel_filter(const struct rng_pixel *p)
{
    return sobol8_pair(u32x8_splat(rng_elder(&p->replicate[0]).index_reversed), &p->filter);
}

#endif
