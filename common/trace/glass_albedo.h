/* glass_albedo.h - how much light rough glass (bsdf_glass.h) loses in facets after the first.
 *
 * The share of light from w that one facet neither reflects above the surface nor refracts below it
 * is tabled by quadrature (tests/tool_glass.c), for either side. What several facets do with it is
 * a lobe like metal's (C. Kulla, A. Conty, cited in albedo.h), over the whole sphere: from o on a
 * side of index n(o) to i,
 *
 *     f |i.z| = missing(o) missing(i) n(o)^2 |i.z| / (pi (mean above + n^2 mean below)),
 *
 * n(o) 1 above and n below. It is reciprocal as refraction is, f n(i)^2 the same both ways; and it
 * returns missing(o), the share n(i)^2 mean(i) of it to either side: light that met many facets is
 * even among all ways out that facets block.
 *
 * What is stored is less than what is missing by 0.005, which is more than the error between knots.
 * So of light on rough glass 98 % to 100.1 % come out. Below an index of 1.1 a part of it is put
 * back, none at 1. SPDX-License-Identifier: MIT */
#ifndef COMMON_TRACE_GLASS_ALBEDO_H
#define COMMON_TRACE_GLASS_ALBEDO_H

#include "common/base.h"

enum { GLASS_ALBEDO_IORS = 13, GLASS_ALBEDO_WIDTHS = 17, GLASS_ALBEDO_HEIGHTS = 33 };

/* Evenly spaced: the root of (n - 1) / (n + 1) from that of 1.1, up to 4; sqrt(alpha) from 0 to 1;
 * the height of albedo.c. Shares in units of 1 / 65535; [0]: seen from above, [1]: from below. */
struct glass_albedo_table {
    uint16_t missing[2][GLASS_ALBEDO_IORS][GLASS_ALBEDO_WIDTHS][GLASS_ALBEDO_HEIGHTS];
    float mean[2][GLASS_ALBEDO_IORS][GLASS_ALBEDO_WIDTHS]; /* as missing is read */
};

extern const struct glass_albedo_table glass_albedo_table;

struct glass_albedo {
    float ior, alpha; /* below over above, at least 1 */
};

/* cos in [0, 1], from the normal on its side. */
float glass_albedo_missing(const struct glass_albedo *, bool below, float cos);
float glass_albedo_missing_by(const struct glass_albedo_table *, const struct glass_albedo *,
                              bool below, float cos);

/* Its mean, weighted by the cosine. */
float glass_albedo_mean(const struct glass_albedo *, bool below);

#endif
