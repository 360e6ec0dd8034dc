/* fmath.h - our own elementary functions: the same bits on every machine.
 *
 * libm's sine differs in the last bit between versions, and a pixel would with it. Here are
 * only +, -, *, /, square roots, comparisons and conversions, which IEEE 754 fixes (with
 * -ffp-contract=off).
 * Errors are below 2 ulp of the result, of the arc cosine 3 (tests/test_fmath.c).
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

/* e^x for x <= 0; what is below e^-87 is 0. In double, rounded once: x = k ln 2 + f, |f| <= ln 2 /
 * 2, and e^f by its series. */
static inline float fmath_exp(float x)
{
    if (!(x > -87))
        return 0;
    const int k = (int)((double)x * 1.4426950408889634 - 0.5);
    const double f = (double)x - k * 0.69314718055994531;
    double p = 1 + f / 9;
    for (int n = 8; n > 0; n--)
        p = 1 + f / n * p;
    const uint32_t bits = (uint32_t)(k + 127) << 23;
    float scale;
    __builtin_memcpy(&scale, &bits, sizeof scale);
    return (float)p * scale;
}

/* sin and cos of u full turns, u in [0, 1]. The reduction is exact. */
static inline void fmath_sincos_turns(float u, float *s, float *c)
{
    const int k = (int)(4 * u + 0.5f);
    fmath_sincos_quarters((4 * u - (float)k) * FMATH_HALF_PI, k, s, c);
}

/* The angle in [0, pi/2] whose cosine is x, x in [0, 1]: sqrt(1 - x) P(x), P interpolated at the
 * Chebyshev nodes. */
static inline float fmath_acos(float x)
{
    const float p =
        x *
        (-0.214601159f +
         x * (0.0890301391f +
              x * (-0.0505935736f +
                   x * (0.0325711705f +
                        x * (-0.0207276661f +
                             x * (0.0110283811f + x * (-0.00397457788f + x * 0.000684531813f)))))));
    return __builtin_sqrtf(1 - x) * (FMATH_HALF_PI + p);
}

/* log2 of a normal number above 0, to 1e-12: with x = 2^n m, m in [3/4, 3/2), and
 * t = (m - 1) / (m + 1), the series 2 / ln 2 (t + t^3 / 3 + ...). */
static inline double fmath_log2(double x)
{
    uint64_t bits;
    __builtin_memcpy(&bits, &x, sizeof bits);
    const int64_t n = (int64_t)(bits - 0x3fe8000000000000u) >> 52;
    bits -= (uint64_t)n << 52;
    double m;
    __builtin_memcpy(&m, &bits, sizeof m);
    const double t = (m - 1) / (m + 1), z = t * t;
    const double p =
        1 + z * (1.0 / 3 +
                 z * (1.0 / 5 +
                      z * (1.0 / 7 + z * (1.0 / 9 + z * (1.0 / 11 + z * (1.0 / 13 + z / 15))))));
    return (double)n + 2.8853900817779268 * t * p;
}

/* 2^x for |x| <= 1000, to 1e-12: the whole part into the exponent, the rest, at most a half, by the
 * exponential series. */
static inline double fmath_exp2(double x)
{
    const int n = (int)(x + (x < 0 ? -0.5 : 0.5));
    const double f = (x - n) * 0.69314718055994531;
    double p = 1 + f / 11;
    for (int k = 10; k > 0; k--)
        p = 1 + f / k * p;
    const uint64_t bits = (uint64_t)(n + 1023) << 52;
    double scale;
    __builtin_memcpy(&scale, &bits, sizeof scale);
    return p * scale;
}

/* x^y for x >= 0 and y > 0; what is below 2^-126 is 0. */
static inline float fmath_pow(float x, float y)
{
    if (!(x > 0))
        return 0;
    const double e = (double)y * fmath_log2((double)x);
    return e < -126 ? 0 : (float)fmath_exp2(e);
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

/* --- for what is worked out in double --- */

/* sin x and cos x for |x| <= 100, to 2^-51: quarter turns are subtracted in two parts, as in
 * fmath_sincos, and what is left goes into the series. */
static inline void fmath_sincos_wide(double x, double *s, double *c)
{
    const double quarters = x * 0.63661977236758134;
    const int k = (int)(quarters + (quarters < 0 ? -0.5 : 0.5));
    const double r = (x - k * 0x1.921fb544p+0) - k * 0x1.0b4611a626331p-34, z = r * r;
    double sine = 1, cosine = 1;
    for (int n = 18; n > 0; n -= 2) {
        sine = 1 - z * (1.0 / (n * (n + 1))) * sine;
        cosine = 1 - z * (1.0 / (n * (n - 1))) * cosine;
    }
    sine *= r;
    const double a = k & 1 ? cosine : sine, b = k & 1 ? sine : cosine;
    *s = k & 2 ? -a : a;
    *c = (k + 1) & 2 ? -b : b;
}

/* As fmath_atan2, to 2^-51 of the result: the quotient r <= 1 is that of the angle whose tangent is
 * its nearest quarter, and of a rest below 1/8, which goes into the series. */
static inline double fmath_atan2_wide(double y, double x)
{
    static const double known[] = {0, 0.24497866312686415, 0.46364760900080612, 0.64350110879328438,
                                   0.78539816339744831};
    const double a = x < 0 ? -x : x, b = y < 0 ? -y : y;
    if (!(a + b > 0))
        return 0;
    const double low = a < b ? a : b, high = a < b ? b : a;
    const int k = (int)(4 * (low / high) + 0.5);
    const double t = k * 0.25, r = (low - t * high) / (high + t * low), z = r * r;
    double p = 0;
    for (int n = 17; n > 0; n -= 2)
        p = 1.0 / n - z * p;
    double angle = known[k] + r * p;
    angle = a < b ? 1.5707963267948966 - angle : angle;
    angle = x < 0 ? 3.1415926535897932 - angle : angle;
    return y < 0 ? -angle : angle;
}

#endif
