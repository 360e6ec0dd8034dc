/* Binary BVH by the binned surface area heuristic: I. Wald, "On fast Construction of SAH-based
 * Bounding Volume Hierarchies", RT 2007. Every triangle is in one leaf, whatever it crosses: a tree
 * of N triangles has fewer than 2 N nodes, known before it is built. SPDX-License-Identifier: MIT
 */
#include <stdlib.h>

#include "bench/accel/build.h"
#include "bench/accel/query.h"
#include "common/arena.h"

enum { BINS = 16, LEAF_MAX = 4, MAX_DEPTH = 96, SAH_DEPTH = 64 /* halved from there on */ };

#define STEP_COST 1.0f /* in units of a triangle test */

struct builder {
    struct bvh2 *tree;
    struct accel_box *boxes;
    const struct accel_limits *limits;
};

struct part { /* what becomes of a node: its triangles are refs[begin, end) */
    uint32_t begin, end, node, depth;
};

struct bins { /* equal ones along an axis, for the middles of boxes */
    int axis;
    float lo, scale;
    int split; /* bins below it go to the first child */
};

static int bin_of(const struct bins *bins, const struct accel_box *box)
{
    const float middle = 0.5f * box->lo[bins->axis] + 0.5f * box->hi[bins->axis];
    const float at = (middle - bins->lo) * bins->scale;
    return at > 0 ? (at < BINS - 1 ? (int)at : BINS - 1) : 0;
}

/* Puts the cheapest split of these bins into *best if it is cheaper than *least. */
static void judge(const struct builder *b, const struct part *p, struct bins bins, float *least,
                  struct bins *best)
{
    struct accel_box box[BINS], side = build_empty();
    uint32_t count[BINS] = {0}, n = 0;
    float cost[BINS];
    for (int i = 0; i < BINS; i++)
        box[i] = side;
    for (uint32_t i = p->begin; i < p->end; i++) {
        const struct accel_box *of = &b->boxes[b->tree->refs[i]];
        const int bin = bin_of(&bins, of);
        count[bin]++;
        build_cover(&box[bin], of);
    }
    for (int i = 1; i < BINS; i++) {
        n += count[i - 1];
        build_cover(&side, &box[i - 1]);
        cost[i] = build_half_area(&side) * (float)n;
    }
    side = build_empty();
    n = 0;
    for (int i = BINS - 1; i > 0; i--) {
        n += count[i];
        build_cover(&side, &box[i]);
        cost[i] += build_half_area(&side) * (float)n;
        if (n && n < p->end - p->begin && cost[i] < *least) {
            *least = cost[i];
            *best = bins;
            best->split = i;
        }
    }
}

/* Where the second child begins; p->end: a leaf. Sets the node's box. */
static uint32_t choose(struct builder *b, const struct part *p)
{
    struct bvh2_node *node = &b->tree->nodes[p->node];
    struct accel_box box = build_empty(), middles = build_empty();
    const uint32_t count = p->end - p->begin;
    for (uint32_t i = p->begin; i < p->end; i++) {
        const struct accel_box *of = &b->boxes[b->tree->refs[i]];
        struct accel_box at;
        for (int k = 0; k < 3; k++)
            at.lo[k] = at.hi[k] = 0.5f * of->lo[k] + 0.5f * of->hi[k];
        build_cover(&box, of);
        build_cover(&middles, &at);
    }
    for (int k = 0; k < 3; k++) {
        node->lo[k] = box.lo[k];
        node->hi[k] = box.hi[k];
    }
    const float area = build_half_area(&box);
    float least = count <= LEAF_MAX ? ((float)count - STEP_COST) * area : __builtin_inff();
    struct bins best = {.split = 0};
    for (int k = 0; k < 3 && count > 1 && p->depth < SAH_DEPTH; k++) {
        const float scale = BINS / (middles.hi[k] - middles.lo[k]);
        if (scale > 0 && scale < __builtin_inff())
            judge(b, p, (struct bins){k, middles.lo[k], scale, 0}, &least, &best);
    }
    if (!best.split)
        return count <= LEAF_MAX ? p->end : p->begin + count / 2;
    uint32_t middle = p->begin, *refs = b->tree->refs;
    for (uint32_t i = p->begin; i < p->end; i++)
        if (bin_of(&best, &b->boxes[refs[i]]) < best.split) {
            const uint32_t prim = refs[i];
            refs[i] = refs[middle];
            refs[middle++] = prim;
        }
    return middle;
}

static bool build_part(struct builder *b, const struct part *p, struct err *err)
{
    if (!build_within(b->limits, bvh2_bytes(b->tree), p->end - p->begin, err))
        return false;
    const uint32_t middle = choose(b, p);
    struct bvh2_node *node = &b->tree->nodes[p->node];
    if (middle == p->end) {
        node->first = p->begin;
        node->count = p->end - p->begin;
        return true;
    }
    node->first = (uint32_t)b->tree->node_count;
    b->tree->node_count += 2;
    const struct part first = {p->begin, middle, node->first, p->depth + 1};
    const struct part second = {middle, p->end, node->first + 1, p->depth + 1};
    return build_part(b, &first, err) && build_part(b, &second, err);
}

bool bvh2_build(struct bvh2 *t, struct accel_mesh mesh, const struct accel_limits *limits,
                struct err *err)
{
    *t = (struct bvh2){.mesh = mesh, .bounds = build_bounds(mesh)};
    if (!mesh.count)
        return true;
    struct builder b = {t, build_boxes(mesh), limits};
    t->nodes = arena_malloc(2 * (size_t)mesh.count, sizeof *t->nodes);
    t->refs = arena_malloc(mesh.count, sizeof *t->refs);
    for (uint32_t i = 0; i < mesh.count; i++)
        t->refs[i] = i;
    t->node_count = 1;
    const bool done = build_part(&b, &(struct part){0, mesh.count, 0, 0}, err);
    free(b.boxes);
    if (!done)
        bvh2_release(t);
    return done;
}

bool bvh2_hit(const struct bvh2 *t, const struct ray *ray, struct ray_hit *hit)
{
    struct query_visit stack[MAX_DEPTH + 1], *top = stack;
    struct query q;
    if (!query_enter(&q, t->mesh, &t->bounds, ray, top++))
        return false;
    while (top > stack) {
        const struct query_visit v = *--top;
        if (v.begin > q.best.t) /* an equal hit in there may have a smaller number */
            continue;
        const struct bvh2_node *node = &t->nodes[v.node];
        while (!node->count) {
            const struct bvh2_node *child = &t->nodes[node->first];
            float in[2][2];
            const bool meets[2] = {query_box(&q, child[0].lo, child[0].hi, in[0]),
                                   query_box(&q, child[1].lo, child[1].hi, in[1])};
            if (!meets[0] && !meets[1])
                break; /* there are no triangles in an inner node */
            const bool near = meets[1] && (!meets[0] || in[1][0] < in[0][0]);
            if (meets[0] && meets[1])
                *top++ = (struct query_visit){node->first + !near, in[!near][0], in[!near][1]};
            node = &child[near];
        }
        query_triangles(&q, t->refs + node->first, node->count);
    }
    return query_done(&q, hit);
}

uint64_t bvh2_bytes(const struct bvh2 *t)
{
    return t->node_count * sizeof *t->nodes + t->mesh.count * sizeof *t->refs;
}

void bvh2_release(struct bvh2 *t)
{
    free(t->nodes);
    free(t->refs);
}
