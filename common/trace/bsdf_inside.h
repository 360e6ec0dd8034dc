/* bsdf_inside.h - the principled material from inside the body that it bounds: wo.z < 0.
 *
 * The share that is clear lets light out as it lets it in (bsdf_glass.h, through coat and sheen,
 * tinted), and what coat and sheen keep of that comes back, having passed the tint twice: as a
 * mirror where the glass is smooth and the coat keeps it, else as said in inside.h. The share that
 * is not clear looks the same from both sides, as opaque materials do. A body of white loses
 * nothing.
 *
 * Directions as in bsdf.h; a sample's scale must be 1 before. SPDX-License-Identifier: MIT */
#ifndef COMMON_TRACE_BSDF_INSIDE_H
#define COMMON_TRACE_BSDF_INSIDE_H

#include "common/trace/bsdf.h"

rgb bsdf_inside_eval(const struct material *, vec3 wo, vec3 wi);

float bsdf_inside_pdf_w(const struct material *, vec3 wo, vec3 wi);

bool bsdf_inside_sample(const struct material *, vec3 wo, float lobe, struct square direction,
                        struct bsdf_sample *);

#endif
