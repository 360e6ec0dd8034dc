/* several.h - where light goes that has met several facets of a rough surface.
 *
 * How much that is: albedo.h, glass_albedo.h. Of narrow lobes half of the directions are even in
 * z / (z + width), since what is missing of them is missing near the horizon; the others, and all
 * of the widest, by the cosine. Local directions, z > 0. SPDX-License-Identifier: MIT */
#ifndef COMMON_TRACE_SEVERAL_H
#define COMMON_TRACE_SEVERAL_H

#include "common/trace/warp.h"

/* Where less than this is missing on the whole, nothing is added: it is missing where o and i graze
 * alone, and the lobe would be too bright there to be found. */
#define SEVERAL_LEAST 0x1p-12f

static inline float several_low_share(float width)
{
    return 0.5f * (1 - width);
}

static inline vec3 several_low(struct square q, float width)
{
    const float z = q.v * width / (1 + width - q.v), r = __builtin_sqrtf(1 - z * z);
    float s, c;
    fmath_sincos_turns(q.u, &s, &c);
    return vec3_make(r * c, r * s, z);
}

static inline float several_pdf_w(vec3 i, float width)
{
    const float sum = i[2] + width, low = several_low_share(width);
    const float low_pdf_w = 0.5f * FMATH_INV_PI * width * (1 + width) / (sum * sum);
    return (1 - low) * warp_cosine_pdf_w(i[2]) + low * low_pdf_w;
}

/* number: in [0, 1). */
static inline vec3 several_direction(float number, struct square q, float width)
{
    return number < several_low_share(width) ? several_low(q, width) : warp_cosine(q);
}

#endif
