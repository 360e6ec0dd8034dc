/* camera.h - pixel and sample to ray.
 *
 * A sample belongs to the pixel it was made for, with weight 1, and no other: the filter is the
 * density of its offset from the pixel's centre (M. Ernst, M. Stamminger, G. Greiner, "Filter
 * Importance Sampling", IEEE RT 2006). Hence tiles need no borders and never overlap.
 * SPDX-License-Identifier: MIT */
#ifndef COMMON_TRACE_CAMERA_H
#define COMMON_TRACE_CAMERA_H

#include "common/trace/ray.h"
#include "common/trace/simd.h"
#include "common/trace/stage.h"

/* Offsets in pixels, distributed as the filter: box and tent are symmetric and non-negative. */
f32x8 camera_filter(const struct scene_film *, f32x8 u);

/* The ray through a point of the frame, in pixels from its top left corner. */
struct ray camera_ray(const struct stage_camera *, float x_px, float y_px);

struct camera_rays { /* eight from one origin */
    _Alignas(32) float dir[3][8];
};

/* As camera_ray, to the last bit. */
void camera_rays(const struct stage_camera *, f32x8 x_px, f32x8 y_px, struct camera_rays *);

static inline struct ray camera_rays_at(const struct stage_camera *c, const struct camera_rays *r,
                                        uint32_t lane)
{
    return (struct ray){vec3_load(c->origin),
                        vec3_make(r->dir[0][lane], r->dir[1][lane], r->dir[2][lane]),
                        __builtin_inff(), 0, 0};
}

#endif
