/* bvh_split.h - items of a hierarchy in two, where the surface area heuristic says.
 *
 * J. Goldsmith, J. Salmon, "Automatic Creation of Object Hierarchies for Ray Tracing", IEEE CG&A
 * 7(5), 1987: the chance that a ray which meets a box meets a box inside it is the ratio of their
 * areas. The cost of a side is its area times the leaves that it needs at least. Few items are
 * sorted and all cuts are tried; many go into bins: I. Wald, "On fast Construction of SAH-based
 * Bounding Volume Hierarchies", RT 2007.
 *
 * Deterministic: the same items in the same order give the same cut and the same order.
 * SPDX-License-Identifier: MIT */
#ifndef COMMON_TRACE_BVH_SPLIT_H
#define COMMON_TRACE_BVH_SPLIT_H

#include "common/trace/bvh.h"

struct bvh_item {   /* what the builder needs of a primitive; moved about */
    float lo[3];    /* conservative bounds, finite */
    uint32_t index; /* in its array */
    float hi[3];
    uint32_t kind; /* enum bvh_ref_kind */
};

struct bvh_box {
    vec3 lo, hi; /* lane 3 is 0 */
};

/* A leaf has room for so much. */
enum { BVH_LEAF_WEIGHT = STAGE_LANES };

static inline uint32_t bvh_item_weight(const struct bvh_item *item)
{
    return item->kind == BVH_BLOCK ? 1 : BVH_LEAF_WEIGHT;
}

struct bvh_range { /* of items, half-open, not empty */
    uint32_t begin, end;
    uint32_t weight;        /* of all */
    struct bvh_box box;     /* of all */
    struct bvh_box middles; /* of the middles of their boxes */
};

struct bvh_range bvh_range_make(const struct bvh_item *items, uint32_t begin, uint32_t end);

/* Of a box's surface. */
static inline float bvh_half_area(const struct bvh_box *b)
{
    const vec3 d = b->hi - b->lo;
    return d[0] * d[1] + d[1] * d[2] + d[2] * d[0];
}

/* Two items at least; none of the parts is empty. by_count: in halves, as they lie. */
void bvh_split(struct bvh_item *items, const struct bvh_range *, bool by_count,
               struct bvh_range part[2]);

#endif
