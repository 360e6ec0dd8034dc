/* The core must be compiled without contraction: a fused multiply-add in the triangle test's edge
 * function opens meshes at their edges, and changes pixels from machine to machine.
 * SPDX-License-Identifier: MIT */
#include "common/trace/bvh.h"
#include "tests/dice.h"
#include "tests/tap.h"

enum { PAIRS = 1000000 };

/* All 53 bits random, so that products are rounded. */
static double random_double(struct dice *d)
{
    return (dice_unit(d) + dice_unit(d) * 0x1p-32 - 0.5) * (double)(1 << dice_bits(d) % 20);
}

/* Each operation rounded for itself, whatever the compiler thinks it may join. */
static double edge_by_steps(double ax, double ay, double bx, double by)
{
    volatile double p = ax * by;
    volatile double q = ay * bx;
    volatile double e = p - q;
    return e;
}

int main(void)
{
    struct dice d = dice_make(11);
    int asymmetric = 0, different = 0, rounded = 0;
    for (int i = 0; i < PAIRS; i++) {
        const double ax = random_double(&d), ay = random_double(&d);
        const double bx = random_double(&d), by = random_double(&d);
        const double e = bvh_edge(ax, ay, bx, by);
        asymmetric += e != -bvh_edge(bx, by, ax, ay);
        different += e != edge_by_steps(ax, ay, bx, by);
        rounded += e != __builtin_fma(ax, by, -(ay * bx));
    }
    ok(asymmetric == 0, "E(a, b) == -E(b, a) bitwise for %d random pairs (%d differ)", PAIRS,
       asymmetric);
    ok(different == 0, "the core's E rounds every operation (%d of %d differ)", different, PAIRS);
    ok(rounded > PAIRS / 10, "the pairs would show a fused multiply-add (%d of %d)", rounded, PAIRS);
    return tap_done();
}
