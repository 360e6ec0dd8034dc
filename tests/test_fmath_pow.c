/* fmath.h's arc cosine, logarithm and powers: accurate, and the same bits on every machine.
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

static double worst_of_acos(uint32_t step)
{
    double worst = 0;
    for (uint32_t i = 0; i <= 1u << 24; i += step) {
        const float x = (float)i * 0x1p-24f;
        worst = fmax(worst, ulps(fmath_acos(x), acos((double)x)));
    }
    return worst;
}

static double worst_of_powers(int n)
{
    struct dice dice = dice_make(2);
    double worst = 0;
    for (int i = 0; i < n; i++) {
        const double x = exp(dice_range(&dice, -20, 20)), y = exp(dice_range(&dice, -7, 7));
        const float base = (float)x, power = (float)y;
        const double want = pow((double)base, (double)power);
        if (want < 0x1p-126 || want > 0x1p+127)
            continue;
        worst = fmax(worst, ulps(fmath_pow(base, power), want));
        worst = fmax(worst, fabs(fmath_log2(x) - log2(x)) * 1e11);
    }
    return worst;
}

static uint32_t bits_of(float x)
{
    uint32_t bits;
    memcpy(&bits, &x, sizeof bits);
    return bits;
}

static uint32_t digest(void)
{
    uint32_t h = 1;
    for (uint32_t i = 1; i <= 100000; i++) {
        const float x = (float)i * 1e-5f;
        h = (h * 31 + bits_of(fmath_acos(x))) * 31 + bits_of(fmath_pow(x, 1e-3f * (float)i));
    }
    return h;
}

int main(void)
{
    const int n = 2000000 / STAT_SLOW;
    ok(worst_of_acos(STAT_SLOW == 1 ? 1 : 97) < 3, "arc cosine on [0, 1] within 3 ulp");
    ok(worst_of_powers(n) < 1, "powers within an ulp, logarithms to 1e-11");
    ok(fmath_acos(1) == 0 && fmath_pow(1, 1e3f) == 1 && fmath_pow(0, 1) == 0 &&
           fmath_pow(0x1p-20f, 10) == 0 && fmath_exp2(-3) == 0.125 && fmath_log2(0.25) == -2,
       "what is exact is exact");
    ok(digest() == 0xca325b86, "100000 values have the bits of every other build (%08x)",
       (unsigned)digest());
    return tap_done();
}
