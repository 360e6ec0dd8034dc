/* light_tree.h - one of many lights, by what they may mean to a point.
 *
 * A. Conty Estevez, C. Kulla, "Importance Sampling of Many Lights with Adaptive Tree Splitting",
 * PACMCGIT 1(2), 2018: a walk from the root of a hierarchy of lights, at each node into a child in
 * proportion to a bound on what it may send,
 *
 *     intensity * cos(towards the point) * cos(at the point) / distance^2,
 *
 * the cosines the largest that the child's bounds allow. Ours has eight children to a node, which
 * are weighed together; uses intensity, not power, so that a lamp that faces the point counts for
 * more than a bulb of its power; and does not split.
 *
 * Support is complete: whatever may send light has a chance. A child is passed by only when all of
 * it lies behind the surface (which must be opaque: surface.lit) or faces away, each beyond what
 * rounding leaves in doubt. If that is true of all children of a node that was not passed by, they
 * are weighed by intensity: the probabilities of all lights sum to 1, or to 0 for a point that none
 * can light.
 * SPDX-License-Identifier: MIT */
#ifndef COMMON_TRACE_LIGHT_TREE_H
#define COMMON_TRACE_LIGHT_TREE_H

#include "common/trace/surface.h"

/* DEPTH: the most levels of nodes, by the way the tree is built. */
enum { LIGHT_TREE_WALKS = 8, LIGHT_TREE_DEPTH = 64 };

struct light_tree_pick {
    uint32_t emitter; /* STAGE_NONE: no light can reach the point */
    double probability;
    double rest; /* what the choice left of u: uniform in [0, 1) again */
};

/* For up to LIGHT_TREE_WALKS points; u: in [0, 1). They go in step, so that one's node is on its
 * way from memory while the others' are weighed; what comes out for one does not depend on the
 * others.
 */
void light_tree_pick(const struct stage *, const struct surface *const from[], const double u[],
                     uint32_t count, struct light_tree_pick[]);

/* The probability of that for an emitter before stage.far_begin. */
double light_tree_probability(const struct stage *, const struct surface *from, uint32_t emitter);

#endif
