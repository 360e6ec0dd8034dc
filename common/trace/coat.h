/* coat.h - a boundary between air and something clear, smooth or rough: how much light passes it.
 *
 * What GGX facets (microfacet.h) of a dielectric reflect once, F and masking included, is E(z); all
 * else passes, 1 - E(z). So nothing is lost above a coat, and it is an interface that layers can be
 * put under without knowing how light gets through it: by energy and reciprocity alone,
 *
 *     base   T(o) T(i) / (pi T_avg) k,   T = 1 - E, T_avg its mean weighted by the cosine,
 *     k      albedo (1 - R) / (1 - albedo R),   R = 1 - T_avg / n^2,
 *
 * where R is what of even light inside is reflected back inside (S. Duntley, "The Optical
 * Properties of Diffusing Materials", JOSA 32, 1942; C. Kelemen, L. Szirmay-Kalos, "A Microfacet
 * Based Coupled Specular-Matte BRDF Model with Importance Sampling", Eurographics 2001 short
 * papers). With a smooth coat this is exact.
 *
 * A rough coat's T is tabled (tests/tool_coat.c) and too small by up to 0.012, so that layers do
 * not make light. SPDX-License-Identifier: MIT */
#ifndef COMMON_TRACE_COAT_H
#define COMMON_TRACE_COAT_H

#include "common/color.h"

struct coat {
    float ior;   /* below over above, in [1.1, 3] */
    float alpha; /* GGX width; below BSDF_LEAST_ALPHA it is smooth */
};

/* T(z), z in [0, 1]. */
float coat_passes(const struct coat *, float cos);

float coat_passes_mean(const struct coat *);

/* k: what of the light that passes to a diffuse base comes back, however often it was sent down
 * again; mean: coat_passes_mean. */
rgb coat_base(const struct coat *, float mean, rgb albedo);

#endif
