/* Binned surface area heuristic: I. Wald, "On fast Construction of SAH-based Bounding Volume
 * Hierarchies", RT 2007. SPDX-License-Identifier: MIT */
#include <assert.h>

#include "common/trace/bvh.h"

enum {
    BINS = 16,
    LEAF_MAX = 4,    /* primitives of a leaf: measured flat between 2 and 8 */
    KIND_LEVELS = 3, /* splitting four kinds apart takes at most three levels */
};

/* Visiting a node, in units of one primitive test. */
#define NODE_COST 1.0f

struct builder {
    const struct bvh_box *boxes;
    const unsigned char *kinds;
    struct bvh_tree tree;
};

struct range { /* of leaf_prims, half-open */
    uint32_t begin, end;
    uint32_t node, depth;
};

struct split {
    int axis; /* -1: none */
    float lo, scale;
    int bin; /* bins below it go left */
    float cost;
};

static struct bvh_box empty_box(void)
{
    const float inf = __builtin_inff();
    return (struct bvh_box){{inf, inf, inf}, {-inf, -inf, -inf}};
}

static void grow(struct bvh_box *b, const float lo[3], const float hi[3])
{
    for (int k = 0; k < 3; k++) {
        b->lo[k] = lo[k] < b->lo[k] ? lo[k] : b->lo[k];
        b->hi[k] = hi[k] > b->hi[k] ? hi[k] : b->hi[k];
    }
}

static float half_area(const struct bvh_box *b)
{
    const float x = b->hi[0] - b->lo[0], y = b->hi[1] - b->lo[1], z = b->hi[2] - b->lo[2];
    return x < 0 ? 0 : x * y + y * z + z * x;
}

/* Halves first: lo + hi of two large coordinates could overflow. */
static float center(const struct bvh_box *b, int axis)
{
    return 0.5f * b->lo[axis] + 0.5f * b->hi[axis];
}

static int bin_of(const struct builder *b, uint32_t prim, int axis, float lo, float scale)
{
    const int bin = (int)((center(&b->boxes[prim], axis) - lo) * scale);
    return bin < 0 ? 0 : bin > BINS - 1 ? BINS - 1 : bin;
}

static void try_axis(const struct builder *b, struct range r, int axis, const struct bvh_box *centers,
                     float area, struct split *best)
{
    const float lo = centers->lo[axis], width = centers->hi[axis] - lo;
    const float scale = (float)BINS / width;
    if (!(width > 0) || !(scale < __builtin_inff()))
        return;
    struct bvh_box box[BINS];
    uint32_t count[BINS] = {0};
    for (int i = 0; i < BINS; i++)
        box[i] = empty_box();
    for (uint32_t i = r.begin; i < r.end; i++) {
        const uint32_t prim = b->tree.leaf_prims[i];
        const int bin = bin_of(b, prim, axis, lo, scale);
        count[bin]++;
        grow(&box[bin], b->boxes[prim].lo, b->boxes[prim].hi);
    }
    float right_cost[BINS];
    struct bvh_box side = empty_box();
    uint32_t n = 0;
    for (int i = BINS - 1; i > 0; i--) {
        grow(&side, box[i].lo, box[i].hi);
        n += count[i];
        right_cost[i] = n ? half_area(&side) * (float)n : -1;
    }
    side = empty_box();
    n = 0;
    for (int i = 1; i < BINS; i++) {
        grow(&side, box[i - 1].lo, box[i - 1].hi);
        n += count[i - 1];
        const float cost = NODE_COST + (half_area(&side) * (float)n + right_cost[i]) / area;
        if (n && right_cost[i] >= 0 && cost < best->cost)
            *best = (struct split){axis, lo, scale, i, cost};
    }
}

static bool goes_left(const struct builder *b, const struct split *s, uint32_t prim)
{
    return bin_of(b, prim, s->axis, s->lo, s->scale) < s->bin;
}

static uint32_t partition(struct builder *b, struct range r, const struct split *s)
{
    uint32_t *prims = b->tree.leaf_prims;
    uint32_t i = r.begin, j = r.end;
    while (i < j) {
        if (goes_left(b, s, prims[i])) {
            i++;
        } else {
            const uint32_t prim = prims[--j];
            prims[j] = prims[i];
            prims[i] = prim;
        }
    }
    return i;
}

/* A leaf holds one kind: the first one's are moved to the front; where they end. */
static uint32_t partition_by_kind(struct builder *b, struct range r)
{
    uint32_t *prims = b->tree.leaf_prims;
    const unsigned char kind = b->kinds[prims[r.begin]];
    uint32_t middle = r.begin;
    for (uint32_t i = r.begin; i < r.end; i++)
        if (b->kinds[prims[i]] == kind) {
            const uint32_t prim = prims[i];
            prims[i] = prims[middle];
            prims[middle++] = prim;
        }
    return middle;
}

static uint32_t ceil_log2(uint32_t n)
{
    return n <= 1 ? 0 : 32 - (uint32_t)__builtin_clz(n - 1);
}

/* Where to cut the range, or r.end for a leaf. Sets the node's bounds. */
static uint32_t choose(struct builder *b, struct range r)
{
    struct bvh_node *node = &b->tree.nodes[r.node];
    struct bvh_box bounds = empty_box(), centers = empty_box();
    for (uint32_t i = r.begin; i < r.end; i++) {
        const struct bvh_box *box = &b->boxes[b->tree.leaf_prims[i]];
        const float c[3] = {center(box, 0), center(box, 1), center(box, 2)};
        grow(&bounds, box->lo, box->hi);
        grow(&centers, c, c);
    }
    for (int k = 0; k < 3; k++) {
        node->lo[k] = bounds.lo[k];
        node->hi[k] = bounds.hi[k];
    }
    const uint32_t count = r.end - r.begin;
    struct split best = {-1, 0, 0, 0, __builtin_inff()};
    /* Halving from here on just reaches leaves before BVH_MAX_DEPTH. */
    const bool halve = r.depth + ceil_log2(count) + KIND_LEVELS + 1 >= BVH_MAX_DEPTH;
    if (count > 1 && !halve)
        for (int axis = 0; axis < 3; axis++)
            try_axis(b, r, axis, &centers, half_area(&bounds), &best);
    if (count <= LEAF_MAX && !(best.cost < (float)count))
        return partition_by_kind(b, r);
    return best.axis < 0 ? r.begin + count / 2 : partition(b, r, &best);
}

struct bvh_tree bvh_build(const struct bvh_box *boxes, const unsigned char *kinds, uint32_t count,
                          struct arena *arena)
{
    struct builder b = {.boxes = boxes, .kinds = kinds};
    if (!count)
        return b.tree;
    b.tree.nodes = arena_new(arena, struct bvh_node, 2 * (size_t)count);
    b.tree.leaf_prims = arena_new(arena, uint32_t, count);
    for (uint32_t i = 0; i < count; i++)
        b.tree.leaf_prims[i] = i;
    b.tree.node_count = 1;

    struct range stack[BVH_MAX_DEPTH + 1];
    int waiting = 0;
    stack[waiting++] = (struct range){0, count, 0, 1};
    while (waiting) {
        const struct range r = stack[--waiting];
        assert(r.depth <= BVH_MAX_DEPTH);
        b.tree.depth = r.depth > b.tree.depth ? r.depth : b.tree.depth;
        const uint32_t middle = choose(&b, r);
        struct bvh_node *node = &b.tree.nodes[r.node];
        if (middle == r.end) {
            node->first = r.begin;
            node->count = (r.end - r.begin) & 0x1fffffff;
            node->kind = kinds[b.tree.leaf_prims[r.begin]] & 7u;
            continue;
        }
        const uint32_t child = b.tree.node_count;
        b.tree.node_count += 2;
        node->first = child;
        node->count = 0;
        stack[waiting++] = (struct range){middle, r.end, child + 1, r.depth + 1};
        stack[waiting++] = (struct range){r.begin, middle, child, r.depth + 1};
    }
    return b.tree;
}
