/* The mean over the pixels of the radiance that arrives is an integral over what they see: of
 * L W cos dA, W below being what a measure of image points makes of a solid angle or an area.
 * SPDX-License-Identifier: MIT */
#include "common/trace/study_lens.h"

#include "common/trace/fmath.h"

static bool in_window(const struct stage *s, double x_px, double y_px)
{
    const struct scene_film *f = &s->film;
    return x_px >= f->crop_x_begin && x_px < f->crop_x_end && y_px >= f->crop_y_begin &&
           y_px < f->crop_y_end;
}

static double pixels_of(const struct stage *s)
{
    const struct scene_film *f = &s->film;
    return (double)(f->crop_x_end - f->crop_x_begin) * (f->crop_y_end - f->crop_y_begin);
}

/* Where a step from the corner lies, in pixels; dx and dy are at right angles. */
static void place_of(const struct stage_camera *c, vec3 step, double *x_px, double *y_px)
{
    const vec3 dx = vec3_load(c->dx), dy = vec3_load(c->dy);
    *x_px = (double)(vec3_dot(step, dx) / vec3_dot(dx, dx));
    *y_px = (double)(vec3_dot(step, dy) / vec3_dot(dy, dy));
}

static double pixel_area(const struct stage_camera *c)
{
    return (double)vec3_length(vec3_cross(vec3_load(c->dx), vec3_load(c->dy)));
}

/* The image plane is 1 deep: a solid angle dw covers dw / cos^3 of it. */
static bool through_pinhole(const struct stage *s, vec3 from_eye, struct study_seen *out)
{
    const struct stage_camera *c = &s->camera;
    const vec3 ahead = vec3_unit(vec3_cross(vec3_load(c->dy), vec3_load(c->dx)));
    const vec3 corner = vec3_load(c->corner);
    const vec3 axis = vec3_dot(ahead, corner) < 0 ? -ahead : ahead;
    const float depth = vec3_dot(from_eye, axis), distance = vec3_length(from_eye);
    double x_px, y_px;
    if (!(depth > 0))
        return false;
    const float plane = vec3_dot(corner, axis);
    place_of(c, from_eye * (plane / depth) - corner, &x_px, &y_px);
    const double cosine = (double)(depth / distance);
    out->per_watt = (double)(plane * plane) / (cosine * cosine * cosine * (double)distance *
                                               (double)distance * pixel_area(c) * pixels_of(s));
    return in_window(s, x_px, y_px);
}

static bool through_panorama(const struct stage *s, vec3 from_eye, struct study_seen *out)
{
    const struct stage_camera *c = &s->camera;
    const vec3 dir = vec3_unit(from_eye);
    const float up = vec3_dot(dir, vec3_load(c->dy));
    const float right = vec3_dot(dir, vec3_load(c->dx)),
                ahead = vec3_dot(dir, vec3_load(c->corner));
    const float level = __builtin_sqrtf(right * right + ahead * ahead);
    if (!(level > 0))
        return false;
    const double turn = 2 * (double)FMATH_HALF_PI * 2;
    const double along = (double)fmath_atan2(right, ahead) / turn + 0.5;
    const double down = (double)fmath_atan2(level, up) / turn;
    const double x_px = along / (double)c->turns_x, y_px = down / (double)c->turns_y;
    const double pixel = turn * (double)c->turns_x * turn * (double)c->turns_y * (double)level;
    out->per_watt = 1 / (pixel * (double)vec3_dot(from_eye, from_eye) * pixels_of(s));
    return in_window(s, x_px, y_px);
}

bool study_lens_sees(const struct stage *s, const struct surface *at, struct study_seen *out)
{
    const struct stage_camera *c = &s->camera;
    const vec3 origin = vec3_load(c->origin), from_eye = at->p - origin;
    if (c->kind == CAMERA_ORTHOGRAPHIC) {
        const vec3 ahead = vec3_load(c->corner);
        const float depth = vec3_dot(from_eye, ahead);
        double x_px, y_px;
        place_of(c, from_eye, &x_px, &y_px);
        out->to_eye = -ahead;
        out->per_watt = 1 / (pixel_area(c) * pixels_of(s));
        out->ray = surface_to_point(at, at->p - depth * ahead);
        return depth > 0 && in_window(s, x_px, y_px);
    }
    out->to_eye = vec3_unit(-from_eye);
    out->ray = surface_to_point(at, origin);
    return c->kind == CAMERA_PANORAMIC ? through_panorama(s, from_eye, out)
                                       : through_pinhole(s, from_eye, out);
}
