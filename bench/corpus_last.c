/* SPDX-License-Identifier: MIT */
#include "bench/corpus_parts.h"
#include "common/base.h"

static uint32_t plastic(struct scenes *s, float albedo, float alpha)
{
    return scenes_material(
        s, (struct material){.kind = MATERIAL_PLASTIC, .plastic = {rgb_gray(albedo), 1.5f, alpha}});
}

static uint32_t frosted(struct scenes *s, float alpha)
{
    return scenes_material(
        s, (struct material){.kind = MATERIAL_DIELECTRIC, .dielectric = {1.5f, alpha, false}});
}

static void point(struct scenes *s, float x, float y, float z, float intensity)
{
    const float at[3] = {x, y, z};
    struct light *l = scenes_light(s, LIGHT_POINT);
    memcpy(l->point.position, at, sizeof at);
    l->point.intensity = rgb_gray(intensity);
}

/* A thing on a shelf behind a pane. */
static void showcase(struct scenes *s)
{
    room(s, .5f);
    const uint32_t pane =
        scenes_material(s, (struct material){.kind = MATERIAL_PANE, .pane = {1.5f}});
    ball(s, plastic(s, .5f, .1f), -.3f, -.6f);
    scenes_quad(s, pane, vec3_make(-1.4f, 0, .2f), vec3_make(2.8f, 0, 0), vec3_make(0, 1.8f, 0));
    lamp(s, .4f, 2.19f, -.7f, .6f, 12);
}

static void neon(struct scenes *s)
{
    room(s, .4f);
    ball(s, metal(s, .25f), .4f, -.2f);
    shine(scenes_cylinder(s, scenes_diffuse(s, rgb_gray(0)), vec3_make(-1.3f, 1.6f, -1.2f),
                          vec3_make(1.3f, 1.9f, -1.2f), .02f),
          25);
}

static void two_bulbs(struct scenes *s)
{
    room(s, .6f);
    ball(s, plastic(s, .4f, 0), -.5f, 0);
    ball(s, scenes_diffuse(s, rgb_gray(.7f)), .6f, -.5f);
    point(s, -1, 1.8f, .5f, 1);
    point(s, 1.1f, 1, 1, .3f);
}

static void frosted_ball(struct scenes *s)
{
    look_down(s);
    ground(s, .4f);
    ball(s, frosted(s, .3f), -.6f, 0);
    ball(s, frosted(s, .05f), .6f, 0);
    scenes_sky(s, rgb_gray(.7f));
    lamp(s, 1, 3, 1, .5f, 15);
}

/* The lamp is behind a wall. */
static void around_the_corner(struct scenes *s)
{
    room(s, .7f);
    scenes_quad(s, scenes_diffuse(s, rgb_gray(.5f)), vec3_make(-.2f, 0, -1.5f), vec3_make(0, 0, 3),
                vec3_make(0, 2.2f, 0));
    ball(s, scenes_diffuse(s, rgb_gray(.5f)), .6f, .3f);
    lamp(s, -.9f, 2.19f, -.8f, .5f, 30);
}

static void shelf_of_metals(struct scenes *s)
{
    look_down(s);
    ground(s, .3f);
    for (int i = 0; i < 15; i++)
        scenes_sphere(s, metal(s, .02f * (float)(1 + i)),
                      vec3_make(-1.6f + .8f * (float)(i % 5), .3f, -1 + .8f * (float)(i / 5)), .3f);
    scenes_sky(s, rgb_gray(.4f));
    lamp(s, -1, 2.5f, 1, .8f, 10);
}

/* A lens that is in focus on the middle one. */
static void portrait(struct scenes *s)
{
    look_down(s);
    s->scene.camera.kind = CAMERA_THIN_LENS;
    s->scene.camera.lens_radius = .08f;
    s->scene.camera.focus = 4.3f;
    ground(s, .5f);
    balls(s);
    sun(s, .005f, 2);
    scenes_sky(s, rgb_gray(.5f));
}

static void moonlight(struct scenes *s)
{
    const float down[3] = {.6f, -.64f, -.48f};
    look_down(s);
    ground(s, .1f);
    balls(s);
    struct light *l = scenes_light(s, LIGHT_DISTANT);
    memcpy(l->distant.direction, down, sizeof down);
    l->distant.irradiance = rgb_gray(.02f);
}

static void tilted_disc(struct scenes *s)
{
    look_down(s);
    ground(s, .6f);
    scenes_disc(s, metal(s, .05f), vec3_make(0, .4f, 0), vec3_make(0, .8f, .6f), 1.2f);
    shine(scenes_disc(s, scenes_diffuse(s, rgb_gray(0)), vec3_make(-1, 2.4f, -1.5f),
                      vec3_make(.5f, -.7f, .5f), .5f),
          12);
}

static void mirror_cabinet(struct scenes *s)
{
    start(s, vec3_make(0, 1.2f, 2.9f), vec3_make(0, .9f, 0), 60);
    scenes_box(s, scenes_mirror(s, rgb_gray(.8f)), vec3_make(-1.5f, 0, -1.5f),
               vec3_make(1.5f, 2.2f, 3), true);
    ball(s, scenes_diffuse(s, rgb_gray(.6f)), -.4f, 0);
    ball(s, plastic(s, .3f, .2f), .7f, -.5f);
    lamp(s, 0, 2.1f, 0, .4f, 12);
}

static const struct corpus_scene scenes[] = {
    {"showcase", showcase},
    {"neon", neon},
    {"two bulbs", two_bulbs},
    {"frosted balls", frosted_ball},
    {"around the corner", around_the_corner},
    {"shelf of metals", shelf_of_metals},
    {"portrait", portrait},
    {"moonlight", moonlight},
    {"tilted disc", tilted_disc},
    {"mirror cabinet", mirror_cabinet},
};

const struct corpus_list corpus_last = {scenes, countof(scenes)};
