/* dice.h - plain random numbers for tests, sharing nothing with rng.h: M. O'Neill's PCG-XSH-RR
 * (https://www.pcg-random.org), 32 bits out of a 64-bit state.
 * SPDX-License-Identifier: MIT */
#ifndef TESTS_DICE_H
#define TESTS_DICE_H

#include <math.h>

#include "common/base.h"

struct dice {
    uint64_t state;
};

static inline uint32_t dice_bits(struct dice *d)
{
    const uint64_t s = d->state;
    d->state = s * 6364136223846793005u + 1442695040888963407u;
    const uint32_t x = (uint32_t)((s >> 18 ^ s) >> 27), r = (uint32_t)(s >> 59);
    return x >> r | x << (-r & 31);
}

static inline struct dice dice_make(uint64_t seed)
{
    struct dice d = {seed * 0x9e3779b97f4a7c15u + 1};
    dice_bits(&d);
    d.state += seed;
    dice_bits(&d);
    return d;
}

/* [0, 1), 32 bits fine. */
static inline double dice_unit(struct dice *d)
{
    return dice_bits(d) * 0x1p-32;
}

/* [0, 1) as the core's samplers get it: 24 bits. */
static inline float dice_float(struct dice *d)
{
    return (float)(dice_bits(d) >> 8) * 0x1p-24f;
}

static inline double dice_range(struct dice *d, double from, double to)
{
    return from + (to - from) * dice_unit(d);
}

/* Standard normal: G. Box, M. Muller, Ann. Math. Stat. 29, 1958. */
static inline double dice_normal(struct dice *d)
{
    const double u = 1 - dice_unit(d), turn = 6.283185307179586 * dice_unit(d);
    return sqrt(-2 * log(u)) * cos(turn);
}

#endif
