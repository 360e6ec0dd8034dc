/* SPDX-License-Identifier: MIT */
#include "bench/ours.h"

#include <stdlib.h>

#include "common/clock.h"
#include "common/trace/bvh.h"
#include "common/trace/tri.h"

static inline struct ray ray_of(const struct shot *s)
{
    return (struct ray){vec3_load(s->origin), vec3_load(s->dir), s->t_max};
}

void ours_trace(const struct stage *stage, const struct shots *s, struct shot_hit *hits)
{
    if (s->kind == SHOTS_SHADOW)
        for (size_t i = 0; i < s->count; i++) {
            const struct ray ray = ray_of(&s->list[i]);
            hits[i] = (struct shot_hit){.prim = bvh_hit_any(stage, &ray) ? 0 : SHOTS_MISS};
        }
    else
        for (size_t i = 0; i < s->count; i++) {
            const struct ray ray = ray_of(&s->list[i]);
            struct ray_hit hit;
            if (bvh_hit_closest(stage, &ray, &hit))
                hits[i] = (struct shot_hit){hit.t, hit.u, hit.v, hit.prim};
            else
                hits[i] = (struct shot_hit){.t = ray.t_max, .prim = SHOTS_MISS};
        }
}

int64_t ours_build(const struct stage *s)
{
    const uint32_t count = (uint32_t)s->prims.count;
    if (s->triangles.count != count)
        abort();
    const struct stage_triangle *triangles = stage_at(s, s->triangles);
    struct arena arena = {0};
    const int64_t begin = clock_process_cpu_us();
    struct bvh_box *boxes = arena_new(&arena, struct bvh_box, count);
    const unsigned char *kinds = arena_new(&arena, unsigned char, count); /* STAGE_TRIANGLE is 0 */
    for (uint32_t i = 0; i < count; i++)
        tri_bounds(triangles[i].v, boxes[i].lo, boxes[i].hi);
    const struct bvh_tree tree = bvh_build(boxes, kinds, count, &arena);
    const int64_t us = clock_process_cpu_us() - begin;
    if (tree.node_count != s->nodes.count) /* it is the same tree */
        abort();
    arena_release(&arena);
    return us;
}

static double half_area(const struct bvh_node *n)
{
    const double x = (double)n->hi[0] - (double)n->lo[0], y = (double)n->hi[1] - (double)n->lo[1],
                 z = (double)n->hi[2] - (double)n->lo[2];
    return x * y + y * z + z * x;
}

struct ours_tree ours_tree(const struct stage *s)
{
    enum { BLOCK = 4 };
    const struct bvh_node *nodes = stage_at(s, s->nodes);
    struct ours_tree tree = {.bytes = s->nodes.count * sizeof *nodes +
                                      s->leaf_prims.count * sizeof(uint32_t)};
    for (uint64_t i = 0; i < s->nodes.count; i++) {
        const struct bvh_node *n = &nodes[i];
        tree.sah += half_area(n) * (n->count ? (n->count + BLOCK - 1) / BLOCK : 1);
        tree.leaves += n->count > 0;
    }
    tree.inner = s->nodes.count - tree.leaves;
    tree.sah /= s->nodes.count ? half_area(nodes) : 1;
    return tree;
}
