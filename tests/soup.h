/* soup.h - what the tests of intersection have in common: meshes from plain arrays, random rays.
 * SPDX-License-Identifier: MIT */
#ifndef TESTS_SOUP_H
#define TESTS_SOUP_H

#include "common/trace/ray.h"
#include "tests/dice.h"
#include "tests/scenes.h"

/* Triangles that share no vertices: v[3 * i + k] is vertex k of triangle i. */
struct shape *soup_mesh(struct scenes *, uint32_t material, float (*v)[3], uint32_t triangles);
float (*soup_vertices(struct scenes *, uint32_t triangles))[3]; /* memory for them */

vec3 soup_point(struct dice *, double half_side); /* in a cube about the origin */
vec3 soup_direction(struct dice *);               /* uniform on the sphere, unit but for rounding */
vec3 soup_magnitudes(struct dice *, double from, double to); /* +-10^[from, to], each coordinate */

/* All primitives, one after the other, by bvh_hit_prim. */
bool soup_closest(const struct stage *, const struct ray *, struct ray_hit *);

#endif
