/* bsdf_retro.h - retroreflectors: light goes back to where it came from, in a lobe around it.
 *
 * Beads and prisms turn light round: the law of rough facets (microfacet.h) with the light's
 * direction turned half round the normal, which keeps all that is known of it: reciprocal, no light
 * made, sampled by visible facets. Facets reflect the same at every angle.
 *
 * Directions as in bsdf.h, wo and wi on the front side (z > 0).
 * SPDX-License-Identifier: MIT */
#ifndef COMMON_TRACE_BSDF_RETRO_H
#define COMMON_TRACE_BSDF_RETRO_H

#include "common/trace/bsdf.h"

rgb bsdf_retro_eval(const struct material *, vec3 wo, vec3 wi);

float bsdf_retro_pdf_w(const struct material *, vec3 wo, vec3 wi);

/* Also for what bsdf_is_delta says is smooth. */
bool bsdf_retro_sample(const struct material *, vec3 wo, struct square direction,
                       struct bsdf_sample *);

#endif
