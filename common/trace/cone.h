/* cone.h - how wide a ray is, so that textures are looked at no more finely than the picture can
 * show.
 *
 * A cone around the ray: a width, and by how much it grows with each metre (T. Akenine-Möller et
 * al., "Improved Shader and Texture Level of Detail Using Ray Cones", JCGT 10(1), 2021). What a
 * surface's curvature does to it is passed over. At a camera ray's start it is half a pixel, since
 * the samples of a pixel are spread over it: the filter has only to reach from one to the next. A
 * mirror leaves the cone as it is; a lobe of density pdf_w widens it to what one of 64 samples of
 * it has to itself.
 *
 * Only made in scenes with image textures (stage.pyramids).
 * SPDX-License-Identifier: MIT */
#ifndef COMMON_TRACE_CONE_H
#define COMMON_TRACE_CONE_H

#include "common/base.h"

struct cone {
    float width;  /* m, where the ray is */
    float spread; /* m per m */
};

static inline struct cone cone_along(struct cone c, float distance)
{
    c.width += c.spread * distance;
    return c;
}

/* pdf_w: 0 for a mirror's direction. */
static inline struct cone cone_scatter(struct cone c, float pdf_w)
{
    if (pdf_w > 0) {
        const float own = 0.125f / __builtin_sqrtf(pdf_w);
        c.spread = c.spread > own ? c.spread : own;
    }
    return c;
}

#endif
