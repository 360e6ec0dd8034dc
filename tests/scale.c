/* SPDX-License-Identifier: MIT */
#include "tests/scale.h"

static void lengths_of_light(struct light *l, float k)
{
    if (l->kind == LIGHT_POINT) {
        vec3_store(l->point.position, k * vec3_load(l->point.position));
        l->point.intensity *= k * k;
    } else if (l->kind == LIGHT_SPOT) {
        vec3_store(l->spot.position, k * vec3_load(l->spot.position));
        l->spot.intensity *= k * k;
    }
}

static void lengths_of_camera(struct scene_camera *c, float k)
{
    for (int i = 0; i < 3; i++)
        c->to_world.m[i][3] *= k;
    if (c->kind == CAMERA_THIN_LENS) {
        c->lens_radius *= k;
        c->focus *= k;
    } else if (c->kind == CAMERA_ORTHOGRAPHIC) {
        c->width *= k;
        c->height *= k;
    }
}

void scale_lengths(struct scene *s, float k)
{
    for (uint32_t i = 0; i < s->shape_count; i++)
        for (int n = 0; n < 12; n++)
            s->shapes[i].to_world.m[n / 4][n % 4] *= k;
    for (uint32_t i = 0; i < s->light_count; i++)
        lengths_of_light(&s->lights[i], k);
    for (uint32_t i = 0; i < s->material_count; i++)
        if (s->materials[i].kind == MATERIAL_DIELECTRIC)
            s->materials[i].inside.absorption /= k;
    lengths_of_camera(&s->camera, k);
}

static void radiance_of_light(struct light *l, float k)
{
    switch (l->kind) {
    case LIGHT_SKY:
        l->sky.radiance *= k;
        break;
    case LIGHT_POINT:
        l->point.intensity *= k;
        break;
    case LIGHT_DISTANT:
        l->distant.irradiance *= k;
        break;
    case LIGHT_SPOT:
        l->spot.intensity *= k;
        break;
    case LIGHT_SUN:
        l->sun.radiance *= k;
        l->sun.irradiance *= k;
        break;
    case LIGHT_ENVIRONMENT:
        l->environment.scale *= k;
        break;
    }
}

void scale_radiance(struct scene *s, float k)
{
    for (uint32_t i = 0; i < s->shape_count; i++)
        s->shapes[i].emission *= k;
    for (uint32_t i = 0; i < s->light_count; i++)
        radiance_of_light(&s->lights[i], k);
}
