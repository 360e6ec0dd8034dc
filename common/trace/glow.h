/* glow.h - surfaces that shine as a texture says.
 *
 * Where light is looked for and where it is met by chance, the texture is looked at as finely as it
 * is, so that both find the same. Which emitter is chosen, and where on it, does not depend on the
 * texture. Values below 0 count as 0.
 * SPDX-License-Identifier: MIT */
#ifndef COMMON_TRACE_GLOW_H
#define COMMON_TRACE_GLOW_H

#include "common/trace/surface_detail.h"
#include "common/trace/texture.h"

/* emitter: STAGE_NONE, or a primitive's. */
static inline bool glow_is(const struct stage *s, uint32_t emitter)
{
    return emitter != STAGE_NONE && stage_emitter_at(s, emitter)->texture != STAGE_NONE;
}

/* The radiance of an emitter with a texture, at a point. */
rgb glow_at(const struct stage *, const struct emitter *, const struct texture_point *);
/* At a hit on it, as surface_detail_at takes it. */
rgb glow_on(const struct stage *, const struct emitter *, const struct ray_hit *,
            const struct surface *on);

#endif
