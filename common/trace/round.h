/* round.h - bounds on floating-point rounding: N. Higham, "Accuracy and Stability of Numerical
 * Algorithms", 2nd ed., section 3.1.
 * SPDX-License-Identifier: MIT */
#ifndef COMMON_TRACE_ROUND_H
#define COMMON_TRACE_ROUND_H

#include "common/trace/simd.h"

#define ROUND_UNIT 0x1p-24f /* half the distance from 1 to the next float */

/* n roundings in a row change a value by at most this part of it. */
static inline float round_gamma(int n)
{
    return (float)n * ROUND_UNIT / (1 - (float)n * ROUND_UNIT);
}

/* The next float towards +infinity, towards -infinity; infinities and NaNs stay. */
static inline float round_up(float x)
{
    union {
        float f;
        int32_t i;
    } b = {x};
    if (!(x < __builtin_inff()))
        return x;
    if (x == 0)
        return 0x1p-149f;
    b.i += x > 0 ? 1 : -1;
    return b.f;
}

static inline float round_down(float x)
{
    return -round_up(-x);
}

/* Each coordinate of p to the next float on the side that `way` points to; where that is 0 it
 * stays. As round_up and round_down, without a branch: the signs are anybody's guess. */
static inline vec3 round_along(vec3 p, vec3 way)
{
    const vec3 zero = {0, 0, 0, 0};
    const i32x4 down = way < zero;
    const i32x4 mirror = down & INT32_MIN; /* down is up for -p */
    const vec3 x = (vec3)((i32x4)p ^ mirror);
    const i32x4 bits = (i32x4)x & (x != zero); /* -0 is 0 */
    const i32x4 next = bits + ((x < zero) | 1);
    const i32x4 moves = (down | (way > zero)) & (x < zero + __builtin_inff());
    return vec3_choose(moves, (vec3)(next ^ mirror), p);
}

#endif
