/* bsdf_cloth.h - a diffuse base under fibres (sheen.h): velvet, nylon, peach skin.
 *
 * The base gets what the fibres leave, T = 1 - colour E, channel by channel, as the base of a
 * plastic does (coat.h); so white cloth returns everything.
 *
 * Directions as in bsdf.h, wo and wi on the front side (z > 0).
 * SPDX-License-Identifier: MIT */
#ifndef COMMON_TRACE_BSDF_CLOTH_H
#define COMMON_TRACE_BSDF_CLOTH_H

#include "common/trace/bsdf.h"

rgb bsdf_cloth_eval(const struct material *, vec3 wo, vec3 wi);

float bsdf_cloth_pdf_w(const struct material *, vec3 wo, vec3 wi);

bool bsdf_cloth_sample(const struct material *, vec3 wo, float lobe, struct square direction,
                       struct bsdf_sample *);

#endif
