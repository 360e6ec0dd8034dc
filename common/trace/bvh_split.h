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

#include <stdalign.h>

#include "common/trace/bvh.h"
#include "common/trace/simd.h"

/* Of a primitive, what the builder needs; moved about. Upper bounds are kept with the other sign,
 * so that one minimum of eight numbers grows a box. */
struct bvh_item {
    alignas(32) float lo[3]; /* conservative bounds, finite */
    uint32_t index;          /* in its array */
    float minus_hi[3];
    uint32_t kind; /* enum bvh_ref_kind */
};

struct bvh_box {
    f32x8 v; /* lo, 0, -hi, 0 */
};

static inline struct bvh_item bvh_item_make(enum bvh_ref_kind kind, uint32_t index, vec3 lo,
                                            vec3 hi)
{
    struct bvh_item item = {.index = index, .kind = kind};
    vec3_store(item.lo, lo);
    vec3_store(item.minus_hi, -hi);
    return item;
}

static inline struct bvh_box bvh_box_empty(void)
{
    const float inf = __builtin_inff();
    return (struct bvh_box){{inf, inf, inf, 0, inf, inf, inf, 0}};
}

static inline struct bvh_box bvh_box_make(vec3 lo, vec3 hi)
{
    return (struct bvh_box){{lo[0], lo[1], lo[2], 0, -hi[0], -hi[1], -hi[2], 0}};
}

static inline void bvh_box_grow(struct bvh_box *b, struct bvh_box by)
{
    b->v = f32x8_min(by.v, b->v);
}

static inline vec3 bvh_box_lo(const struct bvh_box *b)
{
    return f32x8_low(b->v);
}

static inline vec3 bvh_box_hi(const struct bvh_box *b)
{
    return -f32x8_high(b->v);
}

enum {
    BVH_LEAF_WEIGHT = STAGE_LANES, /* a leaf has room for so much */
    BVH_FEW = 16,                  /* so many items or fewer are sorted */
};

static inline uint32_t bvh_item_weight(const struct bvh_item *item)
{
    return item->kind == BVH_BLOCK ? 1 : BVH_LEAF_WEIGHT;
}

struct bvh_range { /* of items, half-open, not empty */
    uint32_t begin, end;
    uint32_t weight;        /* of all */
    struct bvh_box box;     /* of all */
    struct bvh_box middles; /* of the middles of their boxes; of few items: not needed */
};

struct bvh_range bvh_range_make(const struct bvh_item *items, uint32_t begin, uint32_t end);

/* Of a box's surface. */
static inline float bvh_half_area(const struct bvh_box *b)
{
    const vec3 d = f32x8_low(b->v) + f32x8_high(b->v); /* the sides, negative */
    const vec3 two = d * __builtin_shufflevector(d, d, 1, 2, 0, 3);
    return two[0] + two[1] + two[2];
}

/* Two items at least; none of the parts is empty. by_count: in halves, as they lie. */
void bvh_split(struct bvh_item *items, const struct bvh_range *, bool by_count,
               struct bvh_range part[2]);

#endif
