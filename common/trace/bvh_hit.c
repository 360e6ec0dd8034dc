/* Traversal. What a hit is stands under "one primitive"; the rest only must not lose any.
 * SPDX-License-Identifier: MIT */
#include "common/trace/bvh.h"

#include "common/trace/box.h"
#include "common/trace/box8.h"
#include "common/trace/cylinder.h"
#include "common/trace/tri.h"

/* What does not change along the way of one ray. */
struct query {
    const struct stage *stage;
    const unsigned char *first; /* node */
    const struct stage_block *blocks;
    struct tri_ray tri;
    float inv_z; /* 1 / the ray's direction along the axis in which it is longest */
    float t_max; /* the ray's, finite */
};

/* The tree that is walked: the world's (instance STAGE_NONE) or an instance's in its space. */
struct space {
    struct box8_ray box;
    uint32_t instance;
    uint32_t prim_begin; /* what a block's numbers count from */
    float t[2];          /* where the ray enters and leaves the instance's box in the world */
};

/* The nearest hit so far; what only the last one is asked for is not computed yet. */
struct best {
    float t;
    uint32_t prim;
    struct tri_edges edges; /* of a triangle */
    struct stage_place place;
    uint32_t instance;
};

/* What waits on the stack: where the ray enters a child's box, in the upper half, and its reference. For
 * numbers that are not negative the order of floats is that of their bits. */
typedef uint64_t entry;

static inline entry entry_make(uint32_t t_bits, uint32_t ref)
{
    return (entry)t_bits << 32 | ref;
}

/* The last one that is still of interest. */
static inline entry entry_limit(float t)
{
    uint32_t bits;
    memcpy(&bits, &t, sizeof bits);
    return entry_make(bits, UINT32_MAX);
}

/* False when nothing can be hit: a ray that is no ray. */
static inline bool query_make(const struct stage *s, const struct ray *ray, struct query *q)
{
    const vec3 o = ray->origin, d = ray->dir, none = {0};
    const vec3 zero = (o - o) + (d - d); /* a NaN for an infinity, too */
    if ((i32x4_mask(zero == 0) & 7) != 7 || (i32x4_mask(d == none) & 7) == 7 || !(ray->t_max > 0))
        return false;
    q->stage = s;
    q->first = stage_at(s, s->nodes);
    q->blocks = stage_at(s, s->blocks);
    q->tri = tri_ray_make(o, d);
    q->inv_z = 1 / d[q->tri.kz];
    q->t_max = ray->t_max < FLT_MAX ? ray->t_max : FLT_MAX;
    return true;
}

static inline void world_make(const struct query *q, struct space *w)
{
    box8_ray_init(&w->box, q->tri.origin, q->tri.dir, box8_error(q->tri.origin));
    w->instance = STAGE_NONE;
    w->prim_begin = 0;
    w->t[0] = 0;
    w->t[1] = FLT_MAX;
}

static inline uint32_t root_of(const struct stage *s, uint32_t tree)
{
    return ((const struct stage_tree *)stage_at(s, s->trees))[tree].root;
}

/* One box alone, by the test of eight. */
static bool box_alone(const struct box8_ray *r, vec3 lo, vec3 hi, float t[2])
{
    _Alignas(32) float plane[BOX8_PLANES][8] = {{0}};
    box8_store(plane, 0, lo, hi);
    f32x8 near, far;
    const struct box8_wide wide = box8_widen(r);
    const uint32_t hits = box8_hit(r, &wide, (const float(*)[8])plane, FLT_MAX, &near, &far);
    t[0] = near[0];
    t[1] = far[0];
    return hits & 1;
}

/* The ray in object space has the same t. Its error: its own rounding, and what the primitives' tests
 * err by in world space, where they are made (box8.h; the vertices are rounded there, too), seen
 * from here. False: it passes the instance's box. */
static bool space_make(const struct query *q, const struct space *world, uint32_t instance,
                       struct space *space)
{
    const struct stage_instance *of = stage_instance_at(q->stage, instance);
    const vec3 lo = vec3_load(of->lo), hi = vec3_load(of->hi);
    if (!box_alone(&world->box, lo, hi, space->t))
        return false;
    vec3 origin = {0}, dir = {0};
    for (int k = 0; k < 3; k++) {
        const double *m = of->to_object[k];
        double o = m[3], d = 0;
        for (int j = 0; j < 3; j++) {
            o += m[j] * (double)q->tri.origin[j];
            d += m[j] * (double)q->tri.dir[j];
        }
        origin[k] = (float)o;
        dir[k] = (float)d;
    }
    const float reach = box8_reach(vec3_max(vec3_abs(lo), vec3_abs(hi)));
    const float error = BOX8_PAD * (reach + box8_reach(q->tri.origin));
    box8_ray_init(&space->box, origin, dir, box8_error(origin) + error * vec3_load(of->spread));
    space->instance = instance;
    space->prim_begin = of->prim_begin;
    return true;
}

/* --- one primitive --- */

/* A hit lies between where the ray enters the primitive's own box and where it leaves it. Rounding could
 * place it before, and then a tree that skips boxes behind the nearest hit would find one or the
 * other of two near hits as its shape has it; a grazing ray's, far beside the primitive. */
static inline bool settle(const struct query *q, const float own[2], float *t)
{
    *t = *t < own[0] ? own[0] : *t > own[1] ? own[1] : *t;
    return *t > 0 && *t < q->t_max;
}

static bool settle_in_box(const struct query *q, vec3 lo, vec3 hi, float *t)
{
    const struct box_ray box = box_ray_make(q->tri.origin, q->tri.dir, q->tri.kz);
    float own[2];
    return box_hit(&box, lo, hi, own) && settle(q, own, t);
}

/* All but always the hit is well inside the box: with less room than box_hit gives on each side (its
 * error is 5 u of the reach and 5 u of the way), t is between its distances, and stays. */
static inline bool settle_in_world(const struct query *q, vec3 lo, vec3 hi, float *t)
{
    const vec3 a = lo - q->tri.origin, b = hi - q->tri.origin, way = *t * q->tri.dir;
    const vec3 room = 4 * ROUND_UNIT * vec3_max(vec3_abs(a), vec3_abs(b));
    const i32x4 inside = (way >= a - room) & (way <= b + room);
    if (__builtin_expect((i32x4_mask(inside) & 7) == 7, 1))
        return *t < q->t_max;
    return settle_in_box(q, lo, hi, t);
}

/* In object space a triangle has its own box, too: the one that the nodes above are made of. */
static bool settle_in_object(const struct query *q, const struct space *space, uint32_t index,
                             float *t)
{
    const struct stage_triangle tri = stage_triangle_at(q->stage, index, STAGE_NONE);
    vec3 lo, hi;
    float own[2];
    tri_bounds(&tri, &lo, &hi);
    if (!box_alone(&space->box, lo, hi, own))
        return false;
    own[0] = own[0] > space->t[0] ? own[0] : space->t[0];
    own[1] = own[1] < space->t[1] ? own[1] : space->t[1];
    return own[0] <= own[1] && settle(q, own, t);
}

/* Of a triangle that the ray meets (tri_meets), in world space. A NaN is a miss. */
static inline __attribute__((always_inline)) bool
triangle_hit(const struct query *q, const struct stage_triangle *tri, float *t)
{
    *t = tri_plane_t(&q->tri, tri);
    if (!(*t > 0))
        return false;
    vec3 lo, hi;
    tri_bounds(tri, &lo, &hi);
    return settle_in_world(q, lo, hi, t);
}

static bool instance_triangle_hit(const struct query *q, const struct space *space, uint32_t index,
                                  const struct stage_triangle *tri, float *t)
{
    *t = tri_plane_t(&q->tri, tri);
    return *t > 0 && settle_in_object(q, space, index, t);
}

/* Of any other kind; *prim: its number. */
static bool round_hit(const struct query *q, struct stage_place place, float *t, uint32_t *prim)
{
    const struct ray ray = {q->tri.origin, q->tri.dir, q->t_max};
    const struct stage *s = q->stage;
    vec3 lo, hi;
    switch ((enum stage_kind)place.kind) {
    case STAGE_SPHERE: {
        const struct stage_sphere *p =
            (const struct stage_sphere *)stage_at(s, s->spheres) + place.index;
        *prim = p->prim;
        sphere_bounds(p->center, p->radius, &lo, &hi);
        return sphere_hit(&ray, p, t) && settle_in_box(q, lo, hi, t);
    }
    case STAGE_DISC: {
        const struct stage_disc *p = (const struct stage_disc *)stage_at(s, s->discs) + place.index;
        *prim = p->prim;
        sphere_bounds(p->center, p->radius, &lo, &hi);
        return sphere_disc_hit(&ray, p, t) && settle_in_box(q, lo, hi, t);
    }
    case STAGE_CYLINDER: {
        const struct stage_cylinder *p =
            (const struct stage_cylinder *)stage_at(s, s->cylinders) + place.index;
        *prim = p->prim;
        cylinder_bounds(p, &lo, &hi);
        return cylinder_hit(&ray, p, t) && settle_in_box(q, lo, hi, t);
    }
    case STAGE_TRIANGLE:
        break;
    }
    __builtin_unreachable();
}

bool bvh_hit_prim(const struct stage *s, const struct ray *ray, struct ray_hit *hit)
{
    struct query q;
    struct space world, inner;
    if (!query_make(s, ray, &q))
        return false;
    hit->u = hit->v = 0;
    if (hit->place.kind != STAGE_TRIANGLE)
        return round_hit(&q, hit->place, &hit->t, &hit->prim);
    const struct stage_triangle tri = stage_triangle_at(s, hit->place.index, hit->instance);
    const struct tri_edges e = tri_edges_make(&q.tri, &tri);
    if (!tri_meets(e))
        return false;
    tri_weights(e, &hit->u, &hit->v);
    if (hit->instance == STAGE_NONE)
        return triangle_hit(&q, &tri, &hit->t);
    world_make(&q, &world);
    return space_make(&q, &world, hit->instance, &inner) &&
           instance_triangle_hit(&q, &inner, hit->place.index, &tri, &hit->t);
}

/* --- a leaf --- */

struct lanes { /* of a block */
    _Alignas(32) float e[3][STAGE_LANES]; /* when any is met */
    uint32_t met;   /* bit i: tri_meets holds, or may hold */
    uint32_t doubt; /* of those: an edge function is 0, so that the exact one must decide; or NaN */
};

/* A node or a block. */
static inline const void *data_at(const struct query *q, uint32_t ref)
{
    return q->first + (size_t)BVH_LINE * bvh_ref_index(ref);
}

/* Eight triangles by the arithmetic of tri_edges_make, operation by operation. */
static inline __attribute__((always_inline)) void lanes_make(const struct tri_ray *r, const float (*v)[3][STAGE_LANES],
                              struct lanes *out)
{
    const float *px = v[0][r->kx], *py = v[0][r->ky], *pz = v[0][r->kz];
    const size_t next = sizeof v[0] / sizeof *px; /* vertex */
    f32x8 z = f32x8_load(pz) - r->oz;
    const f32x8 ax = (f32x8_load(px) - r->ox) - r->sx * z;
    const f32x8 ay = (f32x8_load(py) - r->oy) - r->sy * z;
    z = f32x8_load(pz + next) - r->oz;
    const f32x8 bx = (f32x8_load(px + next) - r->ox) - r->sx * z;
    const f32x8 by = (f32x8_load(py + next) - r->oy) - r->sy * z;
    z = f32x8_load(pz + 2 * next) - r->oz;
    const f32x8 cx = (f32x8_load(px + 2 * next) - r->ox) - r->sx * z;
    const f32x8 cy = (f32x8_load(py + 2 * next) - r->oy) - r->sy * z;
    const f32x8 e0 = cx * by - cy * bx, e1 = ax * cy - ay * cx, e2 = bx * ay - by * ax;
    const f32x8 least = f32x8_min(e0, f32x8_min(e1, e2)), most = f32x8_max(e0, f32x8_max(e1, e2));
    const f32x8 none = {0};
    out->met = i32x8_mask((least >= none) | (most <= none));
    if (!out->met)
        return;
    const f32x8 det = e0 + e1 + e2;
    out->doubt = out->met & ~i32x8_mask(((least > none) | (most < none)) & (det == det));
    f32x8_store(out->e[0], e0);
    f32x8_store(out->e[1], e1);
    f32x8_store(out->e[2], e2);
}

/* Lanes whose hit, which lies within their triangle's own box (settle), cannot lie within (0, t_max], as the
 * axis in which the ray is longest shows: box_hit's error is 10 u of the reach there, and 5 u are its
 * roundings and those made here. For triangles of the world. A NaN keeps its lane. */
static inline uint32_t lanes_beyond(const struct query *q, const struct stage_block *b, float t_max)
{
    const float *pz = b->v[0][q->tri.kz];
    const size_t next = sizeof b->v[0] / sizeof *pz;
    const f32x8 t0 = (f32x8_load(pz) - q->tri.oz) * q->inv_z;
    const f32x8 t1 = (f32x8_load(pz + next) - q->tri.oz) * q->inv_z;
    const f32x8 t2 = (f32x8_load(pz + 2 * next) - q->tri.oz) * q->inv_z;
    const f32x8 least = f32x8_min(t0, f32x8_min(t1, t2)), most = f32x8_max(t0, f32x8_max(t1, t2));
    const float room = 16 * ROUND_UNIT;
    return i32x8_mask((most < room * least) | (least - room * most > f32x8_splat(t_max)));
}

/* The vertices as xform_point makes them. */
static __attribute__((noinline)) void lanes_make_in_instance(const struct query *q, const struct stage_block *b,
                                   uint32_t instance, struct lanes *out)
{
    const struct stage_instance *of = stage_instance_at(q->stage, instance);
    const float(*m)[4] = of->to_world.m;
    _Alignas(32) float world[3][3][STAGE_LANES];
    for (int i = 0; i < 3; i++) {
        const f32x8 x = f32x8_load(b->v[i][0]), y = f32x8_load(b->v[i][1]),
                    z = f32x8_load(b->v[i][2]);
        for (int k = 0; k < 3; k++)
            f32x8_store(world[of->mirrored ? (3 - i) % 3 : i][k],
                        m[k][0] * x + m[k][1] * y + m[k][2] * z + m[k][3]);
    }
    lanes_make(&q->tri, (const float(*)[3][STAGE_LANES])world, out);
}

/* The nearer one, among equals the one with the smaller number. */
static inline bool is_nearer(const struct best *best, float t, uint32_t prim)
{
    return t < best->t || (t == best->t && prim < best->prim);
}

/* Lane by lane what lanes_make has left. any: the first hit will do. True: it has been found. */
static inline __attribute__((always_inline)) bool
lanes_hit(const struct query *q, const struct space *space, const struct stage_block *b,
          const struct lanes *lanes, bool any, bool instanced, struct best *best)
{
    for (uint32_t met = lanes->met; met; met &= met - 1) {
        const uint32_t lane = (uint32_t)__builtin_ctz(met);
        const uint32_t index = STAGE_LANES * (uint32_t)(b - q->blocks) + lane;
        const struct stage_triangle tri =
            instanced ? stage_triangle_at(q->stage, index, space->instance)
                      : stage_block_lane(b, lane);
        const bool doubt = __builtin_expect(lanes->doubt >> lane & 1, 0);
        float t;
        if (doubt && !tri_meets(tri_edges_make(&q->tri, &tri)))
            continue;
        if (!(instanced ? instance_triangle_hit(q, space, index, &tri, &t)
                        : triangle_hit(q, &tri, &t)))
            continue;
        if (any)
            return true;
        const uint32_t prim = space->prim_begin + b->prim[lane];
        if (!is_nearer(best, t, prim))
            continue;
        best->t = t;
        best->prim = prim;
        best->place = (struct stage_place){STAGE_TRIANGLE, index & 0x1fffffff};
        best->instance = space->instance;
        best->edges = doubt ? tri_edges_make(&q->tri, &tri)
                            : (struct tri_edges){lanes->e[0][lane], lanes->e[1][lane],
                                                 lanes->e[2][lane]};
    }
    return false;
}

static inline __attribute__((always_inline)) bool
block_hit(const struct query *q, const struct space *space, const struct stage_block *b, bool any,
          bool instanced, struct best *best)
{
    struct lanes lanes;
    if (instanced)
        lanes_make_in_instance(q, b, space->instance, &lanes);
    else
        lanes_make(&q->tri, b->v, &lanes);
    if (!lanes.met)
        return false;
    if (!instanced)
        lanes.met &= ~lanes_beyond(q, b, best->t);
    return lanes_hit(q, space, b, &lanes, any, instanced, best);
}

static bool round_ref_hit(const struct query *q, uint32_t ref, bool any, struct best *best)
{
    const struct stage_place place = {(bvh_ref_kind(ref) - BVH_BLOCK) & 7,
                                      bvh_ref_index(ref) & 0x1fffffff};
    float t;
    uint32_t prim;
    if (!round_hit(q, place, &t, &prim))
        return false;
    if (!any && is_nearer(best, t, prim))
        *best = (struct best){t, prim, {1, 0, 0}, place, STAGE_NONE};
    return any;
}

/* --- the walk --- */

static inline void order(entry *a, entry *b)
{
    const entry x = *a, y = *b;
    *a = x < y ? x : y;
    *b = x < y ? y : x;
}

/* Its data, before they are needed: they come from far away in a large scene. (For what is neither node
 * nor block, some other data: a prefetch may fail.) */
static inline void fetch(const struct query *q, uint32_t ref)
{
    const unsigned char *at = data_at(q, ref);
    for (int line = 0; line < BVH_NODE_LINES; line += 2) /* the one beside it comes along */
        __builtin_prefetch(at + BVH_LINE * line);
}

/* The nearest child is returned to go on with, the others wait on the stack, the nearer above. One or
 * two are the rule: for them there is nothing to mispredict but the number. */
static inline __attribute__((always_inline)) uint32_t nearest_child(const struct query *q, const struct bvh_node *node,
                                     uint32_t hits, f32x8 near, entry *stack, uint32_t *waiting)
{
    uint32_t i = (uint32_t)__builtin_ctz(hits);
    hits &= hits - 1;
    if (!hits)
        return node->child[i];
    _Alignas(32) uint32_t t[BVH_WIDTH];
    f32x8_store_bits(t, near);
    entry first = entry_make(t[i], node->child[i]);
    i = (uint32_t)__builtin_ctz(hits);
    hits &= hits - 1;
    entry second = entry_make(t[i], node->child[i]);
    order(&first, &second);
    fetch(q, (uint32_t)second);
    uint32_t top = *waiting;
    const uint32_t bottom = top;
    stack[top++] = second;
    while (hits) {
        i = (uint32_t)__builtin_ctz(hits);
        hits &= hits - 1;
        entry next = entry_make(t[i], node->child[i]);
        order(&first, &next);
        fetch(q, (uint32_t)next);
        uint32_t at = top++;
        for (; at > bottom && stack[at - 1] < next; at--)
            stack[at] = stack[at - 1];
        stack[at] = next;
    }
    *waiting = top;
    return (uint32_t)first;
}

static bool instance_hit(const struct query *, const struct space *world, uint32_t instance,
                         bool any, struct best *);

/* any: the first hit will do, in no order. True: it has been found. Inlined, so that there is one loop for
 * each answer. */
static inline __attribute__((always_inline)) bool walk(const struct query *q, const struct space *space, uint32_t ref, bool any,
                        bool instanced, struct best *best)
{
    const struct box8_wide wide = box8_widen(&space->box);
    entry stack[BVH_STACK];
    uint32_t waiting = 0;
    for (;;) {
        while (bvh_ref_kind(ref) == BVH_NODE) {
            const struct bvh_node *node = data_at(q, ref);
            f32x8 near, far;
            uint32_t hits =
                box8_hit(&space->box, &wide, node->plane, best->t, &near, &far) & node->used;
            if (!hits)
                goto next;
            if (!any) {
                ref = nearest_child(q, node, hits, near, stack, &waiting);
                continue;
            }
            ref = node->child[__builtin_ctz(hits)];
            for (hits &= hits - 1; hits; hits &= hits - 1) {
                const uint32_t other = node->child[__builtin_ctz(hits)];
                fetch(q, other);
                stack[waiting++] = other;
            }
        }
        if (bvh_ref_kind(ref) == BVH_BLOCK) {
            if (block_hit(q, space, data_at(q, ref), any, instanced, best))
                return true;
        } else if (instanced) {
            __builtin_unreachable(); /* a shared mesh has only triangles */
        } else if (bvh_ref_kind(ref) == BVH_INSTANCE) {
            if (instance_hit(q, space, bvh_ref_index(ref), any, best))
                return true;
        } else if (round_ref_hit(q, ref, any, best)) {
            return true;
        }
    next:; /* boxes as near as the best hit are still opened: an equal hit may have a smaller number */
        const entry limit = any ? UINT64_MAX : entry_limit(best->t);
        do {
            if (!waiting)
                return false;
        } while (stack[--waiting] > limit);
        ref = (uint32_t)stack[waiting];
    }
}

static __attribute__((noinline)) bool instance_hit(const struct query *q, const struct space *world,
                                                   uint32_t instance, bool any, struct best *best)
{
    struct space space;
    if (!space_make(q, world, instance, &space))
        return false;
    const uint32_t root = root_of(q->stage, stage_instance_at(q->stage, instance)->tree);
    return any ? walk(q, &space, root, true, true, best) : walk(q, &space, root, false, true, best);
}

bool bvh_hit_closest(const struct stage *s, const struct ray *ray, struct ray_hit *hit)
{
    struct query q;
    struct space world;
    const uint32_t root = root_of(s, 0);
    if (root == bvh_ref_make(BVH_NOTHING, 0) || !query_make(s, ray, &q))
        return false;
    world_make(&q, &world);
    struct best best = {.t = q.t_max, .prim = STAGE_NONE};
    walk(&q, &world, root, false, false, &best);
    if (best.prim == STAGE_NONE)
        return false;
    *hit = (struct ray_hit){best.t, best.prim, 0, 0, best.place, best.instance};
    tri_weights(best.edges, &hit->u, &hit->v);
    return true;
}

bool bvh_hit_any(const struct stage *s, const struct ray *ray)
{
    struct query q;
    struct space world;
    const uint32_t root = root_of(s, 0);
    if (root == bvh_ref_make(BVH_NOTHING, 0) || !query_make(s, ray, &q))
        return false;
    world_make(&q, &world);
    struct best best = {.t = q.t_max, .prim = STAGE_NONE};
    return walk(&q, &world, root, true, false, &best);
}
