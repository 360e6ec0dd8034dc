/* SPDX-License-Identifier: MIT */
#include "common/trace/bvh_split.h"

#include "common/trace/simd.h"

enum {
    SORTED = 16, /* so many items or fewer are sorted */
    BINS = 32,   /* at most */
};

struct cut {
    int axis;    /* -1: none */
    uint32_t at; /* bins below, or sorted items before it, are the first part */
    float cost;
};

struct side { /* what one side of a cut holds */
    struct bvh_box box;
    uint32_t weight;
};

/* Lane 3 of an item's bounds is its index or kind: as floats, slow to compute with. */
static inline vec3 bounds_load(const float v[3])
{
    const i32x4 keep = {-1, -1, -1, 0};
    vec3 all;
    memcpy(&all, v, sizeof all);
    return (vec3)((i32x4)all & keep);
}

/* Halves first: lo + hi of two large coordinates could overflow. */
static inline vec3 middle_of(vec3 lo, vec3 hi)
{
    return lo * 0.5f + hi * 0.5f;
}

static struct bvh_box empty_box(void)
{
    const float inf = __builtin_inff();
    return (struct bvh_box){{inf, inf, inf, 0}, {-inf, -inf, -inf, 0}};
}

static inline void grow(struct bvh_box *b, vec3 lo, vec3 hi)
{
    b->lo = vec3_min(lo, b->lo);
    b->hi = vec3_max(hi, b->hi);
}

static struct bvh_range empty_range(uint32_t begin)
{
    return (struct bvh_range){begin, begin, 0, empty_box(), empty_box()};
}

static inline void take(struct bvh_range *r, const struct bvh_item *item)
{
    const vec3 lo = bounds_load(item->lo), hi = bounds_load(item->hi), m = middle_of(lo, hi);
    grow(&r->box, lo, hi);
    grow(&r->middles, m, m);
    r->weight += bvh_item_weight(item);
}

struct bvh_range bvh_range_make(const struct bvh_item *items, uint32_t begin, uint32_t end)
{
    struct bvh_range r = empty_range(begin);
    for (r.end = begin; r.end < end; r.end++)
        take(&r, &items[r.end]);
    return r;
}

static float cost_of(const struct side *s)
{
    const uint32_t leaves = (s->weight + BVH_LEAF_WEIGHT - 1) / BVH_LEAF_WEIGHT;
    return bvh_half_area(&s->box) * (float)leaves;
}

static inline void add_side(struct side *to, const struct side *s)
{
    grow(&to->box, s->box.lo, s->box.hi);
    to->weight += s->weight;
}

/* The cheapest cut between the sides, in their order; empty ones may be among them. */
static void try_cuts(const struct side *sides, uint32_t count, int axis, struct cut *best)
{
    float after[BINS];
    struct side rest = {empty_box(), 0};
    for (uint32_t i = count - 1; i > 0; i--) {
        add_side(&rest, &sides[i]);
        after[i] = rest.weight ? cost_of(&rest) : -1;
    }
    rest = (struct side){empty_box(), 0};
    for (uint32_t i = 1; i < count; i++) {
        add_side(&rest, &sides[i - 1]);
        if (!rest.weight || after[i] < 0)
            continue;
        const float cost = cost_of(&rest) + after[i];
        if (cost < best->cost)
            *best = (struct cut){axis, i, cost};
    }
}

/* --- few: sorted by the middles of their boxes --- */

static void sort(const vec3 *middles, uint32_t count, int axis, uint32_t *order)
{
    for (uint32_t i = 0; i < count; i++) {
        uint32_t at = i;
        for (; at > 0 && middles[order[at - 1]][axis] > middles[i][axis]; at--)
            order[at] = order[at - 1];
        order[at] = i;
    }
}

static bool split_sorted(struct bvh_item *items, const struct bvh_range *r, uint32_t *at)
{
    const uint32_t count = r->end - r->begin;
    struct bvh_item copy[SORTED];
    struct side one[SORTED], sides[SORTED];
    vec3 middles[SORTED];
    uint32_t order[SORTED], best_order[SORTED];
    for (uint32_t i = 0; i < count; i++) {
        copy[i] = items[r->begin + i];
        one[i] = (struct side){{bounds_load(copy[i].lo), bounds_load(copy[i].hi)},
                               bvh_item_weight(&copy[i])};
        middles[i] = middle_of(one[i].box.lo, one[i].box.hi);
    }
    struct cut best = {-1, 0, __builtin_inff()};
    for (int axis = 0; axis < 3; axis++) {
        sort(middles, count, axis, order);
        for (uint32_t i = 0; i < count; i++)
            sides[i] = one[order[i]];
        try_cuts(sides, count, axis, &best);
        if (best.axis == axis)
            memcpy(best_order, order, sizeof order);
    }
    if (best.axis < 0)
        return false;
    for (uint32_t i = 0; i < count; i++)
        items[r->begin + i] = copy[best_order[i]];
    *at = r->begin + best.at;
    return true;
}

/* --- many: by bins --- */

struct grid { /* what turns a middle into its bin along each axis */
    vec3 lo, scale;
    uint32_t bins;
};

static inline i32x4 bin_of(const struct grid *g, vec3 middle)
{
    return vec3_truncate((middle - g->lo) * g->scale);
}

static inline vec3 middle_of_item(const struct bvh_item *item)
{
    return middle_of(bounds_load(item->lo), bounds_load(item->hi));
}

/* The last bin's middles must stay below `bins` after rounding; an axis without width has one bin.
 */
static struct grid grid_make(const struct bvh_range *r)
{
    const uint32_t by_count = 8 + (r->end - r->begin) / 32;
    struct grid g = {.lo = r->middles.lo, .bins = min_u32(BINS, by_count)};
    for (int k = 0; k < 3; k++) {
        const float width = r->middles.hi[k] - g.lo[k];
        const float scale = (float)g.bins * (1 - 0x1p-20f) / width;
        g.scale[k] = width > 0 && scale < __builtin_inff() ? scale : 0;
    }
    return g;
}

static struct cut choose_bin(const struct bvh_item *items, const struct bvh_range *r,
                             const struct grid *g)
{
    struct side bins[3][BINS];
    for (int axis = 0; axis < 3; axis++)
        for (uint32_t i = 0; i < g->bins; i++)
            bins[axis][i] = (struct side){empty_box(), 0};
    for (uint32_t i = r->begin; i < r->end; i++) {
        const struct bvh_item *item = &items[i];
        const struct side s = {{bounds_load(item->lo), bounds_load(item->hi)},
                               bvh_item_weight(item)};
        const i32x4 bin = bin_of(g, middle_of(s.box.lo, s.box.hi));
        for (int axis = 0; axis < 3; axis++)
            add_side(&bins[axis][bin[axis]], &s);
    }
    struct cut best = {-1, 0, __builtin_inff()};
    for (int axis = 0; axis < 3; axis++)
        if (g->scale[axis] > 0)
            try_cuts(bins[axis], g->bins, axis, &best);
    return best;
}

static void partition(struct bvh_item *items, const struct bvh_range *r, const struct grid *g,
                      const struct cut *cut, struct bvh_range part[2])
{
    uint32_t i = r->begin, j = r->end;
    part[0] = empty_range(i);
    part[1] = empty_range(j);
    for (;;) {
        while (i < j && bin_of(g, middle_of_item(&items[i]))[cut->axis] < (int32_t)cut->at)
            take(&part[0], &items[i++]);
        while (i < j && bin_of(g, middle_of_item(&items[j - 1]))[cut->axis] >= (int32_t)cut->at)
            take(&part[1], &items[--j]);
        if (i >= j)
            break;
        const struct bvh_item item = items[i];
        items[i] = items[j - 1];
        items[j - 1] = item;
    }
    part[0].end = part[1].begin = i;
}

void bvh_split(struct bvh_item *items, const struct bvh_range *r, bool by_count,
               struct bvh_range part[2])
{
    uint32_t at = r->begin + (r->end - r->begin) / 2;
    if (!by_count && r->end - r->begin > SORTED) {
        const struct grid g = grid_make(r);
        const struct cut cut = choose_bin(items, r, &g);
        if (cut.axis >= 0) {
            partition(items, r, &g, &cut, part);
            return;
        }
    } else if (!by_count) {
        split_sorted(items, r, &at); /* no cut is better than another: in halves */
    }
    part[0] = bvh_range_make(items, r->begin, at);
    part[1] = bvh_range_make(items, at, r->end);
}
