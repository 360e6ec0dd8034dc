/* Binned surface area heuristic: I. Wald, "On fast Construction of SAH-based Bounding Volume
 * Hierarchies", RT 2007. SPDX-License-Identifier: MIT */
#include <assert.h>

#include "common/trace/bvh.h"

enum {
    BINS = 16,
    LEAF_MAX = 4,    /* primitives of a leaf */
    KIND_LEVELS = 2, /* splitting three kinds apart takes at most two levels */
};

/* Visiting a node, in units of one primitive test. */
#define NODE_COST 1.0f

/* A corner and, where lane 3 would be, something else. */
union corner {
    vec3 at;
    struct {
        float xyz[3];
        uint32_t tag;
    };
};

struct ref { /* a primitive on its way into a leaf; moved about whole, so that memory is read in order */
    union corner lo, hi; /* tags: prim, kind */
};

struct box {
    vec3 lo, hi;
};

struct range { /* of refs, half-open */
    uint32_t begin, end;
    uint32_t node, depth;
};

struct split {
    int axis; /* -1: none */
    int bin;  /* bins below it go left */
    float cost;
    vec3 lo, scale; /* from a centre to its bin, per axis */
};

/* Written so that the compiler sees minps and maxps. */
static inline vec3 lower(vec3 a, vec3 b)
{
    for (int k = 0; k < 4; k++)
        a[k] = b[k] < a[k] ? b[k] : a[k];
    return a;
}

static inline vec3 upper(vec3 a, vec3 b)
{
    for (int k = 0; k < 4; k++)
        a[k] = b[k] > a[k] ? b[k] : a[k];
    return a;
}

static inline struct box box_empty(void)
{
    const float inf = __builtin_inff();
    return (struct box){{inf, inf, inf, inf}, {-inf, -inf, -inf, -inf}};
}

static inline struct box box_join(struct box a, struct box b)
{
    return (struct box){lower(a.lo, b.lo), upper(a.hi, b.hi)};
}

static inline float half_area(struct box b)
{
    const vec3 d = b.hi - b.lo;
    return d[0] < 0 ? 0 : d[0] * d[1] + d[1] * d[2] + d[2] * d[0];
}

typedef int32_t int4 __attribute__((vector_size(16)));

/* Halves first: the sum of two large coordinates could overflow. Without the tags: as floats they are
 * subnormal, which some processors multiply very slowly. */
static inline vec3 center(const struct ref *r)
{
    const int4 xyz = {-1, -1, -1, 0};
    return 0.5f * (vec3)((int4)r->lo.at & xyz) + 0.5f * (vec3)((int4)r->hi.at & xyz);
}

static inline int clamp_bin(int bin)
{
    return bin < 0 ? 0 : bin > BINS - 1 ? BINS - 1 : bin;
}

struct bins {
    struct box box[3][BINS];
    uint32_t count[3][BINS];
};

static void bins_fill(struct bins *b, const struct ref *refs, struct range r, const struct split *map)
{
    for (int axis = 0; axis < 3; axis++)
        for (int i = 0; i < BINS; i++) {
            b->box[axis][i] = box_empty();
            b->count[axis][i] = 0;
        }
    for (uint32_t i = r.begin; i < r.end; i++) {
        const struct box box = {refs[i].lo.at, refs[i].hi.at};
        const int4 bin = __builtin_convertvector((center(&refs[i]) - map->lo) * map->scale, int4);
        for (int axis = 0; axis < 3; axis++) {
            const int at = clamp_bin(bin[axis]);
            b->box[axis][at] = box_join(b->box[axis][at], box);
            b->count[axis][at]++;
        }
    }
}

static void bins_sweep(const struct bins *b, int axis, float area, struct split *best)
{
    float right_cost[BINS];
    struct box side = box_empty();
    uint32_t n = 0;
    for (int i = BINS - 1; i > 0; i--) {
        side = box_join(side, b->box[axis][i]);
        n += b->count[axis][i];
        right_cost[i] = n ? half_area(side) * (float)n : -1;
    }
    side = box_empty();
    n = 0;
    for (int i = 1; i < BINS; i++) {
        side = box_join(side, b->box[axis][i - 1]);
        n += b->count[axis][i - 1];
        const float cost = NODE_COST + (half_area(side) * (float)n + right_cost[i]) / area;
        if (n && right_cost[i] >= 0 && cost < best->cost) {
            best->axis = axis;
            best->bin = i;
            best->cost = cost;
        }
    }
}

/* The cheapest of the BINS - 1 planes per axis; axis -1 when all centres agree or areas overflow. */
static struct split split_find(const struct ref *refs, struct range r, struct box bounds,
                               struct box centers)
{
    struct split best = {.axis = -1, .cost = __builtin_inff(), .lo = centers.lo};
    const vec3 width = centers.hi - centers.lo;
    bool usable[3];
    for (int k = 0; k < 3; k++) {
        const float scale = (float)BINS / width[k];
        usable[k] = width[k] > 0 && scale < __builtin_inff();
        best.scale[k] = usable[k] ? scale : 0;
    }
    struct bins bins;
    bins_fill(&bins, refs, r, &best);
    for (int axis = 0; axis < 3; axis++)
        if (usable[axis])
            bins_sweep(&bins, axis, half_area(bounds), &best);
    return best;
}

static void swap_refs(struct ref *a, struct ref *b)
{
    const struct ref was = *a;
    *a = *b;
    *b = was;
}

/* Returns where the right part begins. */
static uint32_t partition(struct ref *refs, struct range r, const struct split *s)
{
    const int axis = s->axis;
    uint32_t i = r.begin, j = r.end;
    while (i < j) {
        const float at = (center(&refs[i])[axis] - s->lo[axis]) * s->scale[axis];
        if (clamp_bin((int)at) < s->bin)
            i++;
        else
            swap_refs(&refs[i], &refs[--j]);
    }
    return i;
}

/* A leaf holds one kind: the first one's are moved to the front; where they end. */
static uint32_t partition_by_kind(struct ref *refs, struct range r)
{
    const uint32_t kind = refs[r.begin].hi.tag;
    uint32_t middle = r.begin;
    for (uint32_t i = r.begin; i < r.end; i++)
        if (refs[i].hi.tag == kind)
            swap_refs(&refs[i], &refs[middle++]);
    return middle;
}

static uint32_t ceil_log2(uint32_t n)
{
    return n <= 1 ? 0 : 32 - (uint32_t)__builtin_clz(n - 1);
}

/* Where to cut the range, or r.end for a leaf. Sets the node's bounds. */
static uint32_t choose(struct bvh_node *node, struct ref *refs, struct range r)
{
    struct box bounds = box_empty(), centers = box_empty();
    for (uint32_t i = r.begin; i < r.end; i++) {
        const vec3 c = center(&refs[i]);
        bounds = box_join(bounds, (struct box){refs[i].lo.at, refs[i].hi.at});
        centers = box_join(centers, (struct box){c, c});
    }
    vec3_store(node->plane[0], bounds.lo);
    vec3_store(node->plane[1], bounds.hi);
    const uint32_t count = r.end - r.begin;
    if (count == 1)
        return r.end;
    struct split best = {.axis = -1, .cost = __builtin_inff()};
    /* Halving from here on just reaches leaves before BVH_MAX_DEPTH. */
    if (r.depth + ceil_log2(count) + KIND_LEVELS + 1 < BVH_MAX_DEPTH)
        best = split_find(refs, r, bounds, centers);
    if (count <= LEAF_MAX && !(best.cost < (float)count))
        return partition_by_kind(refs, r);
    return best.axis < 0 ? r.begin + count / 2 : partition(refs, r, &best);
}

static void build(struct bvh_tree *tree, struct ref *refs, uint32_t count)
{
    struct range stack[BVH_MAX_DEPTH + 1];
    uint32_t waiting = 0;
    stack[waiting++] = (struct range){0, count, 0, 1};
    tree->node_count = 2;
    while (waiting) {
        const struct range r = stack[--waiting];
        assert(r.depth <= BVH_MAX_DEPTH);
        tree->depth = max_u32(tree->depth, r.depth);
        struct bvh_node *node = &tree->nodes[r.node];
        const uint32_t middle = choose(node, refs, r);
        if (middle == r.end) {
            node->first = r.begin;
            node->count = (r.end - r.begin) & 0x1fffffff;
            node->kind = refs[r.begin].hi.tag & 7u;
            continue;
        }
        const uint32_t child = tree->node_count;
        tree->node_count += 2;
        node->first = child;
        stack[waiting++] = (struct range){middle, r.end, child + 1, r.depth + 1};
        stack[waiting++] = (struct range){r.begin, middle, child, r.depth + 1};
    }
}

struct bvh_tree bvh_build(const struct bvh_box *boxes, const unsigned char *kinds, uint32_t count,
                          struct arena *arena)
{
    struct bvh_tree tree = {0};
    if (!count)
        return tree;
    tree.nodes = arena_alloc(arena, 2 * (size_t)count, sizeof *tree.nodes, 64);
    tree.leaf_prims = arena_new(arena, uint32_t, count);
    struct ref *refs = arena_new(arena, struct ref, count);
    for (uint32_t i = 0; i < count; i++) {
        refs[i].lo.at = vec3_load(boxes[i].lo);
        refs[i].hi.at = vec3_load(boxes[i].hi);
        refs[i].lo.tag = i;
        refs[i].hi.tag = kinds[i];
    }
    build(&tree, refs, count);
    for (uint32_t i = 0; i < count; i++)
        tree.leaf_prims[i] = refs[i].lo.tag;
    return tree;
}
