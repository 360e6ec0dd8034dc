/* Up to eight rays, made ready together; those that go the same way are walked together.
 * SPDX-License-Identifier: MIT */
#include "common/trace/bvh_turns.h"
#include "common/trace/bvh_walk.h"

enum { BATCH_FEW = 2 }; /* so many rays or fewer go on alone */

/* So far may directions lie from the first, in parts of its longest component. */
#define BATCH_SPREAD 0.25f

struct batch {
    uint32_t rays; /* bit i: there is a ray i */
    struct box8_rays box;
    struct bvh_query query[8];
    struct box8_fan fan;
    struct bvh_best best[8];
    _Alignas(32) float t[8]; /* best[i].t */
    uint32_t found;          /* bit i, any hit */
};

/* False: one is no ray, or numbers are too large, or there is nothing to hit. */
static bool batch_init(struct batch *b, const struct stage *s, uint32_t which,
                       const struct ray rays[])
{
    const uint32_t first = (uint32_t)__builtin_ctz(which); /* in the place of those not there */
    vec3 origin[8], dir[8];
    f32x8 o[3], d[3];
    struct tri_rays tri;
    for (uint32_t i = 0; i < 8; i++) {
        const struct ray *ray = &rays[which >> i & 1 ? i : first];
        origin[i] = ray->origin;
        dir[i] = ray->dir;
    }
    f32x8_columns(origin, o);
    f32x8_columns(dir, d);
    tri_rays_make(o, d, &tri);
    box8_rays_init(&b->box, o, d);
    bool valid = bvh_root(s, 0) != bvh_ref_make(BVH_NOTHING, 0);
    for (uint32_t i = 0; i < 8; i++) {
        struct bvh_query *q = &b->query[i];
        const struct ray *ray = &rays[which >> i & 1 ? i : first];
        q->stage = s;
        q->first = stage_at(s, s->nodes);
        q->tri = (struct tri_ray){ray, tri.row[i], tri.at[i], tri.shear[i]};
        q->t_max = ray->t_max < FLT_MAX ? ray->t_max : FLT_MAX;
        bvh_best_init(&b->best[i], q);
        b->t[i] = q->t_max;
        valid = valid && bvh_is_ray(ray) && q->tri.shear[2] == 1;
    }
    b->rays = which;
    b->found = 0;
    return valid && box8_fan_init(&b->fan, &b->box);
}

/* --- one ray of the batch --- */

/* What came of it, for those who go on together. */
static inline void ray_done(struct batch *b, uint32_t i, bool any, bool found)
{
    b->found |= (uint32_t)(any && found) << i;
    b->t[i] = b->best[i].t;
}

/* The walk from ref on. */
static inline __attribute__((always_inline)) void ray_walk(struct batch *b, uint32_t i,
                                                           uint32_t ref, bool any)
{
    struct box8_ray box;
    box8_rays_take(&b->box, i, &box);
    ray_done(b, i, any, bvh_walk(&b->query[i], &box, NULL, ref, any, &b->best[i]));
}

static __attribute__((noinline)) void rays_walk_closest(struct batch *b, uint32_t rays,
                                                        uint32_t ref)
{
    for (; rays; rays &= rays - 1)
        ray_walk(b, (uint32_t)__builtin_ctz(rays), ref, false);
}

static __attribute__((noinline)) void rays_walk_any(struct batch *b, uint32_t rays, uint32_t ref)
{
    for (; rays; rays &= rays - 1)
        ray_walk(b, (uint32_t)__builtin_ctz(rays), ref, true);
}

static inline void rays_walk(struct batch *b, uint32_t rays, uint32_t ref, bool any)
{
    if (any)
        rays_walk_any(b, rays, ref);
    else
        rays_walk_closest(b, rays, ref);
}

static inline __attribute__((always_inline)) void rays_leaf(struct batch *b, uint32_t rays,
                                                            uint32_t ref, bool any)
{
    for (; rays; rays &= rays - 1) {
        const uint32_t i = (uint32_t)__builtin_ctz(rays);
        const struct bvh_query *q = &b->query[i];
        if (bvh_ref_kind(ref) == BVH_BLOCK) {
            ray_done(b, i, any, bvh_block_hit(q, NULL, bvh_data_at(q, ref), any, &b->best[i]));
            continue;
        }
        struct box8_ray box;
        box8_rays_take(&b->box, i, &box);
        ray_done(b, i, any, bvh_leaf_hit(q, &box, ref, any, &b->best[i]));
    }
}

/* --- together --- */

struct waiting {
    bvh_entry entry; /* its t: before any of the rays enters */
    uint32_t rays;   /* bit i: ray i passes the box */
};

/* The children that rays meet, the nearer above. Returns the new top. */
static inline uint32_t push_children(const struct batch *b, const struct bvh_node *node,
                                     uint32_t rays, struct waiting *stack, uint32_t top)
{
    _Alignas(32) uint32_t t[BVH_WIDTH];
    const f32x8 far = f32x8_load(b->t);
    const uint32_t bottom = top;
    f32x8 near;
    uint32_t hits = box8_fan_hit(&b->fan, node->plane, f32x8_most(far), &near) & node->used;
    f32x8_store_bits(t, near);
    for (; hits; hits &= hits - 1) {
        const uint32_t child = (uint32_t)__builtin_ctz(hits);
        const uint32_t meet = rays & box8_rays_hit(&b->box, b->fan.planes, node->plane, child, far);
        if (!meet)
            continue;
        const struct waiting next = {bvh_entry_make(t[child], node->child[child]), meet};
        uint32_t at = top++;
        for (; at > bottom && stack[at - 1].entry < next.entry; at--)
            stack[at] = stack[at - 1];
        stack[at] = next;
        bvh_fetch(b->query, node->child[child]);
    }
    return top;
}

static inline __attribute__((always_inline)) void walk_together(struct batch *b, uint32_t root,
                                                                bool any)
{
    struct waiting stack[BVH_STACK];
    uint32_t top = 1;
    stack[0] = (struct waiting){bvh_entry_make(0, root), b->rays};
    while (top) {
        const struct waiting next = stack[--top];
        const uint32_t ref = (uint32_t)next.entry;
        /* boxes as near as the best hit are still opened, as in bvh_walk.h */
        const i32x8 near = f32x8_splat(bvh_entry_t(next.entry)) <= f32x8_load(b->t);
        const uint32_t rays = next.rays & ~b->found & i32x8_mask(near);
        if (!rays)
            continue;
        if (__builtin_popcount(rays) <= BATCH_FEW)
            rays_walk(b, rays, ref, any);
        else if (bvh_ref_kind(ref) == BVH_NODE)
            top = push_children(b, bvh_data_at(b->query, ref), rays, stack, top);
        else
            rays_leaf(b, rays, ref, any);
    }
}

/* Whether the directions have the same signs and are near each other: else there is little to
 * share, and what follows is not worth its price. */
static inline bool agree(uint32_t which, const struct ray rays[])
{
    if (__builtin_popcount(which) <= BATCH_FEW) /* or there is none at all */
        return false;
    const vec3 none = {0}, first = rays[__builtin_ctz(which)].dir;
    const uint32_t signs = i32x4_mask(first < none) & 7;
    vec3 apart = none;
    for (which &= which - 1; which; which &= which - 1) {
        const uint32_t i = (uint32_t)__builtin_ctz(which);
        if ((i32x4_mask(rays[i].dir < none) & 7) != signs)
            return false;
        apart = vec3_max(vec3_abs(rays[i].dir - first), apart);
    }
    return box8_reach(apart) <= BATCH_SPREAD * box8_reach(first);
}

/* One by one, without a call for each. */
static __attribute__((noinline)) uint32_t
alone_closest(const struct stage *s, uint32_t which, const struct ray rays[], struct ray_hit hits[])
{
    uint32_t found = 0;
    for (; which; which &= which - 1) {
        const uint32_t i = (uint32_t)__builtin_ctz(which);
        struct bvh_best best;
        if (!bvh_ask(s, &rays[i], false, &best))
            continue;
        bvh_best_tell(&best, &hits[i]);
        found |= 1u << i;
    }
    return found;
}

static __attribute__((noinline)) uint32_t alone_any(const struct stage *s, uint32_t which,
                                                    const struct ray rays[])
{
    uint32_t found = 0;
    for (; which; which &= which - 1) {
        const uint32_t i = (uint32_t)__builtin_ctz(which);
        struct bvh_best best;
        found |= (uint32_t)bvh_ask(s, &rays[i], true, &best) << i;
    }
    return found;
}

/* False: they have to go one by one. */
static inline __attribute__((always_inline)) bool
batch_go(struct batch *b, const struct stage *s, uint32_t which, const struct ray rays[], bool any)
{
    if (!batch_init(b, s, which, rays))
        return false;
    walk_together(b, bvh_root(s, 0), any);
    return true;
}

static __attribute__((noinline)) uint32_t together_closest(const struct stage *s, uint32_t which,
                                                           const struct ray rays[],
                                                           struct ray_hit hits[])
{
    struct batch b;
    uint32_t found = 0;
    if (!batch_go(&b, s, which, rays, false))
        return alone_closest(s, which, rays, hits);
    for (; which; which &= which - 1) {
        const uint32_t i = (uint32_t)__builtin_ctz(which);
        if (b.best[i].prim == STAGE_NONE)
            continue;
        bvh_best_tell(&b.best[i], &hits[i]);
        found |= 1u << i;
    }
    return found;
}

static __attribute__((noinline)) uint32_t together_any(const struct stage *s, uint32_t which,
                                                       const struct ray rays[])
{
    struct batch b;
    return batch_go(&b, s, which, rays, true) ? b.found : alone_any(s, which, rays);
}

uint32_t bvh_hit_closest_8(const struct stage *s, uint32_t which, const struct ray rays[],
                           struct ray_hit hits[])
{
    if (agree(which, rays))
        return together_closest(s, which, rays, hits);
    return bvh_turns_pay(s, which) ? bvh_turns_closest(s, which, rays, hits)
                                   : alone_closest(s, which, rays, hits);
}

uint32_t bvh_hit_any_8(const struct stage *s, uint32_t which, const struct ray rays[])
{
    if (agree(which, rays))
        return together_any(s, which, rays);
    return bvh_turns_pay(s, which) ? bvh_turns_any(s, which, rays) : alone_any(s, which, rays);
}
