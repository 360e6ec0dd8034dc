/* bsdf_metal.h - metal with more than bsdf_conductor.h has: two widths, turned about the normal
 * (facet.h), light that meets several facets (albedo.h), and a film that interferes (thinfilm.h).
 *
 * Where both widths are below BSDF_LEAST_ALPHA it is a mirror; where one is, it is widened to that.
 *
 * What several facets reflect is coloured more than what one does: with the mean reflectance F of a
 * facet, and the share E that leaves after one, it is F^2 E / (1 - F (1 - E)) (C. Kulla, A. Conty,
 * cited in albedo.h). Sampled with the
 * chance 1 - E(o).
 *
 * Directions as in bsdf.h, wo and wi on the front side (z > 0).
 * SPDX-License-Identifier: MIT */
#ifndef COMMON_TRACE_BSDF_METAL_H
#define COMMON_TRACE_BSDF_METAL_H

#include "common/trace/bsdf.h"

rgb bsdf_metal_eval(const struct material *, vec3 wo, vec3 wi);

float bsdf_metal_pdf_w(const struct material *, vec3 wo, vec3 wi);

/* Also for what bsdf_is_delta says is smooth. */
bool bsdf_metal_sample(const struct material *, vec3 wo, float lobe, struct square direction,
                       struct bsdf_sample *);

#endif
