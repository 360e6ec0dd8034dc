/* bsdf_plastic.h - a diffuse base under a coat (coat.h): plastic, lacquered wood, glazed and
 * painted things.
 *
 * The coat's facets reflect once (microfacet.h); what passes reaches the base, goes to and fro
 * beneath the coat, and leaves. White under any coat returns everything, less what the table of a
 * rough one is off. The colour of the base is the deeper the more is reflected inside.
 *
 * Under a smooth coat there are two kinds of scattering, one of them into a single direction: eval
 * and pdf then are of the other alone (bsdf.h).
 *
 * Directions as in bsdf.h, wo and wi on the front side (z > 0).
 * SPDX-License-Identifier: MIT */
#ifndef COMMON_TRACE_BSDF_PLASTIC_H
#define COMMON_TRACE_BSDF_PLASTIC_H

#include "common/trace/bsdf.h"

rgb bsdf_plastic_eval(const struct material *, vec3 wo, vec3 wi);

float bsdf_plastic_pdf_w(const struct material *, vec3 wo, vec3 wi);

bool bsdf_plastic_sample(const struct material *, vec3 wo, float lobe, struct square direction,
                         struct bsdf_sample *);

#endif
