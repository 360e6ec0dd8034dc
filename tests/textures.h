/* textures.h - images, textures and textured parameters of scenes built in C.
 * SPDX-License-Identifier: MIT */
#ifndef TESTS_TEXTURES_H
#define TESTS_TEXTURES_H

#include "tests/scenes.h"

enum { TEXTURES_MAX = 16 }; /* images, textures, slots */

/* pixels: as in struct image_asset; they outlive the stage's making. */
struct texture *textures_image(struct scenes *, enum image_depth, uint32_t width_px,
                               uint32_t height_px, uint32_t channels, const void *pixels);
struct texture *textures_checker(struct scenes *, rgb a, rgb b, float scale);
struct texture *textures_vertex_color(struct scenes *);

/* A parameter of the last material made, in [0, 1]: `member` is inside it. */
struct material_slot *textures_drive(struct scenes *, const void *member, bool is_rgb,
                                     const struct texture *);

/* The material's relief, made on the first call; its textures are still to be named. */
struct material_relief *textures_relief(struct scenes *, uint32_t material);

/* A normal map that is the same everywhere; one of 16 x 8 squares, each tilted by the angle to a side
 * of its own. */
struct texture *textures_normal(struct scenes *, vec3 normal);
struct texture *textures_tilted(struct scenes *, double angle_rad);

/* Its number in the scene. */
uint32_t textures_index(const struct scenes *, const struct texture *);

#endif
