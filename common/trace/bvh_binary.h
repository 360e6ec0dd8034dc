/* bvh_binary.h - the binary tree that a wide one is made of, and the best way to make it.
 *
 * Down to ranges that fit in a leaf, items are split in two (bvh_split.h). Which of its nodes
 * become nodes of eight children, and which are left out because a node above takes their children
 * as its own, is then chosen by dynamic programming over the same cost (H. Ylitie, T. Karras,
 * S. Laine, "Efficient Incoherent Ray Traversal on GPUs Through Compressed Wide BVHs", HPG 2017,
 * section 4.1). For each binary node and each count, the cost of its items as so many children of
 * one wide node or fewer:
 *
 *     cost(n, 1) = area(n) + cost of its items as eight children     (a wide node of its own; a
 * leaf: area) cost(n, i) = the best way to give k children to the left, i - k to the right; or
 * cost(n, i - 1)
 *
 * Areas are chances of being visited, and a visit of a node costs as much as one of a leaf: one
 * vector test. Splitting the widest child until there are eight, without looking further,
 * leaves nodes of two and three children near the leaves: half as many nodes again.
 * SPDX-License-Identifier: MIT */
#ifndef COMMON_TRACE_BVH_BINARY_H
#define COMMON_TRACE_BVH_BINARY_H

#include "common/arena.h"
#include "common/trace/bvh_split.h"

enum { BVH_BINARY_CHUNK = 256 };

struct bvh_binary_node {
    struct bvh_box box;
    uint32_t begin, end, weight; /* of its items */
    uint32_t second;             /* its second child, the first one being the next node; 0: none */
    float cost[BVH_WIDTH];       /* [i - 1]: as i children or fewer */
    unsigned char shape[BVH_WIDTH]; /* [i - 1]: as how many; 1: as a node of its own */
    unsigned char left[BVH_WIDTH];  /* [i - 1]: of exactly i children, those of the left side */
};

struct bvh_binary {
    struct arena *arena;
    struct bvh_binary_node **chunks;
    uint32_t count, room;
};

static inline struct bvh_binary_node *bvh_binary_at(const struct bvh_binary *b, uint32_t i)
{
    return &b->chunks[i / BVH_BINARY_CHUNK][i % BVH_BINARY_CHUNK];
}

/* But for its middles: to be split it must be few items (bvh_split.h). */
static inline struct bvh_range bvh_binary_range(const struct bvh_binary_node *n)
{
    return (struct bvh_range){n->begin, n->end, n->weight, n->box, bvh_box_empty()};
}

/* A range is not split further here when it is a leaf, or another part does it. A part is a node
 * of its own, whatever the choice would be, so it must be small in both ways: few items, and no
 * larger than a range of so few is, the surface of n of N items being some (n / N)^(2/3) of the
 * whole. Else the floor of a hall, found in one part with the dust that lies on it, would lie
 * below a second node of its size. */
struct bvh_binary_limits {
    uint32_t depth;                 /* of node 0 */
    uint32_t part_least, part_most; /* items of a part; most 0: there are no parts */
};

bool bvh_binary_is_leaf(const struct bvh_range *);
/* Node 0 is the whole range. Items are reordered. Memory of the arena. */
struct bvh_binary bvh_binary_make(struct bvh_item *, const struct bvh_range *,
                                  const struct bvh_binary_limits *, struct arena *);

/* The binary nodes that a wide node in node n's place has as its children; how many: 2 to 8. */
uint32_t bvh_binary_children(const struct bvh_binary *, uint32_t n, uint32_t child[BVH_WIDTH]);

#endif
