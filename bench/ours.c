/* SPDX-License-Identifier: MIT */
#include "bench/ours.h"

#include <stdlib.h>

#include "common/clock.h"
#include "common/trace/bvh_build.h"
#include "common/trace/tri.h"
#include "tests/catalog.h"

static inline struct ray ray_of(const struct shot *s)
{
    return (struct ray){vec3_load(s->origin), vec3_load(s->dir), s->t_max, 0, 0};
}

static inline struct shot_hit hit_of(const struct ray_hit *h)
{
    return (struct shot_hit){h->t, h->u, h->v, h->prim};
}

static inline struct shot_hit miss_of(const struct shot *s)
{
    return (struct shot_hit){.t = s->t_max, .prim = SHOTS_MISS};
}

static inline struct shot_hit any_of(bool hit)
{
    return (struct shot_hit){.prim = hit ? 0 : SHOTS_MISS};
}

void ours_trace(const struct stage *stage, const struct shots *s, struct shot_hit *hits)
{
    if (s->kind == SHOTS_SHADOW)
        for (size_t i = 0; i < s->count; i++) {
            const struct ray ray = ray_of(&s->list[i]);
            hits[i] = any_of(bvh_hit_any(stage, &ray));
        }
    else
        for (size_t i = 0; i < s->count; i++) {
            const struct ray ray = ray_of(&s->list[i]);
            struct ray_hit hit;
            hits[i] = bvh_hit_closest(stage, &ray, &hit) ? hit_of(&hit) : miss_of(&s->list[i]);
        }
}

void ours_trace_eights(const struct stage *stage, const struct shots *s, struct shot_hit *hits)
{
    struct ray rays[8];
    struct ray_hit found[8];
    for (size_t at = 0; at < s->count; at += 8) {
        const uint32_t count = (uint32_t)min_size(8, s->count - at);
        for (uint32_t i = 0; i < count; i++) {
            rays[i] = ray_of(&s->list[at + i]);
            found[i] = (struct ray_hit){.t = rays[i].t_max, .prim = SHOTS_MISS};
        }
        if (s->kind == SHOTS_SHADOW) {
            const uint32_t any = bvh_hit_any_8(stage, (1u << count) - 1, rays);
            for (uint32_t i = 0; i < count; i++)
                hits[at + i] = any_of(any >> i & 1);
        } else {
            bvh_hit_closest_8(stage, (1u << count) - 1, rays,
                              found); /* leaves misses as they are */
            for (uint32_t i = 0; i < count; i++)
                hits[at + i] = hit_of(&found[i]);
        }
    }
}

/* The triangles by their numbers, as prep_shapes.c has them before the tree is there. */
static struct stage_triangle *triangles_of(const struct stage *s, struct arena *arena)
{
    struct stage_triangle *triangles = arena_new(arena, struct stage_triangle, s->prim_count);
    struct stage_id id;
    for (uint64_t at = 0; catalog_next(s, &at, &id);) {
        if (id.place.kind != STAGE_TRIANGLE || id.instance != STAGE_NONE)
            abort();
        triangles[id.prim] = stage_triangle_at(s, id.place.index, STAGE_NONE);
    }
    return triangles;
}

static void bound(const struct stage_triangle *triangles, uint32_t count, struct bvh_item *items,
                  uint32_t *prims)
{
    for (uint32_t i = 0; i < count; i++) {
        vec3 lo, hi;
        tri_bounds(&triangles[i], &lo, &hi);
        items[i] = bvh_item_make(BVH_BLOCK, i, lo, hi);
        prims[i] = i;
    }
}

int64_t ours_build(const struct stage *s)
{
    const uint32_t count = s->prim_count;
    struct arena input = {0}, item_arena = {0}, arena = {0};
    const struct stage_triangle *triangles = triangles_of(s, &input);
    const int64_t begin = clock_process_cpu_us();
    struct bvh_item *items = arena_alloc(&item_arena, count, sizeof *items, 64);
    uint32_t *prims = arena_new(&arena, uint32_t, count);
    bound(triangles, count, items, prims);
    struct bvh_plan plan = bvh_plan_make(items, count, NULL);
    arena_release(&item_arena);
    const struct bvh_site site = {arena_alloc(&arena, plan.node_count, sizeof(struct bvh_node), 64),
                                  0, BVH_NODE_LINES * plan.node_count};
    bvh_plan_write(&plan, &site, NULL);
    struct stage_block *blocks = arena_alloc(&arena, plan.leaf_count, sizeof *blocks, 64);
    bvh_plan_fill(&plan, triangles, prims, blocks, NULL);
    const int64_t us = clock_process_cpu_us() - begin;
    if (plan.node_count != s->nodes.count || plan.leaf_count != s->blocks.count)
        abort(); /* it is the same tree */
    bvh_plan_release(&plan);
    arena_release(&arena);
    arena_release(&input);
    return us;
}

static double half_area(const float (*plane)[8], int lane)
{
    const double x = (double)plane[1][lane] - (double)plane[0][lane],
                 y = (double)plane[3][lane] - (double)plane[2][lane],
                 z = (double)plane[5][lane] - (double)plane[4][lane];
    return x * y + y * z + z * x;
}

/* Of the bounds of everything; the nodes' planes are padded by a millionth. */
static double half_area_of_all(const struct stage *s)
{
    const double x = (double)s->bounds[1][0] - (double)s->bounds[0][0],
                 y = (double)s->bounds[1][1] - (double)s->bounds[0][1],
                 z = (double)s->bounds[1][2] - (double)s->bounds[0][2];
    return x * y + y * z + z * x;
}

/* A ray that meets everything's bounds tests one node, and then each child that it meets: a node or
 * a block, one vector test. Embree's sahCost counts the same (area of nodes, area of leaves times
 * their blocks), its blocks being of four triangles. */
struct ours_tree ours_tree(const struct stage *s)
{
    const struct bvh_node *nodes = stage_at(s, s->nodes);
    struct ours_tree tree = {.bytes = s->nodes.count * sizeof *nodes +
                                      s->blocks.count * sizeof(struct stage_block),
                             .inner = s->nodes.count,
                             .leaves = s->blocks.count};
    for (uint64_t i = 0; i < s->nodes.count; i++)
        for (int k = 0; nodes[i].used >> k; k++)
            tree.sah += half_area(nodes[i].plane, k);
    tree.sah = 1 + tree.sah / half_area_of_all(s);
    return tree;
}
