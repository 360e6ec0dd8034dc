/* SPDX-License-Identifier: MIT */
#include "common/trace/bvh_split.h"

#include <assert.h>

enum {
    BINS = 32,   /* at most */
    STRAY = 128, /* items of the wrong side that are noted before any is moved */
};

struct cut {
    int axis;    /* -1: none */
    uint32_t at; /* bins below, or sorted items before it, are the first part */
    float cost;
};

/* The item's box. Its other two numbers are no floats, and slow to compute with. */
static inline f32x8 box_of(const struct bvh_item *item)
{
    const i32x8 keep = {-1, -1, -1, 0, -1, -1, -1, 0};
    return (f32x8)((i32x8)f32x8_load(item->lo) & keep);
}

/* The middle of a box as a box. Halves first: the sum of two large coordinates could overflow. */
static inline f32x8 middle_of(f32x8 box)
{
    const f32x8 half = box * 0.5f;
    return half - __builtin_shufflevector(half, half, 4, 5, 6, 7, 0, 1, 2, 3);
}

struct bvh_range bvh_range_make(const struct bvh_item *items, uint32_t begin, uint32_t end)
{
    struct bvh_range r = {begin, end, 0, bvh_box_empty(), bvh_box_empty()};
    for (uint32_t i = begin; i < end; i++) {
        const f32x8 box = box_of(&items[i]);
        r.box.v = f32x8_min(box, r.box.v);
        r.middles.v = f32x8_min(middle_of(box), r.middles.v);
        r.weight += bvh_item_weight(&items[i]);
    }
    return r;
}

/* --- cuts between sides that lie in a row --- */

struct row {
    const struct bvh_box *box;
    const uint32_t *weight; /* 0: nothing is there */
    uint32_t count;
};

static float cost_of(const struct bvh_box *box, uint32_t weight)
{
    const uint32_t leaves = (weight + BVH_LEAF_WEIGHT - 1) / BVH_LEAF_WEIGHT;
    return bvh_half_area(box) * (float)(int32_t)leaves;
}

/* The cheapest cut. */
static void try_cuts(const struct row *row, int axis, struct cut *best)
{
    float after[BINS];
    struct bvh_box box = bvh_box_empty();
    uint32_t weight = 0;
    for (uint32_t i = row->count - 1; i > 0; i--) {
        bvh_box_grow(&box, row->box[i]);
        weight += row->weight[i];
        after[i] = weight ? cost_of(&box, weight) : __builtin_inff();
    }
    box = bvh_box_empty();
    weight = 0;
    for (uint32_t i = 1; i < row->count; i++) {
        bvh_box_grow(&box, row->box[i - 1]);
        weight += row->weight[i - 1];
        const float cost = weight ? cost_of(&box, weight) + after[i] : __builtin_inff();
        if (cost < best->cost)
            *best = (struct cut){axis, i, cost};
    }
}

/* What lies on the two sides of a cut, but for where the items are. */
static void cut_row(const struct row *row, uint32_t at, struct bvh_range part[2])
{
    for (uint32_t side = 0; side < 2; side++) {
        part[side] = (struct bvh_range){.box = bvh_box_empty(), .middles = bvh_box_empty()};
        const uint32_t end = side ? row->count : at;
        for (uint32_t i = side ? at : 0; i < end; i++) {
            bvh_box_grow(&part[side].box, row->box[i]);
            part[side].weight += row->weight[i];
        }
    }
}

static void place(struct bvh_range part[2], const struct bvh_range *r, uint32_t middle)
{
    part[0].begin = r->begin;
    part[0].end = part[1].begin = middle;
    part[1].end = r->end;
}

/* --- few: sorted by the middles of their boxes --- */

struct few {
    uint32_t count;
    struct bvh_item items[BVH_FEW];
    struct bvh_box box[BVH_FEW];
    alignas(32) float middle[3][BVH_FEW]; /* infinite from `count` on */
};

static void few_init(struct few *f, const struct bvh_item *items, uint32_t count)
{
    f->count = count;
    for (int axis = 0; axis < 3; axis++)
        for (uint32_t i = 0; i < BVH_FEW; i += 8)
            f32x8_store(&f->middle[axis][i], f32x8_splat(__builtin_inff()));
    for (uint32_t i = 0; i < count; i++) {
        f->items[i] = items[i];
        f->box[i].v = box_of(&items[i]);
        const f32x8 middle = middle_of(f->box[i].v);
        for (int axis = 0; axis < 3; axis++)
            f->middle[axis][i] = middle[axis];
    }
}

_Static_assert(BVH_FEW == 16, "two vectors of middles");

/* An item's place is the number of those before it: no branch can be mispredicted. Equal ones stay
 * in their order. */
static void sort(const float middle[BVH_FEW], uint32_t count, uint32_t order[BVH_FEW])
{
    const f32x8 low = f32x8_load(middle), high = f32x8_load(middle + 8);
    for (uint32_t i = 0; i < count; i++) {
        const f32x8 own = f32x8_splat(middle[i]);
        const uint32_t below = i32x8_mask(low < own) | i32x8_mask(high < own) << 8;
        const uint32_t same = i32x8_mask(low == own) | i32x8_mask(high == own) << 8;
        order[__builtin_popcount(below | (same & ((1u << i) - 1)))] = i;
    }
}

static bool split_sorted(struct bvh_item *items, const struct bvh_range *r,
                         struct bvh_range part[2])
{
    struct few f;
    struct bvh_box box[BVH_FEW];
    uint32_t weight[BVH_FEW], order[3][BVH_FEW];
    const struct row row = {box, weight, r->end - r->begin};
    struct cut best = {-1, 0, __builtin_inff()};
    few_init(&f, items + r->begin, row.count);
    for (int axis = 0; axis < 3; axis++) {
        sort(f.middle[axis], f.count, order[axis]);
        for (uint32_t i = 0; i < f.count; i++) {
            box[i] = f.box[order[axis][i]];
            weight[i] = bvh_item_weight(&f.items[order[axis][i]]);
        }
        try_cuts(&row, axis, &best);
    }
    if (best.axis < 0)
        return false;
    for (uint32_t i = 0; i < f.count; i++) {
        const uint32_t from = order[best.axis][i];
        items[r->begin + i] = f.items[from];
        box[i] = f.box[from];
        weight[i] = bvh_item_weight(&f.items[from]);
    }
    cut_row(&row, best.at, part);
    place(part, r, r->begin + best.at);
    return true;
}

/* --- many: by bins --- */

struct grid { /* what turns a middle into its bin along each axis */
    vec3 lo, scale;
    uint32_t bins;
};

struct bins {
    struct bvh_box box[3][BINS];
    alignas(32) uint32_t items[3][BINS];
    uint32_t weight[3][BINS];
};

/* The last bin's middles must stay below `bins` after rounding; an axis without width has one bin.
 */
static struct grid grid_make(const struct bvh_range *r)
{
    const uint32_t by_count = 8 + (r->end - r->begin) / 32;
    struct grid g = {.lo = bvh_box_lo(&r->middles), .bins = min_u32(BINS, by_count)};
    const vec3 width = bvh_box_hi(&r->middles) - g.lo;
    for (int k = 0; k < 3; k++) {
        const float scale = (float)g.bins * (1 - 0x1p-20f) / width[k];
        g.scale[k] = width[k] > 0 && scale < __builtin_inff() ? scale : 0;
    }
    return g;
}

static inline i32x4 bin_of(const struct grid *g, f32x8 box)
{
    return vec3_truncate((f32x8_low(middle_of(box)) - g->lo) * g->scale);
}

static void fill_bins(struct bins *bins, const struct bvh_item *items, const struct bvh_range *r,
                      const struct grid *g)
{
    for (int axis = 0; axis < 3; axis++) {
        for (uint32_t i = 0; i < g->bins; i++)
            bins->box[axis][i] = bvh_box_empty();
        for (uint32_t i = 0; i < BINS; i += 8)
            f32x8_store_bits(&bins->items[axis][i], (f32x8){0});
    }
    for (uint32_t i = r->begin; i < r->end; i++) {
        const f32x8 box = box_of(&items[i]);
        const i32x4 bin = bin_of(g, box);
        for (int axis = 0; axis < 3; axis++) {
            struct bvh_box *to = &bins->box[axis][bin[axis]];
            to->v = f32x8_min(box, to->v);
            bins->items[axis][bin[axis]]++;
        }
    }
}

/* Where not all items weigh 1. */
static void weigh_bins(struct bins *bins, const struct bvh_item *items, const struct bvh_range *r,
                       const struct grid *g)
{
    memset(bins->weight, 0, sizeof bins->weight);
    for (uint32_t i = r->begin; i < r->end; i++) {
        const i32x4 bin = bin_of(g, box_of(&items[i]));
        for (int axis = 0; axis < 3; axis++)
            bins->weight[axis][bin[axis]] += bvh_item_weight(&items[i]);
    }
}

/* The items of one side of a cut that may be among the others. */
struct zone {
    uint32_t at, end;       /* not looked at yet */
    uint32_t stray[STRAY];  /* of those looked at, the ones of the other side; not moved yet: */
    uint32_t begin, count;  /* of `stray` */
    struct bvh_box middles; /* of those looked at that belong here */
};

/* Which side an item belongs to: computed as bin_of does, so that sides have the items that were
 * counted in their bins. */
struct side_test {
    u32x8 axis;
    f32x8 lo, scale, at; /* along it, eight times */
};

/* Looks at items until some are astray, or there are no more. */
static void find_strays(struct zone *z, struct zone *other, const struct bvh_item *items,
                        const struct side_test *t, i32x8 second)
{
    f32x8 own = z->middles.v, others = other->middles.v;
    uint32_t count = 0;
    while (!count && z->at < z->end) {
        const uint32_t begin = z->at, end = min_u32(z->end, begin + STRAY);
        for (uint32_t i = begin; i < end; i++) {
            const f32x8 middle = middle_of(box_of(&items[i]));
            const f32x8 bin = (f32x8_spread(middle, t->axis) - t->lo) * t->scale;
            const i32x8 astray = (bin >= t->at) ^ second;
            z->stray[count] = i;
            count += i32x8_mask(astray) & 1;
            /* All ones are a NaN, and the minimum is then what it was. */
            own = f32x8_min((f32x8)((i32x8)middle | astray), own);
            others = f32x8_min((f32x8)((i32x8)middle | ~astray), others);
        }
        z->at = end;
    }
    z->begin = 0;
    z->count = count;
    z->middles.v = own;
    other->middles.v = others;
}

/* Each side has as many strays as the other: in pairs they change places. Where a branch would
 * depend on an item's side, every other one would be mispredicted (S. Edelkamp, A. Weiss,
 * "BlockQuicksort", ESA 2016). */
static void partition(struct bvh_item *items, const struct grid *g, const struct cut *cut,
                      struct bvh_range part[2])
{
    const uint32_t k = (uint32_t)cut->axis;
    const struct side_test t = {u32x8_splat(k), f32x8_splat(g->lo[k]), f32x8_splat(g->scale[k]),
                                f32x8_splat((float)cut->at)};
    struct zone z[2];
    for (int side = 0; side < 2; side++) {
        z[side].at = part[side].begin;
        z[side].end = part[side].end;
        z[side].begin = z[side].count = 0;
        z[side].middles = bvh_box_empty();
    }
    for (;;) {
        for (int side = 0; side < 2; side++)
            if (z[side].begin == z[side].count)
                find_strays(&z[side], &z[1 - side], items, &t, (i32x8){0} - side);
        const uint32_t pairs = min_u32(z[0].count - z[0].begin, z[1].count - z[1].begin);
        if (!pairs)
            break;
        for (uint32_t i = 0; i < pairs; i++) {
            struct bvh_item *a = &items[z[0].stray[z[0].begin++]];
            struct bvh_item *b = &items[z[1].stray[z[1].begin++]];
            const struct bvh_item item = *a;
            *a = *b;
            *b = item;
        }
    }
    assert(z[0].begin == z[0].count && z[1].begin == z[1].count);
    part[0].middles = z[0].middles;
    part[1].middles = z[1].middles;
}

static bool split_binned(struct bvh_item *items, const struct bvh_range *r,
                         struct bvh_range part[2])
{
    const struct grid g = grid_make(r);
    struct bins bins;
    struct cut best = {-1, 0, __builtin_inff()};
    const bool alike = r->weight == r->end - r->begin;
    fill_bins(&bins, items, r, &g);
    if (!alike)
        weigh_bins(&bins, items, r, &g);
    struct row row[3];
    for (int axis = 0; axis < 3; axis++) {
        row[axis] =
            (struct row){bins.box[axis], alike ? bins.items[axis] : bins.weight[axis], g.bins};
        if (g.scale[axis] > 0)
            try_cuts(&row[axis], axis, &best);
    }
    if (best.axis < 0)
        return false;
    cut_row(&row[best.axis], best.at, part);
    uint32_t middle = r->begin;
    for (uint32_t i = 0; i < best.at; i++)
        middle += bins.items[best.axis][i];
    place(part, r, middle);
    partition(items, &g, &best, part);
    return true;
}

void bvh_split(struct bvh_item *items, const struct bvh_range *r, bool by_count,
               struct bvh_range part[2])
{
    const uint32_t count = r->end - r->begin;
    if (!by_count &&
        (count > BVH_FEW ? split_binned(items, r, part) : split_sorted(items, r, part)))
        return;
    const uint32_t middle = r->begin + count / 2; /* no cut is better than another */
    part[0] = bvh_range_make(items, r->begin, middle);
    part[1] = bvh_range_make(items, middle, r->end);
}
