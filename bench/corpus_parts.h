/* corpus_parts.h - what scenes of the corpus are made of. SPDX-License-Identifier: MIT */
#ifndef BENCH_CORPUS_PARTS_H
#define BENCH_CORPUS_PARTS_H

#include <string.h>

#include "bench/corpus.h"

struct corpus_scene {
    const char *name;
    void (*make)(struct scenes *); /* NULL: scenes/NAME.json, with the corpus's film */
};

struct corpus_list {
    const struct corpus_scene *scenes;
    uint32_t count;
};

extern const struct corpus_list corpus_fresh, corpus_last;

static inline void start(struct scenes *s, vec3 from, vec3 at, double fov_y_deg)
{
    scenes_init(s, CORPUS_WIDTH_PX, CORPUS_HEIGHT_PX);
    scenes_look(s, from, at, fov_y_deg * 3.14159265358979323846 / 180);
}

static inline void shine(struct shape *shape, float radiance)
{
    shape->emission = rgb_gray(radiance);
}

/* A quad below y that shines down, around (x, z). */
static inline void lamp(struct scenes *s, float x, float y, float z, float side, float radiance)
{
    shine(scenes_quad(s, scenes_diffuse(s, rgb_gray(0)), vec3_make(x - side / 2, y, z - side / 2),
                      vec3_make(side, 0, 0), vec3_make(0, 0, side)),
          radiance);
}

static inline uint32_t metal(struct scenes *s, float alpha)
{
    return scenes_metal(s, rgb_gray(.2f), rgb_gray(3), alpha);
}

static inline void ground(struct scenes *s, float albedo)
{
    scenes_quad(s, scenes_diffuse(s, rgb_gray(albedo)), vec3_make(-4, 0, 4), vec3_make(8, 0, 0),
                vec3_make(0, 0, -8));
}

static inline void ball(struct scenes *s, uint32_t material, float x, float z)
{
    scenes_sphere(s, material, vec3_make(x, .5f, z), .5f);
}

static inline void look_down(struct scenes *s)
{
    start(s, vec3_make(0, 2.2f, 4), vec3_make(0, .5f, 0), 40);
}

static inline void room(struct scenes *s, float albedo)
{
    start(s, vec3_make(0, 1.2f, 2.9f), vec3_make(0, .9f, 0), 60);
    scenes_box(s, scenes_diffuse(s, rgb_gray(albedo)), vec3_make(-1.5f, 0, -1.5f),
               vec3_make(1.5f, 2.2f, 3), true);
}

static inline void balls(struct scenes *s)
{
    ball(s, scenes_diffuse(s, rgb_gray(.6f)), -1.1f, 0);
    ball(s, metal(s, .1f), 0, 0);
    ball(s, scenes_diffuse(s, rgb_gray(.2f)), 1.1f, 0);
}

static inline void sun(struct scenes *s, float radius_rad, float irradiance)
{
    const float down[3] = {-.48f, -.8f, -.36f};
    struct light *l = scenes_light(s, LIGHT_SUN);
    memcpy(l->sun.direction, down, sizeof down);
    l->sun.radius_rad = radius_rad;
    l->sun.irradiance = rgb_gray(irradiance);
}

#endif
