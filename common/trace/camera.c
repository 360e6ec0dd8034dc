/* SPDX-License-Identifier: MIT */
#include "common/trace/camera.h"

float camera_filter(const struct scene_film *film, float u)
{
    switch (film->filter) {
    case FILTER_BOX:
        return (2 * u - 1) * film->filter_radius_px;
    case FILTER_TENT: /* the inverse of the integral of 1 - |x|, one side at a time */
        if (u < 0.5f)
            return (__builtin_sqrtf(2 * u) - 1) * film->filter_radius_px;
        return (1 - __builtin_sqrtf(2 - 2 * u)) * film->filter_radius_px;
    }
    __builtin_unreachable();
}

struct ray camera_ray(const struct stage_camera *c, float x_px, float y_px)
{
    const vec3 dir_raw = vec3_load(c->corner) + x_px * vec3_load(c->dx) + y_px * vec3_load(c->dy);
    return (struct ray){vec3_load(c->origin), vec3_unit(dir_raw), __builtin_inff()};
}
