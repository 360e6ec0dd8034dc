/* bvh_build.h - items -> hierarchy of eight-wide nodes.
 *
 * In two steps, because what a tree needs is known only when it is there: bvh_plan_make sorts the
 * items and plans nodes and leaves; bvh_plan_write and bvh_plan_fill then write nodes and blocks
 * where the caller has made room for them.
 *
 * Items are split in two until they fit in leaves, and the nodes of eight are chosen from that
 * tree (bvh_binary.h).
 * Levels of nodes are at most BVH_MAX_DEPTH: a range is halved by count as soon as that is just
 * enough to end there.
 *
 * Deterministic, also with a crew: the plan is cut into parts by the items alone.
 * SPDX-License-Identifier: MIT */
#ifndef COMMON_TRACE_BVH_BUILD_H
#define COMMON_TRACE_BVH_BUILD_H

#include "common/arena.h"
#include "common/trace/bvh_split.h"
#include "common/trace/crew.h"

/* Pieces of memory are small enough that what a part does not use of its last ones is little. */
enum { BVH_NODE_PIECE = 32, BVH_LEAF_PIECE = 128 };

struct bvh_leaf {                   /* a block to be */
    uint32_t triangle[STAGE_LANES]; /* STAGE_NONE: an empty lane */
};

struct bvh_part {
    uint32_t begin, end; /* of its items */
    uint32_t depth;      /* of its first node; then of its deepest */
    struct arena arena;
    struct bvh_node **nodes;  /* BVH_NODE_PIECE each */
    struct bvh_leaf **leaves; /* BVH_LEAF_PIECE each */
    uint32_t node_count, leaf_count;
    uint32_t node_begin, leaf_begin; /* within the plan */
};

static inline struct bvh_node *bvh_part_node(const struct bvh_part *part, uint32_t i)
{
    return &part->nodes[i / BVH_NODE_PIECE][i % BVH_NODE_PIECE];
}

static inline struct bvh_leaf *bvh_part_leaf(const struct bvh_part *part, uint32_t i)
{
    return &part->leaves[i / BVH_LEAF_PIECE][i % BVH_LEAF_PIECE];
}

struct bvh_plan {
    struct bvh_item *items; /* while it is made */
    struct bvh_part *parts; /* the first one holds the root and leads to the others */
    uint32_t part_count, part_room;
    uint32_t node_count, leaf_count, depth;
    struct bvh_box box; /* of all items */
    uint32_t root;      /* counted from the plan's first node, or leaf; BVH_NOTHING without items */
    struct arena arena;
};

/* items are reordered, and not needed afterwards. */
struct bvh_plan bvh_plan_make(struct bvh_item *items, uint32_t count, const struct crew *);

struct bvh_site {           /* where a plan's nodes and blocks will lie in the stage */
    struct bvh_node *nodes; /* the plan's first one; room for node_count */
    uint32_t node_line,
        block_line; /* its and the first block's distance from the stage's first node */
};

/* Returns the root's reference. */
uint32_t bvh_plan_write(const struct bvh_plan *, const struct bvh_site *, const struct crew *);

/* blocks: room for leaf_count. Items of kind BVH_BLOCK have indices into triangles and prims. */
void bvh_plan_fill(const struct bvh_plan *, const struct stage_triangle *triangles,
                   const uint32_t *prims, struct stage_block *blocks, const struct crew *);

void bvh_plan_release(struct bvh_plan *);

#endif
