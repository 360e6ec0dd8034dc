/* bvh.h - bounding volume hierarchy over the stage's primitives: build, closest hit, any hit.
 *
 * Binary, scalar, surface area heuristic: the plain one. It is the oracle that every
 * later structure is compared with, so it stays simple.
 *
 * The hit is a pure function of the ray: the smallest t, and among equal t the smallest
 * primitive number, whatever the order of traversal. Rays with a NaN hit nothing.
 * SPDX-License-Identifier: MIT */
#ifndef COMMON_TRACE_BVH_H
#define COMMON_TRACE_BVH_H

#include "common/trace/ray.h"
#include "common/trace/stage.h"

enum { BVH_MAX_DEPTH = 64 }; /* bound on the traversal stack; the builder keeps it (by median
                              * splits once SAH has used up its depth) */

struct bvh_node {            /* 32 bytes; children are neighbours: first, first + 1 */
    float lo[3];
    uint32_t first;          /* inner: index of the first child; leaf: into leaf_prims */
    float hi[3];
    uint32_t count : 29;     /* 0: inner; else primitives of the leaf */
    uint32_t kind : 3;       /* leaf: enum stage_prim_kind of all of them */
};

/* What the builder needs of a primitive. */
struct bvh_box {
    float lo[3], hi[3];      /* conservative bounds, finite */
};

struct bvh_tree {            /* memory of the arena given to bvh_build */
    struct bvh_node *nodes;
    uint32_t *leaf_prims;
    uint32_t node_count, depth;
};

/* boxes[i], kinds[i] belong to primitive i < count. count 0 gives no nodes: an empty scene. */
struct bvh_tree bvh_build(const struct bvh_box *boxes, const unsigned char *kinds, uint32_t count,
                          struct arena *);

bool bvh_hit_closest(const struct stage *, const struct ray *, struct ray_hit *);
bool bvh_hit_any(const struct stage *, const struct ray *);

/* The hit of one primitive alone. bvh_hit_closest is the minimum of these over all primitives, by t
 * and then by number, to the last bit. */
bool bvh_hit_prim(const struct stage *, uint32_t prim, const struct ray *, struct ray_hit *);

#endif
