/* light_sun.h - a disc in the sky, as large to every point of the scene: uniform in the cone it
 * fills.
 *
 * Whether a direction meets it is judged by the chord to its middle, which for two unit vectors is
 * sqrt(2 (1 - cos)): the cosine of a narrow cone has no digits left in float.
 * SPDX-License-Identifier: MIT */
#ifndef COMMON_TRACE_LIGHT_SUN_H
#define COMMON_TRACE_LIGHT_SUN_H

#include "common/trace/stage.h"
#include "common/trace/warp.h"

static inline vec3 light_sun_direction(const struct emitter *e, struct square q)
{
    const struct warp_frame f = warp_frame_make(-vec3_load(e->at));
    return vec3_unit(warp_to_world(&f, warp_cap(q, e->cap)));
}

/* dir: unit. A direction that light_sun_direction gives is inside, wherever its rounding, of up to
 * 2^-22, has put it. */
static inline bool light_sun_meets(const struct emitter *e, vec3 dir)
{
    const vec3 chord = dir + vec3_load(e->at);
    const float most = __builtin_sqrtf(2 * e->cap) + 0x1p-22f;
    return vec3_dot(chord, chord) <= most * most;
}

static inline float light_sun_pdf_w(const struct emitter *e)
{
    return warp_cap_pdf_w(e->cap);
}

#endif
