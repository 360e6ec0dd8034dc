/* bsdf_pane.h - a pane of glass without thickness: what two parallel faces reflect and let through.
 *
 * With F of one face and all reflections between the two, R = 2 F / (1 + F) is reflected, and the
 * rest goes straight on: nothing is bent, and radiance stays what it is. Both sides are alike.
 *
 * Directions as in bsdf.h, from either side. A delta material.
 * SPDX-License-Identifier: MIT */
#ifndef COMMON_TRACE_BSDF_PANE_H
#define COMMON_TRACE_BSDF_PANE_H

#include "common/trace/bsdf.h"

bool bsdf_pane_sample(const struct material *, vec3 wo, float lobe, struct bsdf_sample *);

#endif
