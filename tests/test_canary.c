/* The contraction canary: watertightness rests on edge functions that are exact negatives of each
 * other, which a fused multiply-add silently breaks. Functions marked CORE are compiled for the
 * core's instruction set, where the compiler has that instruction and uses it unless it is told not
 * to. SPDX-License-Identifier: MIT */
#include "common/trace/tri.h"

#include <string.h>

#include "tests/dice.h"
#include "tests/tap.h"

#define CORE __attribute__((target("arch=x86-64-v3"), noinline))

enum { PAIRS = 1000000 };

struct pair {
    float a[2], b[2];
};

CORE static float edge(float ax, float ay, float bx, float by)
{
    return tri_edge(ax, ay, bx, by);
}

/* What the compiler would make of tri_edge when it may contract. */
CORE static float edge_fused(float ax, float ay, float bx, float by)
{
    return __builtin_fmaf(ax, by, -(ay * bx));
}

CORE static float edge_exact(float ax, float ay, float bx, float by)
{
    return tri_edge_exact(ax, ay, bx, by);
}

typedef float edge_fn(float, float, float, float);

/* A difference of equal products is +0 both ways: zeros count as opposite. */
static bool is_opposite(float x, float y)
{
    const float minus_y = -y;
    return memcmp(&x, &minus_y, sizeof x) == 0 || (x == 0 && y == 0);
}

static int count_violations(edge_fn *f, double spread)
{
    struct dice d = dice_make(11);
    int violations = 0;
    for (int i = 0; i < PAIRS; i++) {
        struct pair p;
        for (int k = 0; k < 2; k++) {
            p.a[k] = (float)dice_range(&d, -1, 1);
            p.b[k] = p.a[k] + (float)dice_range(&d, -spread, spread);
        }
        const float ab = f(p.a[0], p.a[1], p.b[0], p.b[1]), ba = f(p.b[0], p.b[1], p.a[0], p.a[1]);
        violations += !is_opposite(ab, ba);
    }
    return violations;
}

/* The sign decides in or out; of the float version it is either right or hidden by a zero. */
static int count_wrong_signs(void)
{
    struct dice d = dice_make(12);
    int wrong = 0;
    for (int i = 0; i < PAIRS; i++) {
        const float ax = (float)dice_range(&d, 1, 2), ay = (float)dice_range(&d, 1, 2);
        const float scale = (float)dice_range(&d, 1, 2);
        const float bx = ax * scale, by = ay * scale; /* all but parallel */
        const double exact = (double)ax * (double)by - (double)ay * (double)bx;
        float e = edge(ax, ay, bx, by);
        e = e == 0 ? edge_exact(ax, ay, bx, by) : e;
        wrong += (e > 0) != (exact > 0) || (e < 0) != (exact < 0);
    }
    return wrong;
}

int main(void)
{
    ok(count_violations(edge, 1) == 0,
       "F-11: edge functions are antisymmetric to the last bit, 1e6 pairs");
    ok(count_violations(edge, 1e-6) == 0, "also of points that nearly coincide");
    ok(count_violations(edge_exact, 1e-6) == 0, "the double version is antisymmetric, too");
    const int fused = count_violations(edge_fused, 1);
    ok(fused > PAIRS / 4, "F-11: a fused multiply-add would be noticed: %d violations of 1e6", fused);
    ok(count_wrong_signs() == 0,
       "the sign of an edge function is right, 1e6 nearly parallel pairs");
    return tap_done();
}
