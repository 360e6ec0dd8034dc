/* SPDX-License-Identifier: MIT */
#include "common/trace/bvh_turns.h"

#include "common/trace/fetch.h"

enum {
    RAYS = 8,
    TOP_LEVELS = 3, /* of nodes, which are in a cache: no ray waits there */
};

struct walker {
    bvh_entry *bottom, *top; /* of its stack */
    uint32_t ref;            /* where it is */
    struct bvh_query query;
    struct box8_ray box;
    struct bvh_best best;
};

/* Their stacks lie apart from what is used all the time. */
struct walkers {
    struct walker of[RAYS];
    bvh_entry stack[RAYS][BVH_STACK];
};

/* From a node to a child. False: none is met. */
static inline __attribute__((always_inline)) bool descend(struct walker *w, bool any)
{
    const struct bvh_node *node = bvh_data_at(&w->query, w->ref);
    f32x8 near, far;
    const uint64_t hits = box8_hit(&w->box, node->plane, w->best.t, &near, &far) & node->used;
    if (!hits)
        return false;
    w->ref = any ? bvh_last_child(&w->query, node, hits, &w->top)
                 : bvh_nearest_child(&w->query, node, hits, near, &w->top);
    return true;
}

/* To what waits and is still of interest. False: nothing is. */
static inline __attribute__((always_inline)) bool turn_back(struct walker *w, bool any)
{
    const bvh_entry limit = any ? UINT64_MAX : bvh_entry_limit(w->best.t);
    while (w->top != w->bottom) {
        const bvh_entry entry = *--w->top;
        w->ref = (uint32_t)entry;
        if (entry <= limit)
            return true;
    }
    return false;
}

/* Past one node or leaf. False: the walk has ended. */
static inline __attribute__((always_inline)) bool go_on(struct walker *w, bool any)
{
    const struct bvh_query *q = &w->query;
    if (bvh_ref_kind(w->ref) == BVH_NODE) {
        if (descend(w, any)) { /* all lines, of a block; what waits has been asked for */
            fetch_lines(bvh_data_at(q, w->ref), sizeof(struct stage_block));
            return true;
        }
    } else if (bvh_ref_kind(w->ref) == BVH_BLOCK) {
        if (bvh_block_hit(q, NULL, bvh_data_at(q, w->ref), any, &w->best))
            return false;
    } else if (bvh_leaf_hit(q, &w->box, w->ref, any, &w->best)) {
        return false;
    }
    return turn_back(w, any);
}

/* False: it is no ray, or its walk has ended already. */
static inline __attribute__((always_inline)) bool start(struct walker *w, const struct stage *s,
                                                        const struct ray *ray, bool any)
{
    w->top = w->bottom;
    w->ref = bvh_root(s, 0);
    w->best.prim = STAGE_NONE;
    if (!bvh_query_make(s, ray, &w->query, &w->box))
        return false;
    bvh_best_init(&w->best, &w->query);
    for (int level = 0; level < TOP_LEVELS && bvh_ref_kind(w->ref) == BVH_NODE; level++)
        if (!go_on(w, any))
            return false;
    return true;
}

/* Bit i of what is returned: ray i has met something. */
static inline __attribute__((always_inline)) uint32_t
walk(struct walkers *all, const struct stage *s, uint32_t which, const struct ray rays[], bool any)
{
    uint32_t going = 0, found = 0;
    for (uint32_t left = which; left; left &= left - 1) {
        const uint32_t i = (uint32_t)__builtin_ctz(left);
        all->of[i].bottom = all->stack[i];
        going |= (uint32_t)start(&all->of[i], s, &rays[i], any) << i;
    }
    while (going)
        for (uint32_t left = going; left; left &= left - 1) {
            const uint32_t i = (uint32_t)__builtin_ctz(left);
            if (!go_on(&all->of[i], any))
                going &= ~(1u << i);
        }
    for (uint32_t left = which; left; left &= left - 1) {
        const uint32_t i = (uint32_t)__builtin_ctz(left);
        found |= (uint32_t)(all->of[i].best.prim != STAGE_NONE) << i;
    }
    return found;
}

uint32_t bvh_turns_closest(const struct stage *s, uint32_t which, const struct ray rays[],
                           struct ray_hit hits[])
{
    struct walkers all;
    const uint32_t found = walk(&all, s, which, rays, false);
    for (uint32_t left = found; left; left &= left - 1) {
        const uint32_t i = (uint32_t)__builtin_ctz(left);
        bvh_best_tell(&all.of[i].best, &hits[i]);
    }
    return found;
}

uint32_t bvh_turns_any(const struct stage *s, uint32_t which, const struct ray rays[])
{
    struct walkers all;
    return walk(&all, s, which, rays, true);
}
