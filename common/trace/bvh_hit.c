/* One ray, and the leaves that are no blocks; the walk itself is in bvh_walk.h.
 * SPDX-License-Identifier: MIT */
#include "common/trace/bvh_walk.h"

static bool round_ref_hit(const struct bvh_query *q, uint32_t ref, bool any, struct bvh_best *best)
{
    const struct stage_place place = {(bvh_ref_kind(ref) - BVH_BLOCK) & 7,
                                      bvh_ref_index(ref) & 0x1fffffff};
    uint32_t prim;
    const float t = bvh_prim_round(q, place, &prim);
    if (!(t > 0) || (!any && !is_nearer(best, t, prim)))
        return false;
    *best = (struct bvh_best){t, prim, {1, 0, 0}, place, STAGE_NONE};
    return any;
}

static __attribute__((noinline)) bool instance_hit(const struct bvh_query *q,
                                                   const struct box8_ray *world, uint32_t instance,
                                                   bool any, struct bvh_best *best)
{
    struct bvh_space space;
    if (!bvh_space_make(q, world, instance, &space))
        return false;
    const uint32_t root = bvh_root(q->stage, stage_instance_at(q->stage, instance)->tree);
    return any ? bvh_walk(q, &space.box, &space, root, true, best)
               : bvh_walk(q, &space.box, &space, root, false, best);
}

bool bvh_leaf_hit(const struct bvh_query *q, const struct box8_ray *world, uint32_t ref, bool any,
                  struct bvh_best *best)
{
    return bvh_ref_kind(ref) == BVH_INSTANCE ? instance_hit(q, world, bvh_ref_index(ref), any, best)
                                             : round_ref_hit(q, ref, any, best);
}

bool bvh_hit_closest(const struct stage *s, const struct ray *ray, struct ray_hit *hit)
{
    struct bvh_best best;
    if (!bvh_ask(s, ray, false, &best))
        return false;
    bvh_best_tell(&best, hit);
    return true;
}

bool bvh_hit_any(const struct stage *s, const struct ray *ray)
{
    struct bvh_best best;
    return bvh_ask(s, ray, true, &best);
}
