/* The tree over many lights (light_tree.h): built from the root down.
 *
 * A group is split in two where A. Conty Estevez and C. Kulla's heuristic says: the sum over both
 * of intensity times extent times spread of directions, at the best of a dozen cuts along each
 * axis. For extent stands the square of a box's diagonal, for spread 4 - 3 |mean direction|: like
 * their measure it is four times as large for lights that face everywhere as for those that face
 * one way, and it takes no bounding cone. A node's eight groups are made by splitting the costliest
 * one until there are eight. SPDX-License-Identifier: MIT */
#include "common/trace/prep_plan.h"

#include <float.h>
#include <string.h>

#include "common/trace/cylinder.h"
#include "common/trace/simd.h"
#include "common/trace/tri.h"

#define PI 3.14159265358979323846

enum { BINS = 12, MOST_SPLITS = 32 /* in a row; from then on groups are halved by count */ };

/* The weakest light has this part of all intensity, so that it has a chance. */
#define LEAST_INTENSITY 0x1p-60

struct item {
    struct bvh_box box;
    vec3 facing; /* intensity times the direction in which it faces; lane 3: intensity */
    float reach; /* cos of the largest angle from there at which it shines */
    uint32_t emitter;
    bool all_round; /* faces everywhere: facing is 0 */
};

struct sum {
    struct bvh_box box;
    f64x4 facing; /* as above */
};

struct group { /* of items, half-open, not empty */
    uint32_t begin, end, splits;
    struct sum sum;
    struct bvh_box middles; /* twice the middles of their boxes */
};

struct maker {
    struct prep_plan *plan;
    struct item *items;
    double scale; /* of intensities, in nodes */
    uint32_t node_count;
};

/* --- items --- */

static struct bvh_box box_of(vec3 lo, vec3 hi)
{
    return bvh_box_make(lo, hi);
}

/* The radiance from a surface makes an intensity of radiance times projected area. */
static double measure_prim(const struct prep_plan *p, const struct emitter *e, struct item *item,
                           vec3 *facing)
{
    const double radiance = (double)rgb_luminance(vec3_load(e->radiance)), area = (double)e->area;
    const uint32_t index = e->place.index;
    vec3 lo = {0}, hi = {0};
    switch ((enum stage_kind)e->place.kind) {
    case STAGE_TRIANGLE: {
        const struct stage_triangle *t = &p->trees[0].triangles[index];
        const vec3 a = vec3_load(t->v[0]);
        const f64x4 n = f64x4_cross(f64x4_of(vec3_load(t->v[1])) - f64x4_of(a),
                                    f64x4_of(vec3_load(t->v[2])) - f64x4_of(a));
        *facing = f64x4_round(n / __builtin_sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]));
        tri_bounds(t, &lo, &hi);
        item->box = box_of(lo, hi);
        return radiance * area;
    }
    case STAGE_DISC:
        *facing = vec3_load(p->discs[index].normal);
        sphere_bounds(p->discs[index].center, p->discs[index].radius, &lo, &hi);
        item->box = box_of(lo, hi);
        return radiance * area;
    case STAGE_SPHERE:
        sphere_bounds(p->spheres[index].center, p->spheres[index].radius, &lo, &hi);
        break;
    case STAGE_CYLINDER:
        cylinder_bounds(&p->cylinders[index], &lo, &hi);
        break;
    }
    item->box = box_of(lo, hi);
    item->all_round = true;
    return radiance * area / (e->place.kind == STAGE_SPHERE ? 4 : PI);
}

static double measure(const struct prep_plan *p, const struct emitter *e, struct item *item,
                      vec3 *facing)
{
    const vec3 at = vec3_load(e->at);
    switch (e->kind) {
    case EMITTER_PRIM:
        return measure_prim(p, e, item, facing);
    case EMITTER_SPOT:
        *facing = vec3_load(p->spots[e->index].direction);
        item->reach = 1 - p->spots[e->index].outer;
        break;
    case EMITTER_POINT:
        item->all_round = true;
        break;
    case EMITTER_DISTANT: /* are not in the tree */
    case EMITTER_SUN:
    case EMITTER_MAP:
        __builtin_unreachable();
    }
    item->box = box_of(at, at);
    return (double)rgb_luminance(vec3_load(e->radiance));
}

static void make_items(struct maker *m, struct arena *scratch)
{
    const struct prep_plan *p = m->plan;
    const uint32_t count = p->head.far_begin;
    double *intensity = arena_new(scratch, double, count), total = 0;
    m->items = arena_alloc(scratch, count, sizeof *m->items, 64);
    vec3 *facing = arena_alloc(scratch, count, sizeof *facing, 16);
    for (uint32_t i = 0; i < count; i++) {
        m->items[i].emitter = i;
        intensity[i] = measure(p, &p->emitters[i], &m->items[i], &facing[i]);
        total += intensity[i];
    }
    for (uint32_t i = 0; i < count; i++) {
        double part = total > 0 ? intensity[i] / total : 1 / (double)count;
        part = part > LEAST_INTENSITY ? part : LEAST_INTENSITY;
        m->items[i].facing = facing[i] * (float)part;
        m->items[i].facing[3] = (float)part;
    }
}

/* --- groups --- */

static struct sum sum_empty(void)
{
    return (struct sum){bvh_box_empty(), {0}};
}

static void sum_add(struct sum *s, const struct item *item)
{
    bvh_box_grow(&s->box, item->box);
    s->facing += f64x4_of(item->facing);
}

static void sum_join(struct sum *s, const struct sum *by)
{
    bvh_box_grow(&s->box, by->box);
    s->facing += by->facing;
}

static double sum_cost(const struct sum *s)
{
    const double intensity = s->facing[3];
    if (!(intensity > 0))
        return 0;
    const f64x4 sides = f64x4_of(f32x8_low(s->box.v) + f32x8_high(s->box.v)); /* negative */
    const f64x4 squares = sides * sides, n = s->facing * s->facing;
    const double spread = 4 - 3 * __builtin_sqrt(n[0] + n[1] + n[2]) / intensity;
    return intensity * spread * (squares[0] + squares[1] + squares[2]);
}

/* Twice the middle of a box. */
static vec3 middle_of(const struct item *item)
{
    return f32x8_low(item->box.v) - f32x8_high(item->box.v);
}

static struct group group_make(const struct maker *m, uint32_t begin, uint32_t end, uint32_t splits)
{
    struct group g = {begin, end, splits, sum_empty(), bvh_box_empty()};
    for (uint32_t i = begin; i < end; i++) {
        const vec3 middle = middle_of(&m->items[i]);
        sum_add(&g.sum, &m->items[i]);
        bvh_box_grow(&g.middles, bvh_box_make(middle, middle));
    }
    return g;
}

struct grid { /* of bins along each axis */
    vec3 lo, scale;
};

static struct grid grid_make(const struct group *g)
{
    const vec3 lo = bvh_box_lo(&g->middles), side = bvh_box_hi(&g->middles) - lo;
    struct grid grid = {lo, {0}};
    for (int k = 0; k < 3; k++)
        grid.scale[k] = side[k] > 0 ? (float)BINS * 0.99999f / side[k] : 0;
    return grid;
}

static uint32_t bin_of(const struct grid *grid, const struct item *item, int axis)
{
    const float x = (middle_of(item)[axis] - grid->lo[axis]) * grid->scale[axis];
    return x < BINS - 1 ? (uint32_t)x : BINS - 1; /* scale may have left the range of float */
}

struct cut {
    int axis;
    uint32_t bin; /* the first of the second part */
    double cost;
};

static void cut_best(const struct sum bins[BINS], int axis, struct cut *best)
{
    double right[BINS];
    struct sum sum = sum_empty();
    for (int b = BINS - 1; b > 0; b--) {
        sum_join(&sum, &bins[b]);
        right[b] = sum.facing[3] > 0 ? sum_cost(&sum) : -1;
    }
    sum = sum_empty();
    for (int b = 1; b < BINS; b++) {
        sum_join(&sum, &bins[b - 1]);
        const double cost = sum_cost(&sum) + right[b];
        if (sum.facing[3] > 0 && right[b] >= 0 && cost < best->cost)
            *best = (struct cut){axis, (uint32_t)b, cost};
    }
}

/* False: their middles are all the same. */
static bool cut_find(const struct maker *m, const struct group *g, const struct grid *grid,
                     struct cut *best)
{
    struct sum bins[3][BINS];
    *best = (struct cut){0, 0, __builtin_inf()};
    for (int i = 0; i < 3 * BINS; i++)
        bins[i / BINS][i % BINS] = sum_empty();
    for (uint32_t i = g->begin; i < g->end; i++)
        for (int axis = 0; axis < 3; axis++)
            sum_add(&bins[axis][bin_of(grid, &m->items[i], axis)], &m->items[i]);
    for (int axis = 0; axis < 3; axis++)
        cut_best(bins[axis], axis, best);
    return best->bin > 0;
}

static uint32_t partition(const struct maker *m, const struct group *g, const struct grid *grid,
                          const struct cut *cut)
{
    uint32_t low = g->begin, high = g->end; /* what is before low is of the first part */
    while (low < high) {
        if (bin_of(grid, &m->items[low], cut->axis) < cut->bin) {
            low++;
            continue;
        }
        const struct item other = m->items[--high];
        m->items[high] = m->items[low];
        m->items[low] = other;
    }
    return low;
}

/* Two items at least; the first part stays in *g. */
static struct group group_split(const struct maker *m, struct group *g)
{
    const struct grid grid = grid_make(g);
    const uint32_t begin = g->begin, end = g->end, splits = g->splits + 1;
    struct cut cut;
    uint32_t middle = begin + (end - begin) / 2;
    if (splits <= MOST_SPLITS && cut_find(m, g, &grid, &cut))
        middle = partition(m, g, &grid, &cut);
    *g = group_make(m, begin, middle, splits);
    return group_make(m, middle, end, splits);
}

/* --- nodes --- */

static void fill_sphere(struct stage_light_node *n, int lane, const struct bvh_box *box)
{
    const vec3 lo = bvh_box_lo(box), hi = bvh_box_hi(box), center = 0.5f * lo + 0.5f * hi;
    double rr = 0;
    for (int k = 0; k < 3; k++) {
        const double a = (double)hi[k] - (double)center[k], b = (double)center[k] - (double)lo[k];
        n->center[k][lane] = center[k];
        rr += a > b ? a * a : b * b;
    }
    n->radius[lane] = (float)(__builtin_sqrt(rr) * (1 + 0x1p-20));
}

/* Whether they all shine all round. */
static bool fill_cone(const struct maker *m, struct stage_light_node *n, int lane,
                      const struct group *g)
{
    const f64x4 f = g->sum.facing;
    const double length = __builtin_sqrt(f[0] * f[0] + f[1] * f[1] + f[2] * f[2]);
    vec3 axis = {0, 0, 1, 0};
    float facing = 1, reach = 1;
    bool all_round = !(length > 0), round = true;
    if (!all_round)
        axis = f64x4_round(f / length);
    for (uint32_t i = g->begin; i < g->end; i++) {
        const struct item *item = &m->items[i];
        const float cosine = vec3_dot(item->facing, axis) / item->facing[3];
        all_round = all_round || item->all_round;
        round = round && item->all_round;
        facing = cosine < facing ? cosine : facing;
        reach = item->reach < reach ? item->reach : reach;
    }
    for (int k = 0; k < 3; k++)
        n->axis[k][lane] = axis[k];
    n->facing[lane] = all_round || facing < -1 + 0x1p-20f ? -1 : facing - 0x1p-20f;
    n->reach[lane] = reach;
    return round;
}

/* A node's groups, the costliest split until there are eight or nothing is left to split. */
static int split_in_eight(const struct maker *m, struct group g[STAGE_LANES])
{
    int count = 1;
    for (; count < STAGE_LANES; count++) {
        int most = -1;
        double cost = -1;
        for (int i = 0; i < count; i++) {
            const uint32_t items = g[i].end - g[i].begin;
            const double c = items > 1 ? sum_cost(&g[i].sum) : -1;
            if (c > cost) {
                most = i;
                cost = c;
            }
        }
        if (most < 0)
            break;
        g[count] = group_split(m, &g[most]);
    }
    return count;
}

static uint32_t make_node(struct maker *m, const struct group *of, uint32_t parent)
{
    struct group g[STAGE_LANES] = {*of};
    const int count = split_in_eight(m, g);
    const uint32_t node = m->node_count++;
    struct stage_light_node *n = &m->plan->light_nodes[node];
    m->plan->light_parents[node] = parent;
    bool round = true;
    for (int lane = 0; lane < count; lane++) {
        const uint32_t slot = STAGE_LANES * node + (uint32_t)lane;
        fill_sphere(n, lane, &g[lane].sum.box);
        round &= fill_cone(m, n, lane, &g[lane]);
        const float intensity = (float)(g[lane].sum.facing[3] * m->scale);
        n->intensity[lane] = intensity > FLT_MIN ? intensity : FLT_MIN;
        if (g[lane].end - g[lane].begin > 1) {
            n->child[lane] = make_node(m, &g[lane], slot);
            continue;
        }
        const uint32_t emitter = m->items[g[lane].begin].emitter;
        n->child[lane] = STAGE_LIGHT_LEAF + emitter;
        m->plan->emitters[emitter].slot = slot;
    }
    if (round)
        n->child[0] |= STAGE_LIGHT_ROUND;
    return node;
}

/* A node has eight children, or two or more that all are leaves: so there are n / 2 + n / 7 nodes
 * at most. */
/* The largest that is not above x > 0. Dividing by it rounds nothing: the bounds of a scene whose
 * meshes are shared are a little wider than those of its copy, and both want the same tree. */
static double power_of_two(double x)
{
    uint64_t bits;
    memcpy(&bits, &x, sizeof bits);
    bits &= (uint64_t)0x7ff << 52;
    memcpy(&x, &bits, sizeof x);
    return x;
}

void prep_light_tree(struct prep_plan *p, double radius, struct arena *scratch)
{
    const uint32_t count = p->head.far_begin;
    struct maker m = {.plan = p, .scale = radius > 0 ? power_of_two(radius * radius) : 1};
    make_items(&m, scratch);
    const size_t most = (size_t)count / 2 + count / 7 + 2;
    p->light_nodes = arena_alloc(scratch, most, sizeof *p->light_nodes, STAGE_ALIGN);
    p->light_parents = arena_new(scratch, uint32_t, most);
    const struct group all = group_make(&m, 0, count, 0);
    make_node(&m, &all, STAGE_NONE);
    p->head.light_nodes.count = m.node_count;
    p->head.light_parents.count = m.node_count;
}
