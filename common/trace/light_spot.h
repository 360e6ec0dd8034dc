/* light_spot.h - a point that shines into a cone.
 * SPDX-License-Identifier: MIT */
#ifndef COMMON_TRACE_LIGHT_SPOT_H
#define COMMON_TRACE_LIGHT_SPOT_H

#include "common/trace/stage.h"

/* Of the full intensity, what is left along dir (unit, away from the light): from 1 to 0 between
 * the two angles by s^2 (3 - 2 s), s linear in the cosine. 1 - cos is half the square of the chord,
 * which has digits for narrow cones, too. */
static inline float light_spot_falloff(const struct stage_spot *spot, vec3 dir)
{
    const vec3 chord = dir - vec3_load(spot->direction);
    const float k = 0.5f * vec3_dot(chord, chord);
    if (k >= spot->outer)
        return 0;
    if (k <= spot->inner)
        return 1;
    const float s = (spot->outer - k) / (spot->outer - spot->inner);
    return s * s * (3 - 2 * s);
}

#endif
