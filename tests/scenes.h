/* scenes.h - scenes built in C, for tests: the struct that scene_parse would have filled.
 *
 * Each add function returns what was added, to be changed on the spot: its emission, say.
 * SPDX-License-Identifier: MIT */
#ifndef TESTS_SCENES_H
#define TESTS_SCENES_H

#include "common/film.h"
#include "common/scene.h"
#include "common/trace/stage.h"
#include "common/trace/wave.h"

enum { SCENES_MAX_SHAPES = 256, SCENES_MAX = 32 }; /* shapes; materials, meshes, lights */

struct scenes {
    struct arena arena;
    struct scene scene;
};

/* A box filter of one pixel, 64 bounces, seed 1, a camera at the origin. */
void scenes_init(struct scenes *, uint32_t width_px, uint32_t height_px);
/* scenes/NAME.json, with all its files, to be changed before the stage is made. False: it cannot be
 * read. To be released in either case. */
bool scenes_open(struct scenes *, const char *name);
void scenes_release(struct scenes *); /* the stage goes with it */

void scenes_look(struct scenes *, vec3 from, vec3 at, double fov_y_rad);

uint32_t scenes_diffuse(struct scenes *, rgb albedo); /* materials: their index */
uint32_t scenes_mirror(struct scenes *, rgb reflectance);
uint32_t scenes_glass(struct scenes *, float ior);
uint32_t scenes_metal(struct scenes *, rgb eta, rgb k, float alpha);
uint32_t scenes_material(struct scenes *, struct material); /* any */

struct shape *scenes_sphere(struct scenes *, uint32_t material, vec3 center, float radius);
struct shape *scenes_disc(struct scenes *, uint32_t material, vec3 center, vec3 normal,
                          float radius);
struct shape *scenes_cylinder(struct scenes *, uint32_t material, vec3 from, vec3 to, float radius);
/* The parallelogram corner, corner + a, corner + a + b, corner + b; its front is where a x b is. */
struct shape *scenes_quad(struct scenes *, uint32_t material, vec3 corner, vec3 a, vec3 b);
struct shape *scenes_triangle(struct scenes *, uint32_t material, vec3 a, vec3 b, vec3 c);
/* A white cube of 1 m around the camera, which sees its far wall; one wall shines, by 1. */
void scenes_cube(struct scenes *, uint32_t width_px, uint32_t height_px, int light);
/* The first of six quads. Their fronts are inside or outside. */
struct shape *scenes_box(struct scenes *, uint32_t material, vec3 lo, vec3 hi, bool inside);
/* Room for a mesh, all 0, to be filled before the stage is made. */
struct scenes_mesh {
    struct shape *shape;
    float (*vertices)[3];
    uint32_t (*triangles)[3];
};

struct scenes_mesh scenes_mesh(struct scenes *, uint32_t material, uint32_t vertices,
                               uint32_t triangles);
/* A sphere of 2 n^2 quadrangles, its radius wavy by the given part. */
struct shape *scenes_ball(struct scenes *, uint32_t material, vec3 center, float radius, uint32_t n,
                          float wave, bool inside);

struct light *scenes_light(struct scenes *, enum light_kind);
void scenes_sky(struct scenes *, rgb radiance);

const struct stage *scenes_stage(struct scenes *); /* aborts with the message when prep refuses */

/* The whole frame, in passes as a job has them. The caller releases the film. */
void scenes_render(const struct stage *, uint32_t spp, struct film *);

/* What wave.h's paths bring along rays that are known already: those of `which`. */
void scenes_follow(const struct stage *, uint32_t which, const struct wave_starts *,
                   const struct rng rngs[], uint32_t roulette_begin, rgb radiance[]);

/* Mean of all pixels of one channel, and its standard error from the replicates. */
struct scenes_mean {
    double mean, error;
};

struct scenes_mean scenes_mean(const struct film *, int channel);

#endif
