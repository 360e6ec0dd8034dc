/* jumble.h - stages made of loose triangles, spheres and discs, and rays through them.
 * SPDX-License-Identifier: MIT */
#ifndef TESTS_JUMBLE_H
#define TESTS_JUMBLE_H

#include "common/scene.h"
#include "common/trace/ray.h"
#include "common/trace/stage.h"
#include "tests/dice.h"

struct jumble {
    struct arena arena;
    struct scene scene; /* to be changed at will before jumble_stage */
    float *vertices;    /* of the one mesh, which is the first shape */
    uint32_t *indices;
    uint32_t max_vertices, max_triangles, max_shapes;
};

/* Room for so many triangles with as many vertices as they could use, and spheres and discs. */
void jumble_init(struct jumble *, uint32_t max_triangles, uint32_t max_others);
void jumble_release(struct jumble *); /* the stage goes with it */

uint32_t jumble_vertex(struct jumble *, vec3);
void jumble_face(struct jumble *, uint32_t a, uint32_t b, uint32_t c);
void jumble_triangle(struct jumble *, vec3 a, vec3 b, vec3 c); /* with vertices of its own */
struct shape *jumble_sphere(struct jumble *, vec3 center, float radius);
struct shape *jumble_disc(struct jumble *, vec3 center, vec3 normal_raw, float radius);

/* The bumpy sphere of n x n quadrangles: closed, every vertex shared; radius 1, wavy by a tenth. */
void jumble_bumpy_sphere(struct jumble *, uint32_t n, vec3 center);

const struct stage *jumble_stage(struct jumble *);

vec3 jumble_point(struct dice *, vec3 center, double reach); /* uniform in a cube */
vec3 jumble_direction(struct dice *);                        /* uniform, unit up to rounding */

#endif
