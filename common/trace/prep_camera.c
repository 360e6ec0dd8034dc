/* The camera: what camera.c needs of it, per pixel.
 * SPDX-License-Identifier: MIT */
#include "common/trace/fmath.h"
#include "common/trace/prep_plan.h"

/* The image plane one metre ahead, by its top left corner and its pixels. */
static void aim(struct stage_camera *c, const struct scene *scene)
{
    const struct scene_film *film = &scene->film;
    const struct xform *m = &scene->camera.to_world;
    float sine, cosine;
    fmath_sincos(scene->camera.fov_y_rad / 2, &sine, &cosine);
    const float half_y = sine / cosine;
    const float pixel = 2 * half_y / (float)film->height_px;
    const float half_x = pixel * (float)film->width_px / 2;
    vec3_store(c->corner, xform_vector(m, vec3_make(-half_x, half_y, -1)));
    vec3_store(c->dx, xform_vector(m, vec3_make(pixel, 0, 0)));
    vec3_store(c->dy, xform_vector(m, vec3_make(0, -pixel, 0)));
}

static void open_lens(struct stage_camera *c, const struct scene_camera *from)
{
    float sine, cosine;
    fmath_sincos_turns(from->blades_turn, &sine, &cosine);
    const vec3 x = vec3_make(cosine, sine, 0), y = vec3_make(-sine, cosine, 0);
    vec3_store(c->lens_x, xform_vector(&from->to_world, x) * from->lens_radius);
    vec3_store(c->lens_y, xform_vector(&from->to_world, y) * from->lens_radius);
    c->inv_focus = 1 / from->focus;
    c->blades = from->blades;
}

/* Rays start on the plane through the camera, so that nothing behind it is seen. */
static void aim_orthographic(struct stage_camera *c, const struct scene *scene)
{
    const struct scene_film *film = &scene->film;
    const struct scene_camera *from = &scene->camera;
    const float columns = (float)film->width_px, rows = (float)film->height_px;
    const float pixel = from->height > 0 ? from->height / rows : from->width / columns;
    const vec3 corner = vec3_make(-pixel * columns / 2, pixel * rows / 2, 0);
    vec3_store(c->origin, xform_point(&from->to_world, corner));
    vec3_store(c->corner, xform_vector(&from->to_world, vec3_make(0, 0, -1)));
    vec3_store(c->dx, xform_vector(&from->to_world, vec3_make(pixel, 0, 0)));
    vec3_store(c->dy, xform_vector(&from->to_world, vec3_make(0, -pixel, 0)));
}

static void aim_panoramic(struct stage_camera *c, const struct scene *scene)
{
    const struct xform *m = &scene->camera.to_world;
    vec3_store(c->dx, xform_vector(m, vec3_make(1, 0, 0)));
    vec3_store(c->dy, xform_vector(m, vec3_make(0, 1, 0)));
    vec3_store(c->corner, xform_vector(m, vec3_make(0, 0, -1)));
    c->turns_x = 1 / (float)scene->film.width_px;
    c->turns_y = 0.5f / (float)scene->film.height_px;
}

void prep_camera(struct stage_camera *c, const struct scene *scene)
{
    const struct scene_camera *from = &scene->camera;
    c->kind = from->kind;
    vec3_store(c->origin, xform_point(&from->to_world, vec3_make(0, 0, 0)));
    switch (from->kind) {
    case CAMERA_THIN_LENS:
        open_lens(c, from);
        aim(c, scene);
        return;
    case CAMERA_PERSPECTIVE:
        aim(c, scene);
        return;
    case CAMERA_ORTHOGRAPHIC:
        aim_orthographic(c, scene);
        return;
    case CAMERA_PANORAMIC:
        aim_panoramic(c, scene);
        return;
    }
}
