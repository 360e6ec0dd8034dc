/* bvh_turns.h - rays in a hierarchy that is in no cache, walking in turn: each asks for the node or
 * leaf that it needs next, which is on its way from memory while the others go on. They have
 * nothing else in common. Private to bvh_batch.c.
 *
 * It pays where a ray waits for memory, and costs where it does not, because a ray's own numbers
 * leave the registers whenever another's turn comes.
 * SPDX-License-Identifier: MIT */
#ifndef COMMON_TRACE_BVH_TURNS_H
#define COMMON_TRACE_BVH_TURNS_H

#include "common/trace/bvh_walk.h"

/* Blocks of the world, 5 MB of them. Paths inside a ball of 87 or 16 MB of blocks took .8 of the
 * time when their rays took turns, of 4 MB .98, of .4 MB 1.15 (processors with caches of .5 MB,
 * and a larger one that others use as well). */
enum { BVH_TURNS_FROM = 16384 };

static inline bool bvh_turns_pay(const struct stage *s, uint32_t which)
{
    const struct stage_tree *world = stage_at(s, s->trees);
    return world->block_end - world->block_begin >= BVH_TURNS_FROM && (which & (which - 1));
}

/* As bvh_hit_closest_8 and bvh_hit_any_8. */
uint32_t bvh_turns_closest(const struct stage *, uint32_t which, const struct ray rays[],
                           struct ray_hit hits[]);
uint32_t bvh_turns_any(const struct stage *, uint32_t which, const struct ray rays[]);

#endif
