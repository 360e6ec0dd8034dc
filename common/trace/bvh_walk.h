/* bvh_walk.h - what one ray's walk through the hierarchy (bvh_hit.c) and that of eight
 * (bvh_batch.c, bvh_turns.c) have in common. Private to these. SPDX-License-Identifier: MIT */
#ifndef COMMON_TRACE_BVH_WALK_H
#define COMMON_TRACE_BVH_WALK_H

#include "common/trace/bvh_leaf.h"

static inline uint32_t bvh_root(const struct stage *s, uint32_t tree)
{
    return ((const struct stage_tree *)stage_at(s, s->trees))[tree].root;
}

static inline void bvh_best_init(struct bvh_best *best, const struct bvh_query *q)
{
    best->t = q->t_max;
    best->prim = STAGE_NONE;
}

static inline void bvh_best_tell(const struct bvh_best *best, struct ray_hit *hit)
{
    *hit = (struct ray_hit){best->t, best->prim, 0, 0, best->place, best->instance};
    const vec3 e = best->edges;
    tri_weights((struct tri_edges){e[0], e[1], e[2]}, &hit->u, &hit->v);
}

/* What waits on the stack: where the ray enters a child's box, in the upper half, and its
 * reference. For numbers that are not negative the order of floats is that of their bits. */
typedef uint64_t bvh_entry;

static inline bvh_entry bvh_entry_make(uint32_t t_bits, uint32_t ref)
{
    return (bvh_entry)t_bits << 32 | ref;
}

static inline float bvh_entry_t(bvh_entry e)
{
    const uint32_t bits = (uint32_t)(e >> 32);
    float t;
    memcpy(&t, &bits, sizeof t);
    return t;
}

/* The last one that is still of interest. */
static inline bvh_entry bvh_entry_limit(float t)
{
    uint32_t bits;
    memcpy(&bits, &t, sizeof bits);
    return bvh_entry_make(bits, UINT32_MAX);
}

static inline void bvh_entry_order(bvh_entry *a, bvh_entry *b)
{
    const bvh_entry x = *a, y = *b;
    *a = x < y ? x : y;
    *b = x < y ? y : x;
}

/* Its data, before they are needed: they come from far away in a large scene. (For what is neither
 * node nor block, some other data: a prefetch may fail.) */
static inline void bvh_fetch(const struct bvh_query *q, uint32_t ref)
{
    const unsigned char *at = bvh_data_at(q, ref);
    for (int line = 0; line < BVH_BLOCK_LINES; line += 2) /* the one beside it comes along */
        __builtin_prefetch(at + BVH_LINE * line);
}

/* A leaf that is no block, in the world. True: any is asked for, and found. */
bool bvh_leaf_hit(const struct bvh_query *, const struct box8_ray *world, uint32_t ref, bool any,
                  struct bvh_best *);

/* The lowest bit set, which there is. As 64 bits, so that nothing has to be extended. */
static inline uint64_t bvh_lowest(uint64_t bits)
{
    return (uint64_t)__builtin_ctzll(bits);
}

/* The nearest child is returned to go on with, the others wait on the stack, the nearer above. One
 * or two are the rule: for them there is nothing to mispredict but the number. */
static inline __attribute__((always_inline)) uint32_t bvh_nearest_child(const struct bvh_query *q,
                                                                        const struct bvh_node *node,
                                                                        uint64_t hits, f32x8 near,
                                                                        bvh_entry **top)
{
    uint64_t i = bvh_lowest(hits);
    hits &= hits - 1;
    if (!hits)
        return node->child[i];
    _Alignas(32) uint32_t t[BVH_WIDTH];
    f32x8_store_bits(t, near);
    bvh_entry first = bvh_entry_make(t[i], node->child[i]);
    i = bvh_lowest(hits);
    hits &= hits - 1;
    bvh_entry second = bvh_entry_make(t[i], node->child[i]);
    bvh_fetch(q, (uint32_t)first);
    bvh_fetch(q, (uint32_t)second);
    bvh_entry_order(&first, &second);
    bvh_entry *const bottom = *top;
    *(*top)++ = second;
    for (; hits; hits &= hits - 1) {
        i = bvh_lowest(hits);
        bvh_entry next = bvh_entry_make(t[i], node->child[i]);
        bvh_entry_order(&first, &next);
        bvh_fetch(q, (uint32_t)next);
        bvh_entry *at = (*top)++;
        for (; at > bottom && at[-1] < next; at--)
            at[0] = at[-1];
        *at = next;
    }
    return (uint32_t)first;
}

/* The last child, which is next to its parent in memory, is returned, the others wait. */
static inline __attribute__((always_inline)) uint32_t bvh_last_child(const struct bvh_query *q,
                                                                     const struct bvh_node *node,
                                                                     uint64_t hits, bvh_entry **top)
{
    for (;;) {
        const uint32_t child = node->child[bvh_lowest(hits)];
        hits &= hits - 1;
        if (!hits)
            return child;
        bvh_fetch(q, child);
        *(*top)++ = child;
    }
}

/* inside: the instance whose tree it is, or NULL. any: the first hit will do, in no order. True: it
 * has been found. Inlined, so that there is one loop for each answer. */
static inline __attribute__((always_inline)) bool
bvh_walk(const struct bvh_query *q, const struct box8_ray *box, const struct bvh_space *inside,
         uint32_t ref, bool any, struct bvh_best *best)
{
    bvh_entry stack[BVH_STACK], *top = stack;
    for (;;) {
        while (ref < bvh_ref_make(BVH_NODE + 1, 0)) {
            const struct bvh_node *node = bvh_data_at(q, ref);
            f32x8 near, far;
            uint64_t hits = box8_hit(box, node->plane, best->t, &near, &far) & node->used;
            if (!hits)
                goto next;
            if (!any) {
                ref = bvh_nearest_child(q, node, hits, near, &top);
                continue;
            }
            ref = bvh_last_child(q, node, hits, &top);
        }
        if (bvh_ref_kind(ref) == BVH_BLOCK) {
            if (bvh_block_hit(q, inside, bvh_data_at(q, ref), any, best))
                return true;
        } else if (inside) {
            __builtin_unreachable(); /* a shared mesh has only triangles */
        } else if (bvh_leaf_hit(q, box, ref, any, best)) {
            return true;
        }
    next:; /* boxes as near as the best hit are still opened: an equal hit may have a smaller number
            */
        const bvh_entry limit = any ? UINT64_MAX : bvh_entry_limit(best->t);
        do {
            if (top == stack)
                return false;
        } while (*--top > limit);
        ref = (uint32_t)*top;
    }
}

/* One ray alone. True: something has been found. */
static inline __attribute__((always_inline)) bool
bvh_ask(const struct stage *s, const struct ray *ray, bool any, struct bvh_best *best)
{
    struct bvh_query q;
    struct box8_ray world;
    const uint32_t root = bvh_root(s, 0);
    if (root == bvh_ref_make(BVH_NOTHING, 0) || !bvh_query_make(s, ray, &q, &world))
        return false;
    bvh_best_init(best, &q);
    return bvh_walk(&q, &world, NULL, root, any, best) || best->prim != STAGE_NONE;
}

#endif
