/* srgb.h - the sRGB transfer function, IEC 61966-2-1, without libm.
 * SPDX-License-Identifier: MIT */
#ifndef COMMON_TRACE_SRGB_H
#define COMMON_TRACE_SRGB_H

#include "common/base.h"

/* Encoded to linear, both in [0, 1]. x^2.4 is x^2 times the fifth root of x^2; Newton's method for
 * y^5 = c comes down to that from 1, until it comes no further. */
static inline double srgb_linear(double encoded)
{
    if (encoded <= 0.04045)
        return encoded / 12.92;
    const double x = (encoded + 0.055) / 1.055, c = x * x;
    for (double y = 1;;) {
        const double next = (4 * y + c / (y * y * y * y)) / 5;
        if (!(next < y))
            return c * y;
        y = next;
    }
}

#endif
