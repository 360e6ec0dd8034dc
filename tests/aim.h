/* aim.h - rays at what a careless intersection test lets them slip through: the vertices and edges
 * that triangles share. From inside a closed surface every ray hits something, so one that
 * does not has leaked.
 * SPDX-License-Identifier: MIT */
#ifndef TESTS_AIM_H
#define TESTS_AIM_H

#include "common/trace/ray.h"
#include "common/trace/stage.h"
#include "tests/dice.h"

/* From origin at a vertex, or at a point of an edge, of some triangle of the stage. t_max infinite.
 */
struct ray aim_ray(struct dice *, const struct stage *, vec3 origin, bool vertex);

/* How often the stage's surface winds around p: 1 inside a closed one whose front is outside, 0
 * outside. A pass over all triangles. */
double aim_winding(const struct stage *, vec3 p);

#endif
