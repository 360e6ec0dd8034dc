/* bsdf_glass.h - the rough dielectric: GGX facets, each of which reflects and refracts.
 *
 * B. Walter et al., "Microfacet Models for Refraction through Rough Surfaces", EGSR 2007 (eq. 16,
 * 17, 20, 21). A visible facet is sampled; it reflects with the chance F of what it reflects, else
 * it refracts, so that weights are masking alone:
 *
 *     reflected  G2 / G1(o), height-correlated (microfacet.h)
 *     refracted  G1(i), times (near / far)^2 of radiance
 *
 * Refraction takes the product G1(o) G1(i). The correlation of reflection would be wrong there:
 * facets that o sees well are high, and from below high ones are seen worst. What heights give
 * exactly is the Beta function B(1 + L(o), 1 + L(i)) (E. Heitz et al., "Multiple-Scattering
 * Microfacet BSDFs with the Smith Model", SIGGRAPH 2016), which needs logarithms and powers; the
 * product lies between the two, is reciprocal, and makes no light: both weights are at most 1.
 * Light that meets a second facet is lost, or with `multiscatter` given back by a lobe over the
 * whole sphere (glass_albedo.h), sampled with the chance of what is missing.
 *
 * Directions as in bsdf.h, from either side; not for what bsdf_is_delta says is smooth.
 * SPDX-License-Identifier: MIT */
#ifndef COMMON_TRACE_BSDF_GLASS_H
#define COMMON_TRACE_BSDF_GLASS_H

#include "common/trace/bsdf.h"

rgb bsdf_glass_eval(const struct material *, vec3 wo, vec3 wi);

float bsdf_glass_pdf_w(const struct material *, vec3 wo, vec3 wi);

bool bsdf_glass_sample(const struct material *, vec3 wo, float lobe, struct square direction,
                       struct bsdf_sample *);

/* The lobe of several facets alone, for glass with `multiscatter`. */
float bsdf_glass_several_eval(const struct material *, vec3 wo, vec3 wi);

/* The share of light along wo that is in it, on both sides together. */
float bsdf_glass_several_missing(const struct material *, vec3 wo);

#endif
