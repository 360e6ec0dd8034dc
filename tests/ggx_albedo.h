/* ggx_albedo.h - what GGX facets reflect, by quadrature in double.
 *
 * Written from the formulas, with nothing of common/trace/facet.h: an oracle.
 * SPDX-License-Identifier: MIT */
#ifndef TESTS_GGX_ALBEDO_H
#define TESTS_GGX_ALBEDO_H

#include "common/base.h"

struct ggx_albedo {
    double x, y;     /* widths */
    double cos, phi; /* the direction that light comes from */
};

/* The share that facets which reflect everything send away from the surface: the mean of G2 / G1
 * over n x n midpoints of the square that visible facets are made from. */
double ggx_albedo(const struct ggx_albedo *, uint32_t n);

/* The same from G1 D / (4 mu) alone, without masking of what leaves, and over the whole sphere: 1
 * if D and G1 belong together (E. Heitz's weak white furnace), by integrating over directions. */
double ggx_albedo_weak(const struct ggx_albedo *, uint32_t n);

#endif
