/* SPDX-License-Identifier: MIT */
#include "common/base.h"
#include "bench/corpus_parts.h"

static void bright(struct scenes *s, vec3 at, float radius, float radiance)
{
    shine(scenes_sphere(s, scenes_diffuse(s, rgb_gray(0)), at, radius), radiance);
}

static void quad(struct scenes *s, uint32_t material, vec3 corner, vec3 a, vec3 b)
{
    scenes_quad(s, material, corner, a, b);
}

/* A room of four walls, floor and ceiling; the left wall has an opening, and there is a sky. */
static void window(struct scenes *s)
{
    start(s, vec3_make(.6f, 1.2f, 2.6f), vec3_make(-.3f, .9f, 0), 60);
    const uint32_t wall = scenes_diffuse(s, rgb_gray(.6f));
    quad(s, wall, vec3_make(-1.5f, 0, 3), vec3_make(3, 0, 0), vec3_make(0, 0, -4.5f));
    quad(s, wall, vec3_make(-1.5f, 2.2f, -1.5f), vec3_make(3, 0, 0), vec3_make(0, 0, 4.5f));
    quad(s, wall, vec3_make(-1.5f, 0, -1.5f), vec3_make(3, 0, 0), vec3_make(0, 2.2f, 0));
    quad(s, wall, vec3_make(1.5f, 0, 3), vec3_make(-3, 0, 0), vec3_make(0, 2.2f, 0));
    quad(s, wall, vec3_make(1.5f, 0, -1.5f), vec3_make(0, 0, 4.5f), vec3_make(0, 2.2f, 0));
    quad(s, wall, vec3_make(-1.5f, 0, 3), vec3_make(0, 0, -4.5f), vec3_make(0, .8f, 0));
    quad(s, wall, vec3_make(-1.5f, 1.8f, 3), vec3_make(0, 0, -4.5f), vec3_make(0, .4f, 0));
    quad(s, wall, vec3_make(-1.5f, .8f, 3), vec3_make(0, 0, -2), vec3_make(0, 1, 0));
    ball(s, scenes_diffuse(s, rgb_gray(.4f)), .3f, -.3f);
    scenes_sky(s, rgb_gray(2));
}

static void spots(struct scenes *s)
{
    const float down[3] = {0, -1, 0};
    look_down(s);
    ground(s, .5f);
    balls(s);
    for (int i = 0; i < 3; i++) {
        const float at[3] = {-1.2f + 1.2f * (float)i, 2.5f, .3f};
        struct light *l = scenes_light(s, LIGHT_SPOT);
        memcpy(l->spot.position, at, sizeof at);
        memcpy(l->spot.direction, down, sizeof down);
        l->spot.intensity = rgb_gray(3);
        l->spot.inner_rad = .2f;
        l->spot.outer_rad = .5f;
    }
}

static void corridor(struct scenes *s)
{
    start(s, vec3_make(0, 1.2f, 5.5f), vec3_make(0, 1, -6), 50);
    scenes_box(s, scenes_diffuse(s, rgb_gray(.7f)), vec3_make(-.8f, 0, -6), vec3_make(.8f, 2.2f, 6),
               true);
    lamp(s, 0, 2.19f, -5, .4f, 60);
}

static void hall(struct scenes *s)
{
    room(s, .5f);
    quad(s, metal(s, .15f), vec3_make(-1.49f, .01f, 2.99f), vec3_make(2.98f, 0, 0),
         vec3_make(0, 0, -4.48f));
    ball(s, metal(s, .08f), -.5f, 0);
    ball(s, scenes_diffuse(s, rgb_gray(.5f)), .6f, -.4f);
    lamp(s, 0, 2.19f, 0, .8f, 8);
}

static void backdrop(struct scenes *s)
{
    look_down(s);
    ground(s, .3f);
    balls(s);
    shine(scenes_quad(s, scenes_diffuse(s, rgb_gray(0)), vec3_make(-4, 0, -2), vec3_make(8, 0, 0),
                      vec3_make(0, 4, 0)),
          1);
    bright(s, vec3_make(2, 3, 2), .08f, 60);
}

static void night(struct scenes *s)
{
    look_down(s);
    ground(s, .4f);
    balls(s);
    scenes_sky(s, rgb_gray(.01f));
    for (int i = 0; i < 12; i++)
        bright(
            s,
            vec3_make(-2 + .4f * (float)i, 1.2f + .5f * (float)(i % 3), -1 + .5f * (float)(i % 5)),
            .01f * (float)(1 + i % 4), 30);
}

static void bowl(struct scenes *s)
{
    look_down(s);
    ground(s, .5f);
    ball(s, scenes_glass(s, 1.5f), -.6f, 0);
    ball(s, scenes_diffuse(s, rgb_gray(.7f)), .6f, 0);
    scenes_sky(s, rgb_gray(1));
}

static void floor_shines(struct scenes *s)
{
    look_down(s);
    ground(s, .5f);
    shine(&s->scene.shapes[0], 1);
    balls(s);
}

/* Slats between lamp and floor. */
static void shutters(struct scenes *s)
{
    look_down(s);
    ground(s, .5f);
    ball(s, scenes_diffuse(s, rgb_gray(.5f)), 0, 0);
    const uint32_t slat = scenes_diffuse(s, rgb_gray(.3f));
    for (int i = 0; i < 12; i++)
        quad(s, slat, vec3_make(-2 + .33f * (float)i, 1.9f, 2), vec3_make(.16f, .02f, 0),
             vec3_make(0, 0, -4));
    lamp(s, 0, 3.5f, 0, .5f, 60);
}

static void white_room(struct scenes *s)
{
    room(s, .9f);
    ball(s, scenes_diffuse(s, rgb_gray(.9f)), 0, -.3f);
    lamp(s, 0, 2.19f, 0, .25f, 10);
}

/* From above, without perspective. */
static void from_above(struct scenes *s)
{
    look_down(s);
    s->scene.camera.kind = CAMERA_ORTHOGRAPHIC;
    s->scene.camera.width = 4;
    ground(s, .7f);
    balls(s);
    sun(s, .1f, 3);
    scenes_sky(s, rgb_gray(.3f));
}

static const struct corpus_scene scenes[] = {
    {"window", window},
    {"spots", spots},
    {"corridor", corridor},
    {"hall", hall},
    {"backdrop", backdrop},
    {"night", night},
    {"bowl", bowl},
    {"floor that shines", floor_shines},
    {"shutters", shutters},
    {"white room", white_room},
    {"from above", from_above},
    {"tiles", NULL},
};

const struct corpus_list corpus_fresh = {scenes, countof(scenes)};
