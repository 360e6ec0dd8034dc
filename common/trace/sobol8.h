/* sobol8.h - sobol.h, eight points at once. The same bits.
 * SPDX-License-Identifier: MIT */
#ifndef COMMON_TRACE_SOBOL8_H
#define COMMON_TRACE_SOBOL8_H

#include "common/trace/simd.h"

struct sobol8_seeds { /* of a pair, by lane */
    u32x8 shuffle, scramble_u, scramble_v;
};

struct sobol8_bits {
    u32x8 u, v;
};

struct sobol8_square { /* points of the unit square */
    f32x8 u, v;
};

static inline u32x8 sobol8_scramble(u32x8 x, u32x8 seed)
{
    x ^= x * 0x3d20adeau;
    x += seed;
    x *= seed >> 16 | 1;
    x ^= x * 0x05526c56u;
    return x ^ x * 0x53a22864u;
}

static inline u32x8 sobol8_second(u32x8 i)
{
    i ^= i >> 16;
    i ^= i >> 8 & 0x00ff00ff;
    i ^= i >> 4 & 0x0f0f0f0f;
    i ^= i >> 2 & 0x33333333;
    return i ^ (i >> 1 & 0x55555555);
}

static inline f32x8 sobol8_float(u32x8 bits)
{
    return __builtin_convertvector((i32x8)(bits >> 8), f32x8) * 0x1p-24f;
}

static inline u32x8 sobol8_first_bits(u32x8 index_reversed, u32x8 shuffle, u32x8 scramble)
{
    const u32x8 index = u32x8_reverse(sobol8_scramble(index_reversed, shuffle));
    return u32x8_reverse(sobol8_scramble(index, scramble));
}

static inline struct sobol8_bits sobol8_pair_bits(u32x8 index_reversed,
                                                  const struct sobol8_seeds *s)
{
    const u32x8 index = u32x8_reverse(sobol8_scramble(index_reversed, s->shuffle));
    const u32x8 u = u32x8_reverse(sobol8_scramble(index, s->scramble_u));
    const u32x8 v = u32x8_reverse(sobol8_scramble(sobol8_second(index), s->scramble_v));
    return (struct sobol8_bits){u, v};
}

static inline struct sobol8_square sobol8_pair(u32x8 index_reversed, const struct sobol8_seeds *s)
{
    const struct sobol8_bits b = sobol8_pair_bits(index_reversed, s);
    return (struct sobol8_square){sobol8_float(b.u), sobol8_float(b.v)};
}

#endif
