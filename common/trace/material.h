/* material.h - which material a ray finds at a point: through those that are made of others.
 *
 *     mix         one of two, by chance
 *     mask        another one, or nothing: the ray goes straight on
 *     two sided   one in front, one behind
 *
 * One number decides at each vertex, and what it chose is the vertex's material for everything that
 * is asked of it: sampling, densities and light straight from lamps. So an image is right on
 * average without any mixture being evaluated. That a ray goes on through a mask is decided before
 * (path_mask.h): material_at is what there is if it does not.
 *
 * Only for stages that say `wrapped`: else a point's material is what its shape names.
 * SPDX-License-Identifier: MIT */
#ifndef COMMON_TRACE_MATERIAL_H
#define COMMON_TRACE_MATERIAL_H

#include "common/trace/texture.h"

/* Whether it is made of others. */
static inline bool material_is_wrapped(const struct material *m)
{
    const uint32_t wrapped = 1u << MATERIAL_MIX | 1u << MATERIAL_MASK | 1u << MATERIAL_TWO_SIDED;
    return wrapped >> m->kind & 1;
}

/* What a ray meets: at the back of the material, or its front; point: where textures are looked at,
 * for a material that needs it (textured.h). */
struct material_side {
    uint32_t material;
    bool back;
    const struct texture_point *point;
};

/* Of the rays that meet it the share that it stops. */
float material_opacity(const struct stage *, const struct material_side *);

/* number: in [0, 1). The material as it lies in the stage: its own textures are still to be put in.
 */
const struct material *material_at(const struct stage *, const struct material_side *,
                                   float number);

#endif
