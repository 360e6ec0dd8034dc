/* sphere_chart.h - the sphere of directions as a unit square, and integrals over parts of it.
 *
 *     s = (1 - cos of the angle to the axis) / 2 = width row / (1 + width - row),  turn = phi / 2
 * pi
 *
 * Half of the rows lie where s < width, more or less, and further out they widen as a GGX lobe of
 * alpha^2 = width around the axis thins out: in such a chart it is nearly even, however narrow it
 * is. With width 0 for "infinite" rows have equal areas. SPDX-License-Identifier: MIT */
#ifndef TESTS_STAT_SPHERE_CHART_H
#define TESTS_STAT_SPHERE_CHART_H

#include "common/base.h"
#include "common/vec.h"

struct sphere_chart {
    double x[3], y[3], z[3]; /* orthonormal, z the axis */
    double width;
};

struct sphere_chart sphere_chart_make(vec3 axis, double width);

struct sphere_place { /* both in [0, 1] */
    double row, turn;
};

vec3 sphere_chart_direction(const struct sphere_chart *, struct sphere_place);
struct sphere_place sphere_chart_place(const struct sphere_chart *, vec3 w);

struct sphere_integrand {
    double (*f)(const void *what, vec3 w); /* per solid angle */
    const void *what;
    int min_depth; /* a cell is halved both ways at least so often: more than 0 if f has edges */
    int max_depth;
    double tolerance; /* relative, of what halving once more changes; the noise of f's rounding is
                       * less */
    bool horizon;     /* f may have an edge where z = 0: cells that meet it are halved to the end */
    bool trust_zero;  /* a cell in which 9 points give 0 is 0: it is not halved */
};

/* Over the cell from `begin` to `end`, by adaptive quadrature. */
double sphere_chart_integral(const struct sphere_chart *, const struct sphere_integrand *,
                             struct sphere_place begin, struct sphere_place end);

#endif
