/* SPDX-License-Identifier: MIT */
#include "common/trace/camera.h"

f32x8 camera_filter(const struct scene_film *film, f32x8 u)
{
    switch (film->filter) {
    case FILTER_BOX:
        return (2 * u - 1) * film->filter_radius_px;
    case FILTER_TENT: { /* the inverse of the integral of 1 - |x|, one side at a time */
        const f32x8 left = f32x8_sqrt(2 * u) - 1, right = 1 - f32x8_sqrt(2 - 2 * u);
        return f32x8_choose(u < 0.5f, left, right) * film->filter_radius_px;
    }
    }
    __builtin_unreachable();
}

struct ray camera_ray(const struct stage_camera *c, float x_px, float y_px)
{
    const vec3 dir_raw = vec3_load(c->corner) + x_px * vec3_load(c->dx) + y_px * vec3_load(c->dy);
    return (struct ray){vec3_load(c->origin), vec3_unit(dir_raw), __builtin_inff(), 0, 0};
}

void camera_rays(const struct stage_camera *c, f32x8 x_px, f32x8 y_px, struct camera_rays *rays)
{
    f32x8 raw[3];
    for (int k = 0; k < 3; k++)
        raw[k] = c->corner[k] + x_px * c->dx[k] + y_px * c->dy[k];
    const f32x8 length = f32x8_sqrt(raw[0] * raw[0] + raw[1] * raw[1] + raw[2] * raw[2]);
    for (int k = 0; k < 3; k++)
        f32x8_store(rays->dir[k], raw[k] / length);
}
