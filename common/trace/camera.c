/* SPDX-License-Identifier: MIT */
#include "common/trace/camera.h"

#include "common/trace/warp.h"

/* All members of struct stage_camera mean what stage.h says for the pinhole and the lens.
 * ORTHOGRAPHIC: origin is in the top left corner, dx and dy lead to other pixels' origins, corner
 * is all rays' direction. PANORAMIC: dx, dy, corner are right, up, ahead; unit. */

static vec3 step(const float from[3], const struct stage_camera *c, float x_px, float y_px)
{
    return vec3_load(from) + x_px * vec3_load(c->dx) + y_px * vec3_load(c->dy);
}

static struct ray ray_make(vec3 origin, vec3 dir)
{
    return (struct ray){origin, dir, __builtin_inff(), 0, 0};
}

/* The image plane is 1 deep, the plane in focus 1 / inv_focus: both in units of the latter. */
static struct ray lens_ray(const struct stage_camera *c, float x_px, float y_px, vec3 on_lens)
{
    const vec3 off = on_lens[0] * vec3_load(c->lens_x) + on_lens[1] * vec3_load(c->lens_y);
    const vec3 dir_raw = step(c->corner, c, x_px, y_px) - off * c->inv_focus;
    return ray_make(vec3_load(c->origin) + off, vec3_unit(dir_raw));
}

static void sincos_turns(float turns, float *s, float *c)
{
    fmath_sincos_turns(turns - __builtin_floorf(turns), s, c);
}

/* The filter may reach beyond the frame: to the left there is the right, above the pole what lies
 * behind it, since there the sine of the angle from above is negative. */
static struct ray panoramic_ray(const struct stage_camera *c, float x_px, float y_px)
{
    float to_right, ahead, across, up;
    sincos_turns(x_px * c->turns_x - 0.5f, &to_right, &ahead);
    sincos_turns(y_px * c->turns_y, &across, &up);
    const vec3 level = to_right * vec3_load(c->dx) + ahead * vec3_load(c->corner);
    return ray_make(vec3_load(c->origin), vec3_unit(across * level + up * vec3_load(c->dy)));
}

static struct ray ray_of(const struct stage_camera *c, float x_px, float y_px, vec3 on_lens)
{
    switch (c->kind) {
    case CAMERA_PERSPECTIVE:
        return ray_make(vec3_load(c->origin), vec3_unit(step(c->corner, c, x_px, y_px)));
    case CAMERA_THIN_LENS:
        return lens_ray(c, x_px, y_px, on_lens);
    case CAMERA_ORTHOGRAPHIC:
        return ray_make(step(c->origin, c, x_px, y_px), vec3_load(c->corner));
    case CAMERA_PANORAMIC:
        return panoramic_ray(c, x_px, y_px);
    }
    __builtin_unreachable();
}

struct ray camera_ray(const struct stage_camera *c, float x_px, float y_px)
{
    return ray_of(c, x_px, y_px, vec3_make(0, 0, 0));
}

struct ray camera_ray_through(const struct stage_camera *c, float x_px, float y_px,
                              struct square lens)
{
    return ray_of(c, x_px, y_px, c->blades ? warp_polygon(lens, c->blades) : warp_disc(lens));
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

void camera_rays_through(const struct stage_camera *c, f32x8 x_px, f32x8 y_px,
                         const struct sobol8_square *lens, struct camera_rays *rays)
{
    for (int i = 0; i < 8; i++) {
        const struct square q = {lens->u[i], lens->v[i]};
        const struct ray ray = camera_ray_through(c, x_px[i], y_px[i], q);
        for (int k = 0; k < 3; k++) {
            rays->origin[k][i] = ray.origin[k];
            rays->dir[k][i] = ray.dir[k];
        }
    }
}
