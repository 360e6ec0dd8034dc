/* bvh.h - bounding volume hierarchy over the stage's primitives: closest hit, any hit.
 *
 * Eight-wide: a node holds the boxes of up to eight children, which are tested at once (box8.h); a
 * leaf is a block of up to eight triangles, tested at once, or one primitive of another kind, or
 * one instance of a shared mesh, whose own tree the ray then walks in object space. bvh_build.h
 * makes it.
 *
 * The hit is a pure function of the ray: the smallest t, and among equal t the smallest
 * primitive number, whatever the tree and the order of traversal; bvh_hit_closest is the minimum of
 * bvh_hit_prim over all primitives, to the last bit. Rays with a NaN hit nothing.
 * SPDX-License-Identifier: MIT */
#ifndef COMMON_TRACE_BVH_H
#define COMMON_TRACE_BVH_H

#include "common/trace/ray.h"
#include "common/trace/stage.h"

enum {
    BVH_WIDTH = 8,
    BVH_MAX_DEPTH =
        64, /* levels of nodes; the builder keeps it by halving once SAH has used it up */
    BVH_STACK = (BVH_WIDTH - 1) * BVH_MAX_DEPTH + 1, /* all children but one of each level wait */
};

/* A child: what it is in the upper 4 bits, which one in the lower 28. Nodes and blocks are found in
 * one way, by their distance from the first node in cache lines: stage.blocks follow stage.nodes.
 */
enum bvh_ref_kind {
    BVH_NODE,
    BVH_INSTANCE, /* index into stage.instances */
    BVH_BLOCK,    /* BVH_BLOCK + kind for the other primitives: index into their array */
    BVH_SPHERE,
    BVH_DISC,
    BVH_CYLINDER,
    BVH_NOTHING = 15, /* the root of an empty tree */
};

static inline uint32_t bvh_ref_make(uint32_t kind, uint32_t index)
{
    return kind << 28 | index;
}

static inline uint32_t bvh_ref_kind(uint32_t ref)
{
    return ref >> 28;
}

static inline uint32_t bvh_ref_index(uint32_t ref)
{
    return ref & 0xfffffff;
}

struct bvh_node {              /* 256 bytes: four cache lines */
    float plane[6][BVH_WIDTH]; /* box8.h */
    uint32_t child[BVH_WIDTH];
    uint32_t used; /* bit i: child i is there; the lower ones are */
    uint32_t pad[7];
};

enum {
    BVH_LINE = 64, /* bytes of a cache line */
    BVH_NODE_LINES = sizeof(struct bvh_node) / BVH_LINE,
    BVH_BLOCK_LINES = sizeof(struct stage_block) / BVH_LINE,
    BVH_MOST_LINES = 1 << 28, /* 16 GB of nodes and blocks */
};

_Static_assert(sizeof(struct bvh_node) == 4 * BVH_LINE, "four cache lines");
_Static_assert(sizeof(struct stage_block) == 5 * BVH_LINE, "five cache lines");

bool bvh_hit_closest(const struct stage *, const struct ray *, struct ray_hit *);
bool bvh_hit_any(const struct stage *, const struct ray *);

/* The same of up to eight rays, for less: those whose bit is set in `which`; the others need not be
 * there. Bit i of what is returned: ray i hits something, and hits[i] says what; the other hits are
 * not written. */
uint32_t bvh_hit_closest_8(const struct stage *, uint32_t which, const struct ray rays[],
                           struct ray_hit hits[]);
uint32_t bvh_hit_any_8(const struct stage *, uint32_t which, const struct ray rays[]);

/* The hit of one primitive alone, the one that hit->prim, place and instance name; t, u and v are
 * written. */
bool bvh_hit_prim(const struct stage *, const struct ray *, struct ray_hit *hit);

#endif
