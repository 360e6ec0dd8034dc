/* oracle_bvh.h - the plain tree: binary, one box after the other, in double. The core's eight-wide
 * tree must find what it finds, to the last bit.
 *
 * Over the primitives of a stage, each tested by bvh_hit_prim; its boxes, its builder and its
 * walk share nothing with the core's. Slow, but fast enough for millions of rays where going
 * through all primitives is not.
 * SPDX-License-Identifier: MIT */
#ifndef TESTS_ORACLE_BVH_H
#define TESTS_ORACLE_BVH_H

#include "common/arena.h"
#include "common/trace/ray.h"
#include "common/trace/stage.h"

struct oracle_node;

struct oracle {
    const struct stage *stage;
    struct arena arena;
    struct stage_id *ids;
    struct oracle_node *nodes;
    uint32_t node_count;
};

void oracle_make(struct oracle *, const struct stage *);
void oracle_release(struct oracle *);

bool oracle_closest(const struct oracle *, const struct ray *, struct ray_hit *);
bool oracle_any(const struct oracle *, const struct ray *);

#endif
