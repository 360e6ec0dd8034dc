/* bvh_cost.h - what a ray costs in a scene, by the surface area heuristic.
 *
 * J. Goldsmith, J. Salmon, "Automatic Creation of Object Hierarchies for Ray Tracing", IEEE CG&A
 * 7(5), 1987: of rays that cross a box from anywhere to anywhere, the share that crosses a box
 * inside it is the quotient of their areas. So the mean number of nodes and leaves that a ray
 * visits which goes through the whole scene, meeting nothing, is a sum of areas. A visit of either
 * is one vector test. It is a number for comparing, no promise: rays are not spread like that.
 * SPDX-License-Identifier: MIT */
#ifndef COMMON_TRACE_BVH_COST_H
#define COMMON_TRACE_BVH_COST_H

#include "common/trace/stage.h"

/* Visits, at least 1, of a ray that crosses the tree's box. The trees are written, and the cost of
 * those that this one has instances of is known. */
double bvh_cost(const struct stage *, uint32_t tree);

/* Of a ray in the scene. */
static inline double bvh_cost_of_ray(const struct stage *s)
{
    return ((const struct stage_tree *)stage_at(s, s->trees))->cost;
}

#endif
