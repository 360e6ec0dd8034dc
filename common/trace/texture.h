/* texture.h - what a texture is at a point of a surface.
 *
 * Images are pyramids of ever coarser levels, each half as large (L. Williams, "Pyramidal
 * Parametrics", SIGGRAPH 1983): level 0 is the image as it was, or nearly so (enum stage_texels),
 * and those above hold means over exactly the pixels that they cover, linear, so that no level is
 * brighter than another. Where the footprint of a ray is wider than a pixel, the two levels between
 * which its width lies are looked at and mixed.
 *
 * uv origin bottom left; row 0 of an image is at the top. The same bits everywhere.
 * SPDX-License-Identifier: MIT */
#ifndef COMMON_TRACE_TEXTURE_H
#define COMMON_TRACE_TEXTURE_H

#include "common/trace/stage.h"

struct texture_point {
    float u, v;
    float area; /* of the footprint, in units of u times units of v; >= 0, may be infinite */
    rgb color;  /* of the mesh's vertices */
};

struct texture_value {
    rgb color;   /* linear */
    float alpha; /* 1 where the image has none */
};

struct texture_value texture_at(const struct stage *, uint32_t texture,
                                const struct texture_point *);

float texture_channel(const struct texture_value *, enum material_channel);

/* How fast a channel of an image grows along u and v, per unit of them: the difference over as much
 * of the image as the ray is wide, a texel at least. */
struct texture_slope {
    float du, dv;
};

struct texture_slope texture_slope(const struct stage *, uint32_t texture,
                                   const struct texture_point *, enum material_channel);

/* --- of a pyramid alone --- */

enum { TEXTURE_ALPHA = 3 }; /* the lane */

/* A texel with alpha in lane 3, decoded; gray in all of the first three. */
vec3 texture_texel(const struct stage *, const struct stage_pyramid *, uint32_t level, uint32_t x,
                   uint32_t y);

static inline uint32_t texture_level_px(uint32_t side_px, uint32_t level)
{
    return side_px >> level > 0 ? side_px >> level : 1;
}

#endif
