/* SPDX-License-Identifier: MIT */
#include "common/trace/bvh_binary.h"

#include <assert.h>
#include <string.h>

struct pending {
    struct bvh_range range;
    uint32_t first; /* of a second child: the first one, the next node after its parent; else 0 */
    uint32_t depth;
};

static uint32_t ceil_log2(uint32_t n)
{
    return n <= 1 ? 0 : 32 - (uint32_t)__builtin_clz(n - 1);
}

bool bvh_binary_is_leaf(const struct bvh_range *r)
{
    const uint32_t count = r->end - r->begin;
    return count == 1 || (r->weight == count && count <= BVH_LEAF_WEIGHT);
}

/* How many times larger than expected a part's surface may be, cubed. */
#define PART_EXCESS 8.0f

static bool is_part(const struct bvh_binary_limits *l, const struct bvh_range *whole,
                    const struct bvh_range *r)
{
    const uint32_t count = r->end - r->begin;
    if (count < l->part_least || count > l->part_most)
        return false;
    const float items = (float)count / (float)(whole->end - whole->begin);
    const float area = bvh_half_area(&r->box) / bvh_half_area(&whole->box);
    return !(area * area * area > PART_EXCESS * items * items);
}

static uint32_t new_node(struct bvh_binary *b)
{
    if (b->count % BVH_BINARY_CHUNK == 0) {
        const uint32_t chunk = b->count / BVH_BINARY_CHUNK;
        if (chunk == b->room) {
            struct bvh_binary_node **more =
                arena_new(b->arena, struct bvh_binary_node *, b->room ? 2 * (size_t)b->room : 64);
            if (b->room)
                memcpy(more, b->chunks, b->room * sizeof *more);
            b->room = b->room ? 2 * b->room : 64;
            b->chunks = more;
        }
        b->chunks[chunk] =
            arena_alloc(b->arena, BVH_BINARY_CHUNK, sizeof(struct bvh_binary_node), 64);
    }
    return b->count++;
}

/* --- the choice --- */

/* The best way to have exactly i children, for all i > 1. */
static void distribute(struct bvh_binary_node *n, const struct bvh_binary_node *left,
                       const struct bvh_binary_node *right, float cost[BVH_WIDTH])
{
    for (int i = 2; i <= BVH_WIDTH; i++) {
        cost[i - 1] = __builtin_inff();
        n->left[i - 1] = 1;
        for (int k = 1; k < i; k++) {
            const float sum = left->cost[k - 1] + right->cost[i - k - 1];
            if (sum < cost[i - 1]) {
                cost[i - 1] = sum;
                n->left[i - 1] = (unsigned char)k;
            }
        }
    }
}

static void choose(const struct bvh_binary *b, uint32_t i)
{
    struct bvh_binary_node *n = bvh_binary_at(b, i);
    const float area = bvh_half_area(&n->box);
    float cost[BVH_WIDTH];
    if (!n->second) {
        for (int k = 0; k < BVH_WIDTH; k++) {
            n->cost[k] = area;
            n->shape[k] = 1;
        }
        return;
    }
    distribute(n, bvh_binary_at(b, i + 1), bvh_binary_at(b, n->second), cost);
    n->cost[0] = area + cost[BVH_WIDTH - 1];
    n->shape[0] = 1;
    for (int k = 1; k < BVH_WIDTH; k++) {
        const bool more = cost[k] < n->cost[k - 1];
        n->cost[k] = more ? cost[k] : n->cost[k - 1];
        n->shape[k] = more ? (unsigned char)(k + 1) : n->shape[k - 1];
    }
}

/* The children of a wide node that node n's items make, `count` of them or fewer; how many. */
static uint32_t collect(const struct bvh_binary *b, uint32_t n, uint32_t count,
                        uint32_t child[BVH_WIDTH])
{
    const struct bvh_binary_node *node = bvh_binary_at(b, n);
    const uint32_t shape = node->shape[count - 1];
    if (shape == 1) {
        child[0] = n;
        return 1;
    }
    const uint32_t left = node->left[shape - 1];
    const uint32_t first = collect(b, n + 1, left, child);
    return first + collect(b, node->second, shape - left, child + first);
}

uint32_t bvh_binary_children(const struct bvh_binary *b, uint32_t n, uint32_t child[BVH_WIDTH])
{
    const struct bvh_binary_node *node = bvh_binary_at(b, n);
    const uint32_t left = node->left[BVH_WIDTH - 1];
    const uint32_t first = collect(b, n + 1, left, child);
    return first + collect(b, node->second, BVH_WIDTH - left, child + first);
}

/* --- the tree --- */

/* Children come after their parent, so the costs are known from the end. */
struct bvh_binary bvh_binary_make(struct bvh_item *items, const struct bvh_range *range,
                                  const struct bvh_binary_limits *limits, struct arena *arena)
{
    struct bvh_binary b = {.arena = arena};
    struct pending stack[BVH_MAX_DEPTH + 2];
    uint32_t waiting = 0;
    stack[waiting++] = (struct pending){*range, 0, limits->depth};
    while (waiting) {
        const struct pending p = stack[--waiting];
        const uint32_t i = new_node(&b);
        struct bvh_binary_node *n = bvh_binary_at(&b, i);
        n->box = p.range.box;
        n->begin = p.range.begin;
        n->end = p.range.end;
        n->weight = p.range.weight;
        if (p.first)
            bvh_binary_at(&b, p.first - 1)->second = i;
        if (bvh_binary_is_leaf(&p.range) || (i && is_part(limits, range, &p.range)))
            continue;
        assert(p.depth <= BVH_MAX_DEPTH);
        const bool by_count = p.depth + ceil_log2(p.range.end - p.range.begin) >= BVH_MAX_DEPTH;
        struct bvh_range half[2];
        bvh_split(items, &p.range, by_count, half);
        stack[waiting++] = (struct pending){half[1], i + 1, p.depth + 1};
        stack[waiting++] = (struct pending){half[0], 0, p.depth + 1};
    }
    for (uint32_t i = b.count; i-- > 0;)
        choose(&b, i);
    return b;
}
