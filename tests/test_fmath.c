/* fmath.h: accurate to the stated bounds, and the same bits on every machine.
 * SPDX-License-Identifier: MIT */
#include "common/trace/fmath.h"

#include <math.h>
#include <string.h>

#include "tests/dice.h"
#include "tests/stat/stat.h"
#include "tests/tap.h"

static double ulps(float got, double want)
{
    const float w = fabsf((float)want);
    const double ulp = (double)nextafterf(w, INFINITY) - (double)w;
    return fabs((double)got - want) / ulp;
}

static double worst_of_radians(float to, int n)
{
    struct dice dice = dice_make(1);
    double worst = 0;
    for (int i = 0; i < n; i++) {
        const float x = (float)dice_range(&dice, (double)-to, (double)to);
        float s, c;
        fmath_sincos(x, &s, &c);
        worst = fmax(worst, fmax(ulps(s, sin((double)x)), ulps(c, cos((double)x))));
    }
    return worst;
}

/* Floats next to multiples of pi/2: what the reduction leaves is the hardest there. */
static double worst_near_multiples(void)
{
    double worst = 0;
    for (int k = 1; k < 6366; k++) {
        const float x = (float)(k * 1.5707963267948966);
        float s, c;
        fmath_sincos(x, &s, &c);
        worst = fmax(worst, fmax(ulps(s, sin((double)x)), ulps(c, cos((double)x))));
    }
    return worst;
}

/* Every multiple of 2^-24, or some of them: ulp where the value is not near 0, absolute there. */
static double worst_of_turns(uint32_t step)
{
    double worst = 0;
    for (uint32_t i = 0; i <= 1u << 24; i += step) {
        const float u = (float)i * 0x1p-24f;
        float s, c;
        fmath_sincos_turns(u, &s, &c);
        const double turn = 6.283185307179586 * (double)u;
        worst = fmax(worst, fabs((double)s - sin(turn)));
        worst = fmax(worst, fabs((double)c - cos(turn)));
    }
    return worst * 0x1p24;
}

/* Magnitudes of 1e-20 to 1e20, and ratios near 1, near tan(pi/8) and of any size. */
static double worst_of_atan2(int n)
{
    struct dice dice = dice_make(2);
    double worst = 0;
    for (int i = 0; i < n; i++) {
        const double size = pow(10, dice_range(&dice, -20, 20));
        const double near[] = {1, 0.41421356237309503, pow(10, dice_range(&dice, -15, 15))};
        const double ratio = near[i % 3] * (1 + (i % 2 ? 1e-6 : 1) * dice_range(&dice, -.9, .9));
        const float x = (float)(dice_bits(&dice) & 1 ? size : -size);
        const float y = (float)(dice_bits(&dice) & 1 ? size * ratio : -size * ratio);
        worst = fmax(worst, ulps(fmath_atan2(y, x), atan2((double)y, (double)x)));
    }
    return worst;
}

static uint32_t digest_of_atan2(void)
{
    uint32_t h = 1;
    for (uint32_t i = 0; i < 100000; i++) {
        const float out = fmath_atan2((float)(i % 317) - 158, (float)(i % 211) - 105);
        uint32_t bits;
        memcpy(&bits, &out, sizeof bits);
        h = h * 31 + bits;
    }
    return h;
}

/* In units of 2^-52 of the result; of sine and cosine, of 1. */
static double worst_of_wide(int n)
{
    struct dice dice = dice_make(6);
    double worst = 0;
    for (int i = 0; i < n; i++) {
        const double y = dice_range(&dice, -1, 1) * exp2(-(i % 30)), x = dice_range(&dice, -1, 1);
        const double truth = atan2(y, x), angle = dice_range(&dice, -100, 100) * exp2(-(i % 30));
        double s, c;
        fmath_sincos_wide(angle, &s, &c);
        worst = fmax(worst, fabs(fmath_atan2_wide(y, x) / truth - 1));
        worst = fmax(worst, fmax(fabs(s - sin(angle)), fabs(c - cos(angle))));
    }
    return worst * 0x1p52;
}

static uint64_t digest_of_wide(void)
{
    uint64_t h = 1;
    for (uint32_t i = 0; i < 100000; i++) {
        double out[3];
        uint64_t bits[3];
        out[0] = fmath_atan2_wide((double)(i % 317) - 158, (double)(i % 211) - 105);
        fmath_sincos_wide(i * 0.001 - 50, &out[1], &out[2]);
        memcpy(bits, out, sizeof bits);
        for (int k = 0; k < 3; k++)
            h = h * 31 + bits[k];
    }
    return h;
}

static double worst_of_exp(int n)
{
    struct dice dice = dice_make(4);
    double worst = 0;
    for (int i = 0; i < n; i++) {
        const float x =
            (float)(i % 2 ? dice_range(&dice, -87, 0) : -exp(dice_range(&dice, -60, 4)));
        worst = fmax(worst, ulps(fmath_exp(x), exp((double)x)));
    }
    return worst;
}

static uint32_t digest(void)
{
    uint32_t h = 1;
    for (uint32_t i = 0; i < 100000; i++) {
        float out[2];
        uint32_t bits[2];
        fmath_sincos((float)i * 0.1f - 5000, &out[0], &out[1]);
        memcpy(bits, out, sizeof bits);
        h = (h * 31 + bits[0]) * 31 + bits[1];
    }
    return h;
}

int main(void)
{
    const int n = 2000000 / STAT_SLOW;
    ok(worst_of_radians(1, n) < 2, "sine and cosine on [-1, 1] within 2 ulp");
    ok(worst_of_radians(1e4f, n) < 2, "sine and cosine on [-1e4, 1e4] within 2 ulp");
    ok(worst_near_multiples() < 2, "sine and cosine next to multiples of pi/2 within 2 ulp");
    ok(worst_of_turns(STAT_SLOW == 1 ? 1 : 97) < 2, "turns within 2^-23");

    float s, c;
    fmath_sincos_turns(0.25f, &s, &c);
    ok(s == 1 && c == 0, "a quarter turn is exact");
    fmath_sincos(0, &s, &c);
    ok(s == 0 && c == 1, "no turn is exact");
    ok(digest() == 0x2d83ad85, "100000 values have the bits of every other build");

    ok(worst_of_atan2(n) < 1, "angles by atan2 within 1 ulp");
    ok(fmath_atan2(0, 0) == 0 && fmath_atan2(0, 1) == 0 && fmath_atan2(0, -1) == FMATH_PI &&
           fmath_atan2(2, 0) == FMATH_HALF_PI && fmath_atan2(-2, 0) == -FMATH_HALF_PI,
       "angles along the axes are exact, of no direction 0");
    ok(digest_of_atan2() == 0x78a942d1, "100000 angles have the bits of every other build");

    ok(worst_of_wide(n) <= 2, "angles, sine and cosine in double within 2^-51");
    ok(fmath_atan2_wide(0, 0) == 0 && fmath_atan2_wide(2, 0) == 1.5707963267948966 &&
           fmath_atan2_wide(0, -1) == 3.1415926535897932,
       "angles along the axes are exact in double, too");
    const uint64_t wide = digest_of_wide();
    ok(wide == 0x9ed06d496f0d730a, "100000 of them have the bits of every other build (%lx)",
       (unsigned long)wide);

    ok(worst_of_exp(n) < 1, "powers of e within 1 ulp");
    ok(fmath_exp(0) == 1 && fmath_exp(-88) == 0 && fmath_exp(-INFINITY) == 0,
       "e^0 is exact, far below it nothing is left");
    return tap_done();
}
