/* SPDX-License-Identifier: MIT */
#include "tests/oracle_bvh.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "common/trace/bvh.h"
#include "common/trace/cylinder.h"
#include "common/trace/sphere.h"
#include "common/trace/tri.h"
#include "tests/catalog.h"

enum { BINS = 16, LEAF_MOST = 4, DEPTH_MOST = 100 };

/* Of the size of all numbers about: more than what a primitive's own test errs by (box8.h). */
static const double pad = 0x1p-18;

struct box {
    double lo[3], hi[3];
};

struct oracle_node {
    struct box box;
    uint32_t first, count; /* count 0: the children are first and first + 1; else these ids */
};

struct item {
    struct box box;
    struct stage_id id;
};

static struct box bounds_of(const struct stage *s, const struct stage_id *id)
{
    vec3 lo = {0}, hi = {0};
    const uint32_t i = id->place.index;
    switch ((enum stage_kind)id->place.kind) {
    case STAGE_TRIANGLE: {
        const struct stage_triangle t = stage_triangle_at(s, i, id->instance);
        tri_bounds(&t, &lo, &hi);
        break;
    }
    case STAGE_SPHERE: {
        const struct stage_sphere *p = (const struct stage_sphere *)stage_at(s, s->spheres) + i;
        sphere_bounds(p->center, p->radius, &lo, &hi);
        break;
    }
    case STAGE_DISC: {
        const struct stage_disc *p = (const struct stage_disc *)stage_at(s, s->discs) + i;
        sphere_bounds(p->center, p->radius, &lo, &hi);
        break;
    }
    case STAGE_CYLINDER:
        cylinder_bounds((const struct stage_cylinder *)stage_at(s, s->cylinders) + i, &lo, &hi);
        break;
    }
    struct box box;
    for (int k = 0; k < 3; k++) {
        box.lo[k] = (double)lo[k];
        box.hi[k] = (double)hi[k];
    }
    return box;
}

static void grow(struct box *b, const struct box *other)
{
    for (int k = 0; k < 3; k++) {
        b->lo[k] = fmin(b->lo[k], other->lo[k]);
        b->hi[k] = fmax(b->hi[k], other->hi[k]);
    }
}

static const struct box nowhere = {{HUGE_VAL, HUGE_VAL, HUGE_VAL},
                                   {-HUGE_VAL, -HUGE_VAL, -HUGE_VAL}};

static double area(const struct box *b)
{
    const double x = b->hi[0] - b->lo[0], y = b->hi[1] - b->lo[1], z = b->hi[2] - b->lo[2];
    return x < 0 ? 0 : x * y + y * z + z * x;
}

/* --- the tree: surface area heuristic in bins along the longest axis of the middles --- */

struct bins {
    int axis;
    double lo, scale;
};

static int bin_of(const struct bins *b, const struct item *item)
{
    const double middle = item->box.lo[b->axis] + item->box.hi[b->axis];
    const int bin = (int)((middle - b->lo) * b->scale);
    return bin < BINS ? bin : BINS - 1;
}

static struct bins bins_make(const struct item *items, uint32_t count)
{
    struct box middles = nowhere; /* twice */
    for (uint32_t i = 0; i < count; i++)
        for (int k = 0; k < 3; k++) {
            const double m = items[i].box.lo[k] + items[i].box.hi[k];
            middles.lo[k] = fmin(middles.lo[k], m);
            middles.hi[k] = fmax(middles.hi[k], m);
        }
    int axis = 0;
    for (int k = 1; k < 3; k++)
        if (middles.hi[k] - middles.lo[k] > middles.hi[axis] - middles.lo[axis])
            axis = k;
    const double width = middles.hi[axis] - middles.lo[axis];
    return (struct bins){axis, middles.lo[axis], width > 0 ? BINS / width : 0};
}

/* The first bin of the right side; 0: there is no cut. */
static int cheapest_cut(const struct bins *bins, const struct item *items, uint32_t count)
{
    struct box box[BINS], side = nowhere;
    uint32_t filled[BINS] = {0}, n = 0;
    double right[BINS], least = HUGE_VAL;
    for (int i = 0; i < BINS; i++)
        box[i] = nowhere;
    for (uint32_t i = 0; i < count; i++) {
        const int bin = bin_of(bins, &items[i]);
        grow(&box[bin], &items[i].box);
        filled[bin]++;
    }
    for (int i = BINS - 1; i > 0; i--) {
        grow(&side, &box[i]);
        right[i] = area(&side) * (n += filled[i]);
    }
    int best = 0;
    side = nowhere;
    n = 0;
    for (int i = 1; i < BINS; i++) {
        grow(&side, &box[i - 1]);
        n += filled[i - 1];
        const double cost = area(&side) * n + right[i];
        if (n && n < count && cost < least) {
            least = cost;
            best = i;
        }
    }
    return best;
}

/* Where the right part begins. */
static uint32_t cut(struct item *items, uint32_t count, bool halve)
{
    const struct bins bins = bins_make(items, count);
    const int right = halve ? 0 : cheapest_cut(&bins, items, count);
    if (!right)
        return count / 2;
    uint32_t i = 0, j = count;
    while (i < j) {
        if (bin_of(&bins, &items[i]) < right) {
            i++;
        } else {
            const struct item other = items[--j];
            items[j] = items[i];
            items[i] = other;
        }
    }
    return i;
}

static void build(struct oracle *o, struct item *items, uint32_t begin, uint32_t end, uint32_t at,
                  uint32_t depth)
{
    struct oracle_node *node = &o->nodes[at];
    node->box = nowhere;
    for (uint32_t i = begin; i < end; i++)
        grow(&node->box, &items[i].box);
    node->first = begin;
    node->count = end - begin;
    if (node->count <= LEAF_MOST)
        return;
    const uint32_t middle = begin + cut(items + begin, end - begin, depth > DEPTH_MOST / 2);
    const uint32_t child = o->node_count;
    o->node_count += 2;
    node->first = child;
    node->count = 0;
    build(o, items, begin, middle, child, depth + 1);
    build(o, items, middle, end, child + 1, depth + 1);
}

void oracle_make(struct oracle *o, const struct stage *s)
{
    *o = (struct oracle){.stage = s, .node_count = 1};
    const uint32_t count = s->prim_count;
    struct item *items = arena_new(&o->arena, struct item, count);
    uint32_t n = 0;
    struct stage_id id;
    for (uint64_t at = 0; catalog_next(s, &at, &id);) {
        assert(n < count);
        items[n++] = (struct item){bounds_of(s, &id), id};
    }
    assert(n == count);
    o->ids = arena_new(&o->arena, struct stage_id, count);
    o->nodes = arena_new(&o->arena, struct oracle_node, 2 * (size_t)count + 1);
    build(o, items, 0, count, 0, 0);
    for (uint32_t i = 0; i < count; i++)
        o->ids[i] = items[i].id;
}

void oracle_release(struct oracle *o)
{
    arena_release(&o->arena);
}

/* --- a ray --- */

/* Where it enters and leaves, in double; boxes are as much too large as hits may err. */
static bool passes(const struct box *b, const struct ray *ray, double t_max)
{
    double reach = 0, enters = 0, leaves = t_max;
    for (int k = 0; k < 3; k++) {
        const double size = fmax(fabs(b->lo[k]), fabs(b->hi[k])) + fabs((double)ray->origin[k]);
        reach = fmax(reach, size);
    }
    const double room = pad * 2 * reach;
    for (int k = 0; k < 3; k++) {
        const double lo = b->lo[k] - room - (double)ray->origin[k];
        const double hi = b->hi[k] + room - (double)ray->origin[k];
        const double d = (double)ray->dir[k];
        if (d == 0) {
            if (lo > 0 || hi < 0)
                return false;
            continue;
        }
        enters = fmax(enters, fmin(lo / d, hi / d));
        leaves = fmin(leaves, fmax(lo / d, hi / d));
    }
    return enters <= leaves;
}

static bool walk(const struct oracle *o, const struct ray *ray, bool any, struct ray_hit *best)
{
    uint32_t stack[DEPTH_MOST + 40], waiting = 0;
    bool found = false;
    double limit = (double)ray->t_max;
    if (o->stage->prim_count && limit > 0)
        stack[waiting++] = 0;
    while (waiting) {
        const struct oracle_node *node = &o->nodes[stack[--waiting]];
        if (!passes(&node->box, ray, limit))
            continue;
        if (!node->count) {
            const int axis =
                fabsf(ray->dir[0]) > fabsf(ray->dir[2]) ? 0 : 2; /* nearer first, often */
            const struct box *a = &o->nodes[node->first].box, *b = &o->nodes[node->first + 1].box;
            const bool back =
                (a->lo[axis] + a->hi[axis] > b->lo[axis] + b->hi[axis]) != (ray->dir[axis] < 0);
            stack[waiting++] = node->first + !back;
            stack[waiting++] = node->first + back;
            continue;
        }
        for (uint32_t i = node->first; i < node->first + node->count; i++) {
            const struct stage_id *id = &o->ids[i];
            struct ray_hit hit = {.prim = id->prim, .place = id->place, .instance = id->instance};
            if (!bvh_hit_prim(o->stage, ray, &hit))
                continue;
            if (any)
                return true;
            if (!found || hit.t < best->t || (hit.t == best->t && hit.prim < best->prim)) {
                *best = hit;
                limit = (double)hit.t;
            }
            found = true;
        }
    }
    return found;
}

bool oracle_closest(const struct oracle *o, const struct ray *ray, struct ray_hit *hit)
{
    return walk(o, ray, false, hit);
}

bool oracle_any(const struct oracle *o, const struct ray *ray)
{
    struct ray_hit hit;
    return walk(o, ray, true, &hit);
}
