/* BSP tree: H. Fuchs, Z. Kedem, B. Naylor, "On Visible Surface Generation by A Priori Tree
 * Structures", SIGGRAPH 1980. Planes of any direction; bsp_choose.h says which. A triangle across
 * one goes whole to both sides.
 *
 * That every hit is found (query.h) takes one thing more here than in the other trees: cells are
 * cut by triangles, not by their boxes, so the point at t must be near the triangle. It is, but for
 * rays within a rounding of its plane; no test has met one that made a difference.
 * SPDX-License-Identifier: MIT */
#include <stdlib.h>

#include "bench/accel/bsp_choose.h"
#include "bench/accel/build.h"
#include "bench/accel/query.h"

enum { MAX_DEPTH = 64 };

#define INNER UINT32_MAX /* in place of a leaf's count */

struct builder {
    struct bsp *tree;
    const struct accel_limits *limits;
    struct accel_list waiting; /* triangles of the nodes from the root to the one at hand */
    struct bsp_chooser chooser;
};

struct part { /* what becomes of a node: its triangles are waiting[begin, end) */
    size_t begin, end, lines_begin, lines_end;
    uint32_t node, depth;
};

static uint32_t add_nodes(struct bsp *t, uint32_t count)
{
    t->nodes = build_grow(t->nodes, &t->node_room, t->node_count + count, sizeof *t->nodes);
    t->node_count += count;
    return (uint32_t)t->node_count - count;
}

static bool build_part(struct builder *b, const struct part *p, struct err *err)
{
    struct bsp *t = b->tree;
    const uint32_t *prims = p->end > p->begin ? &b->waiting.at[p->begin] : NULL;
    const struct bsp_cell cell = {prims, p->end - p->begin, p->lines_begin, p->lines_end};
    struct bsp_plane plane = {{0}, 0};
    const uint64_t waiting =
        b->waiting.count * sizeof *b->waiting.at + b->chooser.line_count * sizeof *b->chooser.lines;
    if (!build_within(b->limits, bsp_bytes(t) + waiting, cell.count, err))
        return false;
    if (p->depth == MAX_DEPTH || !bsp_choose(&b->chooser, &cell, &plane)) {
        t->nodes[p->node].count = (uint32_t)cell.count;
        t->nodes[p->node].first = build_push_all(&t->refs, &b->waiting, p->begin, p->end);
        return true;
    }
    const uint32_t children = add_nodes(t, 2);
    t->nodes[p->node] = (struct bsp_node){
        {plane.normal[0], plane.normal[1], plane.normal[2]}, plane.offset, children, INNER};
    for (uint32_t before = 0; before < 2; before++) {
        struct part child = {p->end, 0, p->lines_end, 0, children + before, p->depth + 1};
        for (size_t i = p->begin; i < p->end; i++) {
            const struct bsp_sides s = bsp_sides_of(&b->chooser, b->waiting.at[i], &plane);
            if (before ? s.before : s.behind)
                build_push(&b->waiting, b->waiting.at[i]);
        }
        bsp_cut_lines(&b->chooser, &cell, &plane, before);
        child.end = b->waiting.count;
        child.lines_end = b->chooser.line_count;
        if (!build_part(b, &child, err))
            return false;
        b->waiting.count = p->end;
        b->chooser.line_count = p->lines_end;
    }
    return true;
}

bool bsp_build(struct bsp *t, struct accel_mesh mesh, const struct accel_limits *limits,
               struct err *err)
{
    *t = (struct bsp){.mesh = mesh, .bounds = build_bounds(mesh)};
    struct builder b = {.tree = t, .limits = limits};
    for (uint32_t i = 0; i < mesh.count; i++)
        build_push(&b.waiting, i);
    bsp_chooser_init(&b.chooser, t);
    const struct part root = {0, mesh.count, 0, b.chooser.line_count, add_nodes(t, 1), 0};
    const bool done = build_part(&b, &root, err);
    free(b.waiting.at);
    bsp_chooser_release(&b.chooser);
    if (!done)
        bsp_release(t);
    return done;
}

/* Where the ray crosses the node's plane, at the earliest and at the latest; true when it runs
 * down. One in the plane has no sign, so that both are infinite, as the side says that the origin
 * is on. The slack adds up over three axes here, and a triangle may lie `touching` beyond its
 * plane. */
static bool crosses(const struct bsp_node *n, const struct query *q, float *early, float *late)
{
    float h = -n->offset, speed = 0;
    for (int k = 0; k < 3; k++) {
        h += n->normal[k] * q->box.origin[k];
        speed += n->normal[k] * q->tri.ray->dir[k];
    }
    const bool down = speed < 0;
    const float slack = down ? -3 * q->slack : 3 * q->slack, inv = 1 / (speed == 0 ? 0 : speed);
    *early = (-h - slack) * inv;
    *late = (-h + slack) * inv;
    return down;
}

bool bsp_hit(const struct bsp *t, const struct ray *ray, struct ray_hit *hit)
{
    struct query_visit stack[MAX_DEPTH + 1], *top = stack;
    struct query q;
    if (!query_enter(&q, t->mesh, &t->bounds, ray, top++))
        return false;
    while (top > stack) {
        struct query_visit v = *--top;
        if (v.begin > q.best.t) /* an equal hit in there may have a smaller number */
            continue;
        const struct bsp_node *node = &t->nodes[v.node];
        for (; node->count == INNER; node = &t->nodes[v.node]) {
            float early, late;
            const bool down = crosses(node, &q, &early, &late);
            top = query_cut(&v, top, node->first, down, early, late);
        }
        query_triangles(&q, t->refs.at + node->first, node->count);
    }
    return query_done(&q, hit);
}

uint64_t bsp_bytes(const struct bsp *t)
{
    return t->node_count * sizeof *t->nodes + t->refs.count * sizeof *t->refs.at;
}

void bsp_release(struct bsp *t)
{
    free(t->nodes);
    free(t->refs.at);
}
