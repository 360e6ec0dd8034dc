/* ray.h - a ray and what it hits.
 * SPDX-License-Identifier: MIT */
#ifndef COMMON_TRACE_RAY_H
#define COMMON_TRACE_RAY_H

#include "common/trace/stage.h"

struct ray {
    vec3 origin;
    vec3 dir;    /* need not be unit: t counts lengths of dir */
    float t_max; /* hits have 0 < t < t_max; may be +infinity */
    /* 1 + the number of the primitive on which it starts and of that on which it ends; 0: of none.
     * A triangle among these is not hit. (A plane is met once, so it could only be by rounding: but
     * without being told, a kernel has to find out exactly, for nearly every ray.) */
    uint32_t from, to;
};

struct ray_hit {
    float t;
    uint32_t prim; /* number of the primitive (stage.h) */
    float u, v;    /* triangle: barycentric weights of vertices 1 and 2; else 0 */
    struct stage_place place;
    uint32_t instance; /* or STAGE_NONE */
};

#endif
