/* k-d tree by the surface area heuristic, with a premium on empty space: I. Wald, V. Havran, "On
 * building fast kd-Trees for Ray Tracing, and on doing that in O(N log N)", RT 2006. Where a node
 * has many triangles, planes are tried at the borders of equal bins: M. Shevtsov, A. Soupikov, A.
 * Kapustin, "Highly Parallel Fast KD-tree Construction for Interactive Ray Tracing of Dynamic
 * Scenes", Eurographics 2007; where few, at every side of a triangle's box. Boxes are not shrunk to
 * the part of the triangle inside the node ("perfect splits"). SPDX-License-Identifier: MIT */
#include <math.h>
#include <stdlib.h>

#include "bench/accel/build.h"
#include "bench/accel/query.h"

enum { LEAF = 3 /* in place of an axis */, BINS = 32, FEW = 24, MAX_DEPTH = 64 };

#define STEP_COST     15.0f
#define TRIANGLE_COST 20.0f
#define EMPTY_PREMIUM 0.8f

struct builder {
    struct kdtree *tree;
    const struct accel_limits *limits;
    struct accel_box *boxes;
    struct accel_list waiting; /* triangles of the nodes from the root to the one at hand */
    uint32_t depth_max;
};

struct part { /* what becomes of a node: its triangles are waiting[begin, end) */
    size_t begin, end;
    struct accel_box box;
    uint32_t node, depth;
};

struct split {
    int axis;
    float at, cost;
};

static uint32_t add_nodes(struct kdtree *t, uint32_t count)
{
    t->nodes = build_grow(t->nodes, &t->node_room, t->node_count + count, sizeof *t->nodes);
    t->node_count += count;
    return (uint32_t)t->node_count - count;
}

/* A triangle that only touches the plane is on one side; one that lies in it is below. */
static bool is_below(float lo, float hi, float plane)
{
    return lo < plane || hi == plane;
}

static bool is_above(float hi, float plane)
{
    return hi > plane;
}

static void judge(const struct accel_box *box, int axis, float at, size_t below, size_t above,
                  struct split *best)
{
    struct accel_box low = *box, high = *box;
    if (!(at > box->lo[axis] && at < box->hi[axis]))
        return;
    low.hi[axis] = high.lo[axis] = at;
    const float tests =
        build_half_area(&low) * (float)below + build_half_area(&high) * (float)above;
    const float cost = (STEP_COST + TRIANGLE_COST * tests / build_half_area(box)) *
                       (below && above ? 1 : EMPTY_PREMIUM);
    if (cost < best->cost)
        *best = (struct split){axis, at, cost};
}

static void try_bins(const struct builder *b, const struct part *p, int axis, struct split *best)
{
    const float lo = p->box.lo[axis], width = (p->box.hi[axis] - lo) / BINS;
    size_t starts[BINS] = {0}, ends[BINS] = {0}, below = 0, above = p->end - p->begin;
    for (size_t i = p->begin; i < p->end; i++) {
        const struct accel_box box = b->boxes[b->waiting.at[i]];
        const float from = (box.lo[axis] - lo) / width, to = (box.hi[axis] - lo) / width;
        starts[from > 0 ? (from < BINS - 1 ? (int)from : BINS - 1) : 0]++;
        ends[to > 0 ? (to < BINS - 1 ? (int)to : BINS - 1) : 0]++;
    }
    for (int i = 1; i < BINS; i++) {
        below += starts[i - 1];
        above -= ends[i - 1];
        judge(&p->box, axis, lo + (float)i * width, below, above, best);
    }
}

static void try_sides(const struct accel_box *boxes, size_t count, const struct part *p, int axis,
                      struct split *best)
{
    for (size_t i = 0; i < 2 * count; i++) {
        const float at = i & 1 ? boxes[i / 2].hi[axis] : boxes[i / 2].lo[axis];
        size_t below = 0, above = 0;
        for (size_t j = 0; j < count; j++) {
            below += is_below(boxes[j].lo[axis], boxes[j].hi[axis], at);
            above += is_above(boxes[j].hi[axis], at);
        }
        judge(&p->box, axis, at, below, above, best);
    }
}

static struct split choose(const struct builder *b, const struct part *p)
{
    const size_t count = p->end - p->begin;
    struct split best = {LEAF, 0, TRIANGLE_COST * (float)count};
    struct accel_box boxes[FEW];
    if (p->depth == b->depth_max || !(build_half_area(&p->box) > 0))
        return best;
    for (size_t i = 0; count <= FEW && i < count; i++)
        boxes[i] = b->boxes[b->waiting.at[p->begin + i]];
    for (int axis = 0; axis < 3; axis++)
        if (count <= FEW)
            try_sides(boxes, count, p, axis, &best);
        else if ((p->box.hi[axis] - p->box.lo[axis]) / BINS > 0)
            try_bins(b, p, axis, &best);
    return best;
}

static bool build_part(struct builder *b, const struct part *p, struct err *err)
{
    if (!build_within(b->limits, kdtree_bytes(b->tree) + b->waiting.count * sizeof(uint32_t),
                      p->end - p->begin, err))
        return false;
    const struct split s = choose(b, p);
    if (s.axis == LEAF) {
        const uint32_t first = build_push_all(&b->tree->refs, &b->waiting, p->begin, p->end);
        b->tree->nodes[p->node] = (struct kdtree_node){.axis = LEAF, .first = first & 0x3fffffff};
        b->tree->nodes[p->node].count = (uint32_t)(p->end - p->begin);
        return true;
    }
    const uint32_t children = add_nodes(b->tree, 2);
    struct kdtree_node *node = &b->tree->nodes[p->node];
    node->axis = (uint32_t)s.axis & 3;
    node->first = children & 0x3fffffff;
    node->split = s.at;
    for (uint32_t above = 0; above < 2; above++) {
        struct part child = {p->end, p->end, p->box, children + above, p->depth + 1};
        *(above ? &child.box.lo[s.axis] : &child.box.hi[s.axis]) = s.at;
        for (size_t i = p->begin; i < p->end; i++) {
            const struct accel_box box = b->boxes[b->waiting.at[i]];
            if (above ? is_above(box.hi[s.axis], s.at)
                      : is_below(box.lo[s.axis], box.hi[s.axis], s.at))
                build_push(&b->waiting, b->waiting.at[i]);
        }
        child.end = b->waiting.count;
        if (!build_part(b, &child, err))
            return false;
        b->waiting.count = p->end;
    }
    return true;
}

bool kdtree_build(struct kdtree *t, struct accel_mesh mesh, const struct accel_limits *limits,
                  struct err *err)
{
    *t = (struct kdtree){.mesh = mesh, .bounds = build_bounds(mesh)};
    struct builder b = {t, limits, build_boxes(mesh), {0}, 8};
    if (mesh.count >
        1) /* as in Physically Based Rendering, 3rd ed., section 4.4; below MAX_DEPTH */
        b.depth_max += (uint32_t)(1.3 * log2(mesh.count));
    for (uint32_t i = 0; i < mesh.count; i++)
        build_push(&b.waiting, i);
    const bool done =
        build_part(&b, &(struct part){0, mesh.count, t->bounds, add_nodes(t, 1), 0}, err);
    free(b.waiting.at);
    free(b.boxes);
    if (!done)
        kdtree_release(t);
    return done;
}

bool kdtree_hit(const struct kdtree *t, const struct ray *ray, struct ray_hit *hit)
{
    struct query_visit stack[MAX_DEPTH + 1], *top = stack;
    struct query q;
    if (!query_enter(&q, t->mesh, &t->bounds, ray, top++))
        return false;
    while (top > stack) {
        struct query_visit v = *--top;
        if (v.begin > q.best.t) /* an equal hit in there may have a smaller number */
            continue;
        const struct kdtree_node *node = &t->nodes[v.node];
        for (; node->axis != LEAF; node = &t->nodes[v.node]) {
            const int k = (int)node->axis;
            const float early = query_earliest(&q, k, node->split);
            const float late = query_latest(&q, k, node->split);
            top = query_cut(&v, top, node->first, q.down[k], early, late);
        }
        query_triangles(&q, t->refs.at + node->first, node->count);
    }
    return query_done(&q, hit);
}

uint64_t kdtree_bytes(const struct kdtree *t)
{
    return t->node_count * sizeof *t->nodes + t->refs.count * sizeof *t->refs.at;
}

void kdtree_release(struct kdtree *t)
{
    free(t->nodes);
    free(t->refs.at);
}
