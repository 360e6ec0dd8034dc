/* bsdf_conductor.h - metal: GGX facets (microfacet.h), sampled by those that are visible.
 *
 * Directions as in bsdf.h, wo and wi on the front side (z > 0).
 * SPDX-License-Identifier: MIT */
#ifndef COMMON_TRACE_BSDF_CONDUCTOR_H
#define COMMON_TRACE_BSDF_CONDUCTOR_H

#include "common/trace/bsdf.h"

rgb bsdf_conductor_eval(const struct material *, vec3 wo, vec3 wi);

float bsdf_conductor_pdf_w(const struct material *, vec3 wo, vec3 wi);

/* Also for what bsdf_is_delta says is smooth. */
bool bsdf_conductor_sample(const struct material *, vec3 wo, struct square direction,
                           struct bsdf_sample *);

#endif
