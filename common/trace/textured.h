/* textured.h - the material at a point of a surface: what stands in the document, with the values
 * of its textures put in.
 *
 * A material's slots say which of its members are driven by which textures. Where there are none,
 * which is most materials of most scenes, the material is used as it lies in the stage; else a copy
 * is made, in the caller's memory, and that is what the bsdf sees. So no bsdf knows of textures.
 * Values are kept in the parameter's range, whatever the texture says: energy stays at most 1.
 * SPDX-License-Identifier: MIT */
#ifndef COMMON_TRACE_TEXTURED_H
#define COMMON_TRACE_TEXTURED_H

#include "common/trace/surface_detail.h"
#include "common/trace/texture.h"

static inline bool textured_has(const struct material *m)
{
    return m->slot_begin != m->slot_end;
}

/* Whether it, or a material that it is made of, has: then prep gives its shapes a detail. */
static inline bool textured_needs(const struct material *m)
{
    return m->needs & (MATERIAL_NEEDS_UV | MATERIAL_NEEDS_COLOR);
}

/* Where textures are looked at for what a ray has hit: a shape whose material needs it. width: of
 * the ray's cone there, in m (cone.h).
 *
 * The footprint's area is that of the cone's square put onto the surface. Where the surface is seen
 * at a slant it is long, and the filter is round: of the same area it blurs less along the short
 * side than one as wide as the long side would. */
struct texture_point textured_point(const struct stage *, const struct ray *,
                                    const struct ray_hit *, const struct surface *at, float width);

/* m, or scratch. */
const struct material *textured_material(const struct stage *, const struct material *m,
                                         const struct texture_point *, struct material *scratch);

#endif
