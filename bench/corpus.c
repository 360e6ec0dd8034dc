/* SPDX-License-Identifier: MIT */
#include "bench/corpus.h"

#include <math.h>
#include <string.h>

#include "bench/corpus_parts.h"
#include "common/base.h"

/* --- rooms --- */

static void furnished(struct scenes *s, float side)
{
    room(s, .6f);
    ball(s, scenes_diffuse(s, rgb_gray(.7f)), -.6f, -.3f);
    ball(s, scenes_diffuse(s, rgb_gray(.3f)), .6f, 0);
    lamp(s, 0, 2.19f, 0, side, 4 / (side * side));
}

static void room_small(struct scenes *s)
{
    furnished(s, .1f);
}

static void room_lamp(struct scenes *s)
{
    furnished(s, .5f);
}

static void room_panel(struct scenes *s)
{
    furnished(s, 1.4f);
}

static void room_ceiling(struct scenes *s)
{
    furnished(s, 2.9f);
}

static void room_glass(struct scenes *s, float side)
{
    room(s, .6f);
    ball(s, scenes_glass(s, 1.5f), -.6f, .2f);
    ball(s, metal(s, .2f), .6f, 0);
    lamp(s, 0, 2.19f, 0, side, 4 / (side * side));
}

static void glass_lamp(struct scenes *s)
{
    room_glass(s, .8f);
}

static void glass_ceiling(struct scenes *s)
{
    room_glass(s, 2.9f);
}

static void mirrors(struct scenes *s)
{
    room(s, .5f);
    scenes_quad(s, scenes_mirror(s, rgb_gray(.9f)), vec3_make(-1.49f, .3f, 1), vec3_make(0, 0, -2),
                vec3_make(0, 1.5f, 0));
    ball(s, scenes_mirror(s, rgb_gray(.95f)), .5f, 0);
    lamp(s, 0, 2.19f, 0, .6f, 10);
}

static void furnace(struct scenes *s, float albedo)
{
    start(s, vec3_make(0, 0, 0), vec3_make(.3f, .2f, -1), 60);
    scenes_box(s, scenes_diffuse(s, rgb_gray(albedo)), vec3_make(-1, -1, -1), vec3_make(1, 1, 1),
               true);
    for (uint32_t i = 0; i < s->scene.shape_count; i++)
        shine(&s->scene.shapes[i], 1 + (float)i);
}

static void furnace_dark(struct scenes *s)
{
    furnace(s, .3f);
}

static void furnace_bright(struct scenes *s)
{
    furnace(s, .8f);
}

static void lit_by_point(struct scenes *s)
{
    const float at[3] = {.3f, 1.9f, .2f};
    room(s, .6f);
    ball(s, scenes_diffuse(s, rgb_gray(.6f)), -.4f, 0);
    struct light *l = scenes_light(s, LIGHT_POINT);
    memcpy(l->point.position, at, sizeof at);
    l->point.intensity = rgb_gray(2);
}

static void walls_shine(struct scenes *s)
{
    room(s, .5f);
    ball(s, metal(s, .05f), -.6f, 0);
    ball(s, metal(s, .3f), .6f, 0);
    for (uint32_t i = 0; i < 3; i++)
        shine(&s->scene.shapes[2 * i], 1);
}

/* --- outside --- */

static void under_sky(struct scenes *s)
{
    look_down(s);
    ground(s, .5f);
    balls(s);
    scenes_sky(s, rgb_gray(1));
}

static void under_sun(struct scenes *s)
{
    under_sky(s);
    sun(s, .005f, 5);
}

static void under_haze(struct scenes *s)
{
    under_sky(s);
    sun(s, .6f, 2);
}

static void under_distant(struct scenes *s)
{
    const float down[3] = {-.48f, -.8f, -.36f};
    under_sky(s);
    struct light *l = scenes_light(s, LIGHT_DISTANT);
    memcpy(l->distant.direction, down, sizeof down);
    l->distant.irradiance = rgb_gray(3);
}

static void dome(struct scenes *s)
{
    look_down(s);
    ground(s, .5f);
    balls(s);
    scenes_ball(s, scenes_diffuse(s, rgb_gray(0)), vec3_make(0, 0, 0), 9, 6, 0, true);
    shine(&s->scene.shapes[s->scene.shape_count - 1], 1);
}

static void soft_box(struct scenes *s)
{
    look_down(s);
    ground(s, .4f);
    balls(s);
    lamp(s, 0, 2.5f, 0, 4, 1);
}

static void dark(struct scenes *s, float albedo)
{
    look_down(s);
    ground(s, albedo);
    ball(s, scenes_diffuse(s, rgb_gray(albedo)), -.6f, 0);
    ball(s, scenes_diffuse(s, rgb_gray(albedo)), .6f, 0);
    lamp(s, 0, 3, 0, 1, 20);
}

static void dark_2(struct scenes *s)
{
    dark(s, .02f);
}

static void dark_10(struct scenes *s)
{
    dark(s, .1f);
}

static void sunny_floor(struct scenes *s)
{
    look_down(s);
    ground(s, .6f);
    lamp(s, 0, 3, 0, .05f, 1000);
}

static void plates(struct scenes *s)
{
    look_down(s);
    ground(s, .3f);
    for (int i = 0; i < 4; i++) {
        const float y = .2f + .35f * (float)i, z = .6f - .45f * (float)i;
        scenes_quad(s, metal(s, .01f * powf(3, (float)i)), vec3_make(-1.5f, y, z),
                    vec3_make(3, 0, 0), vec3_make(0, .25f, -.3f));
        shine(scenes_sphere(s, scenes_diffuse(s, rgb_gray(0)),
                            vec3_make(-1.2f + .8f * (float)i, 2.4f, -1.2f),
                            .03f * powf(2.2f, (float)i)),
              40 / powf(4, (float)i));
    }
}

static void lanterns(struct scenes *s)
{
    look_down(s);
    ground(s, .5f);
    const uint32_t black = scenes_diffuse(s, rgb_gray(0));
    for (int i = 0; i < 40; i++)
        shine(scenes_sphere(s, black,
                            vec3_make(-1.75f + .5f * (float)(i % 8), .3f + .1f * (float)(i % 3),
                                      -1.5f + .6f * (float)(i / 8)),
                            .05f),
              5);
}

static void tubes(struct scenes *s)
{
    look_down(s);
    ground(s, .5f);
    balls(s);
    const uint32_t black = scenes_diffuse(s, rgb_gray(0));
    for (int i = 0; i < 3; i++)
        shine(scenes_cylinder(s, black, vec3_make(-1.5f, 2, -1 + (float)i),
                              vec3_make(1.5f, 2, -1 + (float)i), .03f),
              20);
    shine(scenes_disc(s, black, vec3_make(-2.5f, 1, 0), vec3_make(1, 0, 0), .6f), 3);
}

static void caustic(struct scenes *s)
{
    look_down(s);
    ground(s, .6f);
    scenes_sphere(s, scenes_glass(s, 1.5f), vec3_make(0, .9f, 0), .5f);
    shine(scenes_sphere(s, scenes_diffuse(s, rgb_gray(0)), vec3_make(.5f, 3, 0), .3f), 20);
}

static void glass_alone(struct scenes *s)
{
    look_down(s);
    ground(s, .01f);
    ball(s, scenes_glass(s, 1.5f), -.6f, 0);
    ball(s, scenes_mirror(s, rgb_gray(.9f)), .6f, 0);
    lamp(s, 0, 3, 0, 2, 5);
}

static void wavy(struct scenes *s)
{
    look_down(s);
    ground(s, .5f);
    scenes_ball(s, scenes_diffuse(s, rgb_gray(.6f)), vec3_make(0, .8f, 0), .7f, 24, .2f, false);
    lamp(s, 1, 3, 1, .6f, 20);
}

/* --- the list --- */

static const struct corpus_scene scenes[] = {
    {"room, small lamp", room_small},
    {"room, lamp", room_lamp},
    {"room, panel", room_panel},
    {"room, ceiling", room_ceiling},
    {"glass, lamp", glass_lamp},
    {"glass, ceiling", glass_ceiling},
    {"mirrors", mirrors},
    {"furnace, dark", furnace_dark},
    {"furnace, bright", furnace_bright},
    {"point", lit_by_point},
    {"walls that shine", walls_shine},
    {"dome", dome},
    {"sky", under_sky},
    {"sky and sun", under_sun},
    {"sky and haze", under_haze},
    {"sky and distant", under_distant},
    {"soft box", soft_box},
    {"dark, albedo .02", dark_2},
    {"dark, albedo .1", dark_10},
    {"floor, tiny lamp", sunny_floor},
    {"plates", plates},
    {"lanterns", lanterns},
    {"tubes", tubes},
    {"caustic", caustic},
    {"glass alone", glass_alone},
    {"wavy ball", wavy},
    {"cornell-box", NULL},
    {"glass-and-metal", NULL},
    {"many-lights", NULL},
    {"materials", NULL},
};

static const struct corpus_list first = {scenes, countof(scenes)};
static const struct corpus_list *const lists[] = {&first, &corpus_fresh, &corpus_last};

uint32_t corpus_count(void)
{
    uint32_t count = 0;
    for (size_t k = 0; k < countof(lists); k++)
        count += lists[k]->count;
    return count;
}

/* The i-th of all. */
static const struct corpus_scene *find(uint32_t i)
{
    size_t k = 0;
    for (; i >= lists[k]->count; k++)
        i -= lists[k]->count;
    return &lists[k]->scenes[i];
}

const char *corpus_name(uint32_t i)
{
    return find(i)->name;
}

enum corpus_part corpus_part(uint32_t i)
{
    if (i < first.count)
        return i % 3 == 2 ? CORPUS_HELD_OUT : CORPUS_TUNED;
    return i < first.count + corpus_fresh.count ? CORPUS_FRESH : CORPUS_LAST;
}

static bool open_example(const char *name, struct scenes *s)
{
    if (!scenes_open(s, name))
        return false;
    s->scene.film = (struct scene_film){.width_px = CORPUS_WIDTH_PX,
                                        .height_px = CORPUS_HEIGHT_PX,
                                        .crop_x_end = CORPUS_WIDTH_PX,
                                        .crop_y_end = CORPUS_HEIGHT_PX,
                                        .filter = FILTER_BOX,
                                        .filter_radius_px = .5f};
    return true;
}

bool corpus_make(uint32_t i, struct scenes *s)
{
    const struct corpus_scene *scene = find(i);
    if (!scene->make)
        return open_example(scene->name, s);
    scene->make(s);
    return true;
}
