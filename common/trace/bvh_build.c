/* SPDX-License-Identifier: MIT */
#include "common/trace/bvh_build.h"

#include <assert.h>

#include "common/trace/bvh_binary.h"
#include "common/trace/box8.h"

enum {
    PARTS_WANTED = 128, /* more or less: enough for any crew to share */
    PART_LEAST = 2048,  /* items; fewer are not worth a part */
    PART_MOST = 8192,   /* items that one part may have in any case */
    REF_PART = 14,      /* a child that another part holds; index: which */
};

/* A leaf is split when its parts' surfaces are together less than so much of its own. */
#define LEAF_SPLIT_GAIN 0.75f

struct pending {     /* a node to be made, and the child that will refer to it */
    uint32_t binary; /* in whose place */
    struct bvh_node *parent;
    uint32_t lane, depth;
};

static struct bvh_node *new_node(struct bvh_part *part)
{
    if (part->node_count % BVH_NODE_PIECE == 0)
        part->nodes[part->node_count / BVH_NODE_PIECE] =
            arena_alloc(&part->arena, BVH_NODE_PIECE, sizeof(struct bvh_node), 64);
    return bvh_part_node(part, part->node_count++);
}

static struct bvh_leaf *new_leaf(struct bvh_part *part)
{
    if (part->leaf_count % BVH_LEAF_PIECE == 0)
        part->leaves[part->leaf_count / BVH_LEAF_PIECE] =
            arena_new(&part->arena, struct bvh_leaf, BVH_LEAF_PIECE);
    return bvh_part_leaf(part, part->leaf_count++);
}

/* nodes: as many as there may be, each with no child but leaves; a tree without any is a leaf. */
static void part_open(struct bvh_part *part, uint32_t nodes)
{
    const size_t leaves = (size_t)BVH_WIDTH * nodes + 1;
    part->nodes = arena_new(&part->arena, struct bvh_node *, nodes / BVH_NODE_PIECE + 1);
    part->leaves = arena_new(&part->arena, struct bvh_leaf *, leaves / BVH_LEAF_PIECE + 1);
}

static uint32_t leaf_ref(struct bvh_part *part, const struct bvh_item *items,
                         const struct bvh_range *r)
{
    if (items[r->begin].kind != BVH_BLOCK)
        return bvh_ref_make(items[r->begin].kind, items[r->begin].index);
    const uint32_t number = part->leaf_count;
    struct bvh_leaf *leaf = new_leaf(part);
    for (uint32_t lane = 0; lane < STAGE_LANES; lane++)
        leaf->triangle[lane] = lane < r->end - r->begin ? items[r->begin + lane].index : STAGE_NONE;
    return bvh_ref_make(BVH_BLOCK, number);
}

/* Where a node has room left, leaves of large surface are worth two children: walls in one leaf
 * have a box as large as the room, each its own have none to speak of. */
static uint32_t split_leaves(struct bvh_item *items, struct bvh_range children[BVH_WIDTH],
                             uint32_t count)
{
    for (uint32_t i = 0; i < count && count < BVH_WIDTH; i++)
        while (count < BVH_WIDTH && children[i].end - children[i].begin > 1) {
            struct bvh_range half[2];
            bvh_split(items, &children[i], false, half);
            if (!(bvh_half_area(&half[0].box) + bvh_half_area(&half[1].box) <
                  LEAF_SPLIT_GAIN * bvh_half_area(&children[i].box)))
                break;
            children[i] = half[0];
            children[count++] = half[1];
        }
    return count;
}

static uint32_t part_ref(struct bvh_plan *plan, const struct bvh_range *r, uint32_t depth)
{
    if (plan->part_count == plan->part_room) {
        struct bvh_part *more = arena_new(&plan->arena, struct bvh_part, 2 * plan->part_room);
        memcpy(more, plan->parts, plan->part_count * sizeof *more);
        plan->parts = more;
        plan->part_room *= 2;
    }
    plan->parts[plan->part_count] =
        (struct bvh_part){.begin = r->begin, .end = r->end, .depth = depth};
    return bvh_ref_make(REF_PART, plan->part_count++);
}

/* A range that needs no node below this one. */
static uint32_t child_ref(struct bvh_plan *plan, struct bvh_part *part, const struct bvh_range *r,
                          uint32_t depth)
{
    return bvh_binary_is_leaf(r) ? leaf_ref(part, plan->items, r) : part_ref(plan, r, depth);
}

/* The node's children that are nodes are added to the stack; how many. */
static uint32_t fill_node(struct bvh_plan *plan, struct bvh_part *part, const struct bvh_binary *b,
                          const struct pending *p, struct pending *stack)
{
    struct bvh_node *node = new_node(part);
    uint32_t from[BVH_WIDTH], nodes = 0;
    struct bvh_range ranges[BVH_WIDTH];
    uint32_t count = bvh_binary_children(b, p->binary, from);
    bool all_leaves = true;
    for (uint32_t i = 0; i < count; i++) {
        ranges[i] = bvh_binary_range(bvh_binary_at(b, from[i]));
        all_leaves &= bvh_binary_is_leaf(&ranges[i]);
    }
    if (all_leaves) /* else lanes and binary nodes would no longer go together */
        count = split_leaves(plan->items, ranges, count);
    node->used = (1u << count) - 1;
    for (uint32_t i = 0; i < count; i++) {
        box8_store(node->plane, i, bvh_box_lo(&ranges[i].box), bvh_box_hi(&ranges[i].box));
        if (!all_leaves && bvh_binary_at(b, from[i])->second)
            stack[nodes++] = (struct pending){from[i], node, i, p->depth + 1};
        else
            node->child[i] = child_ref(plan, part, &ranges[i], p->depth + 1);
    }
    return nodes;
}

/* Ranges of at most part_most items become parts of the plan; 0: none does. */
static void build(struct bvh_plan *plan, struct bvh_part *part, const struct bvh_range *range,
                  uint32_t part_most)
{
    const struct bvh_binary_limits limits = {part->depth, PART_LEAST, part_most};
    struct arena arena = {0};
    const struct bvh_binary b = bvh_binary_make(plan->items, range, &limits, &arena);
    struct pending stack[BVH_STACK];
    uint32_t waiting = 0;
    part_open(part, b.count / 2);
    stack[waiting++] = (struct pending){.depth = part->depth};
    while (waiting) {
        const struct pending p = stack[--waiting];
        assert(p.depth <= BVH_MAX_DEPTH);
        if (p.parent)
            p.parent->child[p.lane] = bvh_ref_make(BVH_NODE, part->node_count);
        part->depth = max_u32(part->depth, p.depth);
        waiting += fill_node(plan, part, &b, &p, stack + waiting);
    }
    arena_release(&arena);
}

static void build_part(void *arg, uint32_t i)
{
    struct bvh_plan *plan = arg;
    struct bvh_part *part = &plan->parts[i + 1];
    const struct bvh_range range = bvh_range_make(plan->items, part->begin, part->end);
    build(plan, part, &range, 0);
}

struct bvh_plan bvh_plan_make(struct bvh_item *items, uint32_t count, const struct crew *crew)
{
    struct bvh_plan plan = {.items = items, .root = bvh_ref_make(BVH_NOTHING, 0)};
    if (!count)
        return plan;
    plan.part_room = 2 * PARTS_WANTED;
    plan.parts = arena_new(&plan.arena, struct bvh_part, plan.part_room);
    plan.part_count = 1;
    struct bvh_part top = {.end = count, .depth = 1};
    const struct bvh_range all = bvh_range_make(items, 0, count);
    const uint32_t part_most = count > 2 * PART_MOST ? max_u32(count / PARTS_WANTED, PART_MOST) : 0;
    plan.box = all.box;
    if (bvh_binary_is_leaf(&all)) {
        part_open(&top, 0);
        plan.root = leaf_ref(&top, items, &all);
    } else {
        build(&plan, &top, &all, part_most);
        plan.root = bvh_ref_make(BVH_NODE, 0);
    }
    plan.parts[0] = top;
    crew_run(crew, build_part, &plan, plan.part_count - 1);
    plan.items = NULL;
    for (uint32_t i = 0; i < plan.part_count; i++) {
        struct bvh_part *part = &plan.parts[i];
        part->node_begin = plan.node_count;
        part->leaf_begin = plan.leaf_count;
        plan.node_count += part->node_count;
        plan.leaf_count += part->leaf_count;
        plan.depth = max_u32(plan.depth, part->depth);
    }
    return plan;
}

struct writing {
    const struct bvh_plan *plan;
    const struct bvh_site *site;
};

static uint32_t node_ref(const struct writing *w, uint32_t node)
{
    return bvh_ref_make(BVH_NODE, w->site->node_line + BVH_NODE_LINES * node);
}

static uint32_t final_ref(const struct writing *w, const struct bvh_part *part, uint32_t ref)
{
    const uint32_t index = bvh_ref_index(ref);
    switch (bvh_ref_kind(ref)) {
    case BVH_NODE:
        return node_ref(w, part->node_begin + index);
    case BVH_BLOCK:
        return bvh_ref_make(BVH_BLOCK,
                            w->site->block_line + BVH_BLOCK_LINES * (part->leaf_begin + index));
    case REF_PART:
        return node_ref(w, w->plan->parts[index].node_begin);
    default:
        return ref;
    }
}

static void write_part(void *arg, uint32_t i)
{
    const struct writing *w = arg;
    const struct bvh_part *part = &w->plan->parts[i];
    for (uint32_t n = 0; n < part->node_count; n++) {
        struct bvh_node *node = &w->site->nodes[part->node_begin + n];
        *node = *bvh_part_node(part, n);
        for (uint32_t k = 0; node->used >> k; k++)
            node->child[k] = final_ref(w, part, node->child[k]);
    }
}

uint32_t bvh_plan_write(const struct bvh_plan *plan, const struct bvh_site *site,
                        const struct crew *crew)
{
    struct writing w = {plan, site};
    crew_run(crew, write_part, &w, plan->part_count);
    return plan->part_count ? final_ref(&w, &plan->parts[0], plan->root) : plan->root;
}

struct filling {
    const struct bvh_plan *plan;
    const struct stage_triangle *triangles;
    const uint32_t *prims;
    struct stage_block *blocks;
};

static void fill_block(const struct filling *f, const struct bvh_leaf *leaf, struct stage_block *b)
{
    for (uint32_t lane = 0; lane < STAGE_LANES; lane++) {
        const bool used = leaf->triangle[lane] != STAGE_NONE;
        const uint32_t from = used ? leaf->triangle[lane] : 0;
        b->prim[lane] = used ? f->prims[from] : STAGE_NONE;
        for (int i = 0; i < 3; i++)
            for (int k = 0; k < 3; k++)
                b->v[i][k][lane] = used ? f->triangles[from].v[i][k] : __builtin_nanf("");
    }
}

/* Triangles lie as they were before they were sorted, here and there, each in one cache line or
 * two. */
static void await(const struct filling *f, const struct bvh_leaf *leaf)
{
    for (uint32_t lane = 0; lane < STAGE_LANES && leaf->triangle[lane] != STAGE_NONE; lane++) {
        const struct stage_triangle *t = &f->triangles[leaf->triangle[lane]];
        __builtin_prefetch(&t->v[0][0]);
        __builtin_prefetch(&t->v[2][2]);
    }
}

static void fill_part(void *arg, uint32_t i)
{
    enum { AHEAD = 4 };
    const struct filling *f = arg;
    const struct bvh_part *part = &f->plan->parts[i];
    for (uint32_t n = 0; n < part->leaf_count; n++) {
        if (n + AHEAD < part->leaf_count)
            await(f, bvh_part_leaf(part, n + AHEAD));
        fill_block(f, bvh_part_leaf(part, n), &f->blocks[part->leaf_begin + n]);
    }
}

void bvh_plan_fill(const struct bvh_plan *plan, const struct stage_triangle *triangles,
                   const uint32_t *prims, struct stage_block *blocks, const struct crew *crew)
{
    struct filling f = {plan, triangles, prims, blocks};
    crew_run(crew, fill_part, &f, plan->part_count);
}

void bvh_plan_release(struct bvh_plan *plan)
{
    for (uint32_t i = 0; i < plan->part_count; i++)
        arena_release(&plan->parts[i].arena);
    arena_release(&plan->arena);
}
