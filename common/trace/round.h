/* round.h - bounds on floating-point rounding: N. Higham, "Accuracy and Stability of Numerical
 * Algorithms", 2nd ed., section 3.1.
 * SPDX-License-Identifier: MIT */
#ifndef COMMON_TRACE_ROUND_H
#define COMMON_TRACE_ROUND_H

#include "common/base.h"

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

#endif
