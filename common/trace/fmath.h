/* fmath.h - our own elementary functions: the same bits on every machine.
 *
 * libm's sine differs in the last bit between versions, and a pixel would with it. Here are
 * only +, -, *, comparisons and conversions, which IEEE 754 fixes (with -ffp-contract=off).
 * Errors are below 2 ulp of the result (tests/test_fmath.c).
 * SPDX-License-Identifier: MIT */
#ifndef COMMON_TRACE_FMATH_H
#define COMMON_TRACE_FMATH_H

#include "common/base.h"

#define FMATH_PI      3.14159265f
#define FMATH_HALF_PI 1.57079633f
#define FMATH_INV_PI  0.318309886f

/* sin r and cos r for |r| <= pi/4 (and a rounding error more): r + r^3 P(r^2) and
 * 1 - r^2/2 + r^4 Q(r^2), P and Q interpolated at the Chebyshev nodes of [0, (pi/4)^2]. */
static inline void fmath_sincos_octant(float r, float *s, float *c)
{
    const float z = r * r;
    *s = r + r * z * (-0.166666642f + z * (0.00833274797f + z * -0.00019587866f));
    *c = 1 - 0.5f * z + z * z * (0.0416666642f + z * (-0.00138883025f + z * 2.45479168e-05f));
}

/* The angle r plus k right angles. */
static inline void fmath_sincos_quarters(float r, int k, float *s, float *c)
{
    float a, b;
    fmath_sincos_octant(r, &a, &b);
    const float sine = k & 1 ? b : a, cosine = k & 1 ? a : b;
    *s = k & 2 ? -sine : sine;
    *c = (k + 1) & 2 ? -cosine : cosine;
}

/* sin x and cos x for |x| <= 1e4. pi/2 is subtracted in two parts: the first has 33 significant
 * bits, so that its multiples are exact in double. */
static inline void fmath_sincos(float x, float *s, float *c)
{
    const double quarters = (double)x * 0.63661977236758134;
    const int k = (int)(quarters + (quarters < 0 ? -0.5 : 0.5));
    const double r = ((double)x - k * 0x1.921fb544p+0) - k * 0x1.0b4611a626331p-34;
    fmath_sincos_quarters((float)r, k, s, c);
}

/* sin and cos of u full turns, u in [0, 1]. The reduction is exact. */
static inline void fmath_sincos_turns(float u, float *s, float *c)
{
    const int k = (int)(4 * u + 0.5f);
    fmath_sincos_quarters((4 * u - (float)k) * FMATH_HALF_PI, k, s, c);
}

/* The angle of (x, y) from the x axis, in [-pi, pi]; 0 of (0, 0). In double, rounded once: atan r =
 * r + r^3 P(r^2) for |r| <= tan(pi/8), P interpolated at the Chebyshev nodes; beyond, pi/4 is taken
 * away. The sign of zero means nothing. */
static inline float fmath_atan2(float y, float x)
{
    const double a = x < 0 ? -(double)x : (double)x, b = y < 0 ? -(double)y : (double)y;
    if (!(a + b > 0))
        return 0;
    double r = a < b ? a / b : b / a, angle = 0;
    if (r > 0.41421356237309503) {
        angle = 0.78539816339744831;
        r = (r - 1) / (r + 1);
    }
    const double z = r * r;
    angle +=
        r +
        r * z *
            (-0.333333332792548 +
             z * (0.19999977258687 +
                  z * (-0.14284151193629 +
                       z * (0.11071365021885 + z * (-0.086246761452495 + z * 0.050481385120797)))));
    angle = a < b ? 1.5707963267948966 - angle : angle;
    angle = x < 0 ? 3.1415926535897932 - angle : angle;
    return (float)(y < 0 ? -angle : angle);
}

#endif
