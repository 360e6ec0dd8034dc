/* bvh.h - bounding volume hierarchy over the stage's primitives: build, closest hit, any hit.
 *
 * Binary, scalar, surface area heuristic: the plain one. It is the oracle that every
 * later structure is compared with, so it stays simple.
 *
 * The hit is a pure function of the ray: the smallest t, and among equal t the smallest
 * primitive number, whatever the tree and the order of traversal. Boxes are conservative (box.h), so it
 * is the very hit that testing all primitives one by one gives.
 * SPDX-License-Identifier: MIT */
#ifndef COMMON_TRACE_BVH_H
#define COMMON_TRACE_BVH_H

#include "common/trace/ray.h"
#include "common/trace/stage.h"

enum { BVH_MAX_DEPTH = 64 }; /* bound on the traversal stack; the builder keeps it (by median
                              * splits once SAH has used up its depth) */

struct bvh_node {        /* 32 bytes; children are neighbours: first, first + 1. Node 1 is unused, so
                          * that two children share a cache line */
    float plane[2][3];   /* lower, upper corner */
    uint32_t first;      /* inner: index of the first child; leaf: in the stage, into the array of its
                          * kind; in struct bvh_tree, into leaf_prims */
    uint32_t count : 29; /* 0: inner; else primitives of the leaf */
    uint32_t kind : 3;   /* leaf: enum stage_prim_kind of all of them */
};

/* What the builder needs of a primitive. */
struct bvh_box {
    float lo[3], hi[3];      /* conservative bounds, finite */
};

struct bvh_tree {            /* memory of the arena given to bvh_build */
    struct bvh_node *nodes;
    uint32_t *leaf_prims;    /* primitive numbers; a leaf is a range of them */
    uint32_t node_count;
    uint32_t depth;          /* nodes on the longest way down; at most BVH_MAX_DEPTH */
};

/* boxes[i], kinds[i] belong to primitive i < count. count 0 gives no nodes: an empty scene. */
struct bvh_tree bvh_build(const struct bvh_box *boxes, const unsigned char *kinds, uint32_t count,
                          struct arena *);

bool bvh_hit_closest(const struct stage *, const struct ray *, struct ray_hit *);
bool bvh_hit_any(const struct stage *, const struct ray *);

/* False for what hits nothing by definition: a ray with an infinity or a NaN, with no direction
 * (subnormal counts as none) or with t_max not > 0. */
bool bvh_hit_possible(const struct ray *);

/* The triangle test's edge function as this build of the core computes it, for the test that nothing
 * was contracted: bvh_edge(a, b) == -bvh_edge(b, a) to the last bit. */
double bvh_edge(double ax, double ay, double bx, double by);

#endif
