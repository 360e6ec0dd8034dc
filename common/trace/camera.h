/* camera.h - pixel and sample to ray.
 *
 * A sample belongs to the pixel it was made for, with weight 1, and no other: the filter is the
 * density of its offset from the pixel's centre (M. Ernst, M. Stamminger, G. Greiner, "Filter
 * Importance Sampling", IEEE RT 2006). Hence tiles need no borders and never overlap.
 * SPDX-License-Identifier: MIT */
#ifndef COMMON_TRACE_CAMERA_H
#define COMMON_TRACE_CAMERA_H

#include "common/trace/ray.h"
#include "common/trace/sobol.h"
#include "common/trace/stage.h"

/* An offset in pixels, distributed as the filter: box and tent are symmetric and non-negative. */
float camera_filter(const struct scene_film *, float u);

/* The ray through a point of the frame, in pixels from its top left corner. */
struct ray camera_ray(const struct stage_camera *, float x_px, float y_px);

#endif
