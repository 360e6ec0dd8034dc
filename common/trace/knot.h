/* knot.h - tables looked at between their knots: linear interpolation.
 * SPDX-License-Identifier: MIT */
#ifndef COMMON_TRACE_KNOT_H
#define COMMON_TRACE_KNOT_H

struct knot { /* between i and i + 1 */
    int i;
    float f;
};

/* coordinate: 0 at the first knot, 1 at the last; beyond them the line through the outer two. At
 * least two knots. */
static inline struct knot knot_of(float coordinate, int knots)
{
    const float x = coordinate * (float)(knots - 1);
    const int i = x > 0 ? (int)x : 0, last = knots - 2;
    return (struct knot){i < last ? i : last, x - (float)(i < last ? i : last)};
}

/* The same, but beyond them what is there at the outer one. */
static inline struct knot knot_within(float coordinate, int knots)
{
    const struct knot k = knot_of(coordinate, knots);
    return (struct knot){k.i, k.f < 0 ? 0 : (k.f > 1 ? 1 : k.f)};
}

/* By a dielectric's index: even in the root of (n - 1) / (n + 1), from `least` to `most` of that.
 */
static inline struct knot knot_of_root_r(float ior, float least, float most, int knots)
{
    const float r = (ior - 1) / (ior + 1) - least;
    return knot_within(r > 0 ? __builtin_sqrtf(r / (most - least)) : 0, knots);
}

static inline float knot_blend(float a, float b, float f)
{
    return a + (b - a) * f;
}

#endif
