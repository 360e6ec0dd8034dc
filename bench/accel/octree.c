/* Octree: A. Glassner, "Space Subdivision for Fast Ray Tracing", IEEE Computer Graphics and
 * Applications 4(10), 1984. The tree is his; the ray goes down from the root and takes the children
 * it meets in order, where he looks up the cell of a point just beyond the last one.
 * SPDX-License-Identifier: MIT */
#include <stdlib.h>

#include "bench/accel/build.h"
#include "bench/accel/query.h"

enum { LEAF_MAX = 8, MAX_DEPTH = 20, GROWTH_MAX = 3 };

#define INNER UINT32_MAX /* in place of a leaf's count */

struct builder {
    struct octree *tree;
    const struct accel_limits *limits;
    struct accel_box *boxes;
    struct accel_list waiting; /* triangles of the nodes from the root to the one at hand */
};

struct part { /* what becomes of a node: its triangles are waiting[begin, end) */
    size_t begin, end;
    float lo[3], side;
    uint32_t node, depth;
};

static uint32_t add_nodes(struct octree *t, uint32_t count)
{
    t->nodes = build_grow(t->nodes, &t->node_room, t->node_count + count, sizeof *t->nodes);
    t->node_count += count;
    return (uint32_t)t->node_count - count;
}

/* Bit c: the triangle's box reaches into child c. */
static uint32_t children_of(const struct builder *b, uint32_t prim, const float center[3])
{
    static const unsigned char upper[3] = {0xaa, 0xcc, 0xf0}; /* children with bit k set */
    const struct accel_box box = b->boxes[prim];
    uint32_t children = 0xff;
    for (int k = 0; k < 3; k++) {
        if (!(box.hi[k] > center[k]))
            children &= ~(uint32_t)upper[k];
        else if (!(box.lo[k] < center[k]))
            children &= upper[k];
    }
    return children;
}

/* Cutting must not cost more than it gives: triangles that cross all the middle planes, many about
 * one vertex or on top of each other, would go on for ever. */
static bool pays(const struct builder *b, const struct part *p, const float center[3])
{
    const size_t count = p->end - p->begin;
    size_t sum = 0;
    if (count <= LEAF_MAX || p->depth == MAX_DEPTH)
        return false;
    for (size_t i = p->begin; i < p->end; i++)
        sum += (size_t)__builtin_popcount(children_of(b, b->waiting.at[i], center));
    return sum < GROWTH_MAX * count;
}

static bool build_part(struct builder *b, const struct part *p, struct err *err)
{
    if (!build_within(b->limits, octree_bytes(b->tree) + b->waiting.count * sizeof(uint32_t),
                      p->end - p->begin, err))
        return false;
    const float half = p->side / 2;
    const float center[3] = {p->lo[0] + half, p->lo[1] + half, p->lo[2] + half};
    if (!pays(b, p, center)) {
        const uint32_t first = build_push_all(&b->tree->refs, &b->waiting, p->begin, p->end);
        b->tree->nodes[p->node] = (struct octree_node){first, (uint32_t)(p->end - p->begin)};
        return true;
    }
    const uint32_t children = add_nodes(b->tree, 8);
    b->tree->nodes[p->node] = (struct octree_node){children, INNER};
    for (uint32_t c = 0; c < 8; c++) {
        struct part child = {p->end, 0, {0}, half, children + c, p->depth + 1};
        for (int k = 0; k < 3; k++)
            child.lo[k] = c >> k & 1 ? center[k] : p->lo[k];
        for (size_t i = p->begin; i < p->end; i++)
            if (children_of(b, b->waiting.at[i], center) >> c & 1)
                build_push(&b->waiting, b->waiting.at[i]);
        child.end = b->waiting.count;
        if (!build_part(b, &child, err))
            return false;
        b->waiting.count = p->end;
    }
    return true;
}

bool octree_build(struct octree *t, struct accel_mesh mesh, const struct accel_limits *limits,
                  struct err *err)
{
    *t = (struct octree){.mesh = mesh, .bounds = build_bounds(mesh)};
    for (int k = 0; k < 3; k++) {
        const float length = t->bounds.hi[k] - t->bounds.lo[k];
        t->lo[k] = t->bounds.lo[k];
        t->side = length > t->side ? length : t->side;
    }
    struct builder b = {t, limits, build_boxes(mesh), {0}};
    for (uint32_t i = 0; i < mesh.count; i++)
        build_push(&b.waiting, i);
    struct part root = {0, mesh.count, {t->lo[0], t->lo[1], t->lo[2]}, t->side, add_nodes(t, 1), 0};
    const bool done = build_part(&b, &root, err);
    free(b.waiting.at);
    free(b.boxes);
    if (!done)
        octree_release(t);
    return done;
}

struct visit { /* of a node, while the ray is in it */
    float lo[3], side;
    float begin, end;
    uint32_t node;
};

/* Puts the children that the ray meets on the stack, the first one on top. Child c is `order` c
 * with the bits turned of the axes along which the ray runs down. */
static int push_children(const struct query *q, const struct octree *t, const struct visit *v,
                         struct visit *stack)
{
    const float half = v->side / 2;
    float early[3], late[3];
    uint32_t turn = 0;
    int count = 0;
    for (int k = 0; k < 3; k++) {
        early[k] = query_earliest(q, k, v->lo[k] + half);
        late[k] = query_latest(q, k, v->lo[k] + half);
        turn |= (uint32_t)q->down[k] << k;
    }
    for (uint32_t order = 8; order-- > 0;) {
        struct visit c = {{0}, half, v->begin, v->end, t->nodes[v->node].first + (order ^ turn)};
        for (int k = 0; k < 3; k++) {
            c.lo[k] = v->lo[k] + ((order ^ turn) >> k & 1 ? half : 0);
            if (order >> k & 1)
                c.begin = early[k] > c.begin ? early[k] : c.begin;
            else
                c.end = late[k] < c.end ? late[k] : c.end;
        }
        if (c.begin <= c.end && t->nodes[c.node].count)
            stack[count++] = c;
    }
    return count;
}

bool octree_hit(const struct octree *t, const struct ray *ray, struct ray_hit *hit)
{
    struct visit stack[7 * MAX_DEPTH + 8];
    struct query q;
    float in[2];
    if (!query_make(&q, t->mesh, &t->bounds, ray) || !query_box(&q, t->bounds.lo, t->bounds.hi, in))
        return false;
    int depth = 0;
    stack[depth++] = (struct visit){{t->lo[0], t->lo[1], t->lo[2]}, t->side, in[0], in[1], 0};
    while (depth) {
        const struct visit v = stack[--depth];
        const struct octree_node *node = &t->nodes[v.node];
        if (v.begin > q.best.t) /* an equal hit in there may have a smaller number */
            continue;
        if (node->count == INNER)
            depth += push_children(&q, t, &v, stack + depth);
        else
            query_triangles(&q, t->refs.at + node->first, node->count);
    }
    return query_done(&q, hit);
}

uint64_t octree_bytes(const struct octree *t)
{
    return t->node_count * sizeof *t->nodes + t->refs.count * sizeof *t->refs.at;
}

void octree_release(struct octree *t)
{
    free(t->nodes);
    free(t->refs.at);
}
