/* color.h - linear colour: Rec. 709 primaries, D65 white. Anything else is named.
 * SPDX-License-Identifier: MIT */
#ifndef COMMON_COLOR_H
#define COMMON_COLOR_H

#include "common/vec.h"

typedef vec3 rgb; /* r, g, b; lane 3 is never read */

static inline rgb rgb_gray(float v)
{
    return vec3_make(v, v, v);
}

/* Relative luminance: the Y row of the Rec. 709 / D65 matrix (ITU-R BT.709-6, item 3.2). */
static inline float rgb_luminance(rgb c)
{
    return 0.2126f * c[0] + 0.7152f * c[1] + 0.0722f * c[2];
}

static inline float rgb_max(rgb c)
{
    const float m = c[0] > c[1] ? c[0] : c[1];
    return m > c[2] ? m : c[2];
}

static inline bool rgb_is_black(rgb c)
{
    return c[0] == 0 && c[1] == 0 && c[2] == 0;
}

/* The sRGB transfer function, IEC 61966-2-1, without libm: encoded to linear, both in [0, 1]. x^2.4
 * is x^2 times the fifth root of x^2; Newton's method for y^5 = c comes down to that from 1, until
 * it comes no further. */
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
