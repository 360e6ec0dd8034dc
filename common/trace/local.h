/* local.h - local directions: z is the normal.
 * SPDX-License-Identifier: MIT */
#ifndef COMMON_TRACE_LOCAL_H
#define COMMON_TRACE_LOCAL_H

#include "common/vec.h"

/* To the other side of the surface. */
static inline vec3 local_flip(vec3 w)
{
    return vec3_make(w[0], w[1], -w[2]);
}

/* As a mirror in the surface does, w pointing away from it. */
static inline vec3 local_reflect(vec3 w)
{
    return vec3_make(-w[0], -w[1], w[2]);
}

#endif
