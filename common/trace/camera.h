/* camera.h - a point of the frame to a ray.
 *
 * Perspective is a pinhole. A thin lens has the pinhole's rays start all over its aperture and
 * meet again where the pinhole's meets the plane in focus (R. Cook, T. Porter, L. Carpenter,
 * "Distributed Ray Tracing", SIGGRAPH 1984), evenly by area: a point at the depth z is seen as a
 * disc of the diameter 2 radius |1 / z - 1 / focus| in the image plane one metre ahead.
 * Orthographic rays are parallel and start in the camera's plane. A panorama is the whole sphere by
 * longitude and latitude, its middle straight ahead. SPDX-License-Identifier: MIT */
#ifndef COMMON_TRACE_CAMERA_H
#define COMMON_TRACE_CAMERA_H

#include "common/trace/ray.h"
#include "common/trace/simd.h"
#include "common/trace/sobol.h"
#include "common/trace/sobol8.h"
#include "common/trace/stage.h"

/* The ray through a point of the frame, in pixels from its top left corner, and through a point of
 * the lens, which only a thin lens looks at. camera_ray: through its middle. */
struct ray camera_ray_through(const struct stage_camera *, float x_px, float y_px,
                              struct square lens);
struct ray camera_ray(const struct stage_camera *, float x_px, float y_px);

struct camera_rays { /* eight */
    _Alignas(32) float dir[3][8];
    _Alignas(32) float origin[3][8]; /* unless all start in the camera's own */
};

/* As camera_ray, to the last bit: of a perspective camera. */
void camera_rays(const struct stage_camera *, f32x8 x_px, f32x8 y_px, struct camera_rays *);
/* As camera_ray_through: of the others. */
void camera_rays_through(const struct stage_camera *, f32x8 x_px, f32x8 y_px,
                         const struct sobol8_square *lens, struct camera_rays *);

static inline struct ray camera_rays_at(const struct stage_camera *c, const struct camera_rays *r,
                                        uint32_t lane)
{
    return (struct ray){c->kind == CAMERA_PERSPECTIVE
                            ? vec3_load(c->origin)
                            : vec3_make(r->origin[0][lane], r->origin[1][lane], r->origin[2][lane]),
                        vec3_make(r->dir[0][lane], r->dir[1][lane], r->dir[2][lane]),
                        __builtin_inff(), 0, 0};
}

#endif
