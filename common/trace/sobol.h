/* sobol.h - the first two dimensions of the Sobol' sequence, scrambled and shuffled by hashing.
 *
 * B. Burley, "Practical Hash-based Owen Scrambling", JCGT 9(4), 2020. Points of the unit square:
 * every aligned block of 2^k indices has one point in each elementary interval of area 2^-k.
 * More dimensions are made by padding: independent seeds shuffle the index and scramble the
 * digits of each pair. There is no table and no largest dimension.
 *
 * Owen's scramble of a number's binary digits flips each by a random bit that depends on the
 * digits before it. On the number written backwards this is "each bit depends on lower bits only",
 * which sums and products have by nature. So everything here is kept written backwards: the index
 * is reversed once per sample, and the reversed index is already the (reversed) shuffled
 * index's first coordinate.
 * SPDX-License-Identifier: MIT */
#ifndef COMMON_TRACE_SOBOL_H
#define COMMON_TRACE_SOBOL_H

#include "common/base.h"

struct square { /* a point of the unit square: both in [0, 1), multiples of 2^-24 */
    float u, v;
};

struct sobol_bits { /* the same with all their bits: multiples of 2^-32 */
    uint32_t u, v;
};

static inline uint32_t sobol_reverse(uint32_t x)
{
    x = __builtin_bswap32(x);
    x = (x & 0x0f0f0f0f) << 4 | (x >> 4 & 0x0f0f0f0f);
    x = (x & 0x33333333) << 2 | (x >> 2 & 0x33333333);
    return (x & 0x55555555) << 1 | (x >> 1 & 0x55555555);
}

/* 64 bits: two numbers at once, which change places. */
static inline uint64_t sobol_reverse_both(uint64_t x)
{
    x = __builtin_bswap64(x);
    x = (x & 0x0f0f0f0f0f0f0f0f) << 4 | (x >> 4 & 0x0f0f0f0f0f0f0f0f);
    x = (x & 0x3333333333333333) << 2 | (x >> 2 & 0x3333333333333333);
    return (x & 0x5555555555555555) << 1 | (x >> 1 & 0x5555555555555555);
}

/* Owen's scramble of a reversed number. After S. Laine, T. Karras, "Stratified Sampling for
 * Stochastic Transparency", EGSR 2011, with the constants of N. Vegdahl, "Building a Better LK
 * Hash", 2021 (https://psychopath.io/post/2021_01_30_building_a_better_lk_hash). The multipliers
 * of the xor steps are even, so that no bit flips itself. */
static inline uint32_t sobol_scramble(uint32_t x, uint32_t seed)
{
    x ^= x * 0x3d20adeau;
    x += seed;
    x *= seed >> 16 | 1;
    x ^= x * 0x05526c56u;
    return x ^ x * 0x53a22864u;
}

/* The second coordinate of point i, reversed. Its generator matrix is Pascal's triangle modulo 2,
 * which is the five-fold Kronecker power of (1 1; 0 1): one step per factor. */
static inline uint32_t sobol_second(uint32_t i)
{
    i ^= i >> 16;
    i ^= i >> 8 & 0x00ff00ff;
    i ^= i >> 4 & 0x0f0f0f0f;
    i ^= i >> 2 & 0x33333333;
    return i ^ (i >> 1 & 0x55555555);
}

/* 32 random bits as a float in [0, 1): the leading 24 are exact. */
static inline float sobol_float(uint32_t bits)
{
    return (float)(bits >> 8) * 0x1p-24f;
}

static inline uint32_t sobol_first_bits(uint32_t index_reversed, uint32_t shuffle,
                                        uint32_t scramble)
{
    const uint32_t index = sobol_reverse(sobol_scramble(index_reversed, shuffle));
    return sobol_reverse(sobol_scramble(index, scramble));
}

static inline struct sobol_bits sobol_pair_bits(uint32_t index_reversed, uint32_t shuffle,
                                                uint32_t scramble_u, uint32_t scramble_v)
{
    const uint32_t index = sobol_reverse(sobol_scramble(index_reversed, shuffle));
    const uint32_t u = sobol_scramble(index, scramble_u);
    const uint32_t v = sobol_scramble(sobol_second(index), scramble_v);
    const uint64_t both = sobol_reverse_both((uint64_t)v << 32 | u);
    return (struct sobol_bits){(uint32_t)(both >> 32), (uint32_t)both};
}

static inline struct square sobol_pair(uint32_t index_reversed, uint32_t shuffle,
                                       uint32_t scramble_u, uint32_t scramble_v)
{
    const struct sobol_bits b = sobol_pair_bits(index_reversed, shuffle, scramble_u, scramble_v);
    return (struct square){sobol_float(b.u), sobol_float(b.v)};
}

#endif
