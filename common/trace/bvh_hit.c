/* Traversal. What a hit is stands in bvh_prim.h; here none must be lost.
 * SPDX-License-Identifier: MIT */
#include "common/trace/bvh_prim.h"

/* The nearest hit so far; what only the last one is asked for is not computed yet. */
struct best {
    float t;
    uint32_t prim;
    struct tri_edges edges; /* of a triangle */
    struct stage_place place;
    uint32_t instance;
};

/* What waits on the stack: where the ray enters a child's box, in the upper half, and its
 * reference. For numbers that are not negative the order of floats is that of their bits. */
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

static inline uint32_t root_of(const struct stage *s, uint32_t tree)
{
    return ((const struct stage_tree *)stage_at(s, s->trees))[tree].root;
}

/* --- a leaf --- */

struct lanes {                            /* of a block */
    _Alignas(32) float e[3][STAGE_LANES]; /* when any is met */
    uint32_t met;                         /* bit i: tri_meets holds, or may hold */
    uint32_t doubt; /* of those: an edge function is 0, so that the exact one must decide; or NaN */
};

/* A node or a block. */
static inline const void *data_at(const struct bvh_query *q, uint32_t ref)
{
    return q->first + (size_t)BVH_LINE * bvh_ref_index(ref);
}

/* Eight triangles by the arithmetic of tri_edges_make, operation by operation. */
static inline __attribute__((always_inline)) void
lanes_make(const struct tri_ray *r, const float (*v)[3][STAGE_LANES], struct lanes *out)
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

/* Lanes whose hit, which lies within their triangle's own box (settle), cannot lie within (0,
 * t_max], as the axis in which the ray is longest shows: box_hit's error is 10 u of the reach
 * there, and 5 u are its roundings and those made here. For triangles of the world. A NaN keeps its
 * lane. */
static inline uint32_t lanes_beyond(const struct bvh_query *q, const struct stage_block *b,
                                    float t_max)
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
static __attribute__((noinline)) void lanes_make_in_instance(const struct bvh_query *q,
                                                             const struct stage_block *b,
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
lanes_hit(const struct bvh_query *q, const struct bvh_space *space, const struct stage_block *b,
          const struct lanes *lanes, bool any, bool instanced, struct best *best)
{
    for (uint32_t met = lanes->met; met; met &= met - 1) {
        const uint32_t lane = (uint32_t)__builtin_ctz(met);
        const uint32_t index = STAGE_LANES * (uint32_t)(b - q->blocks) + lane;
        const struct stage_triangle tri = instanced
                                              ? stage_triangle_at(q->stage, index, space->instance)
                                              : stage_block_lane(b, lane);
        const bool doubt = __builtin_expect(lanes->doubt >> lane & 1, 0);
        float t;
        if (doubt && !tri_meets(tri_edges_make(&q->tri, &tri)))
            continue;
        if (!(instanced ? bvh_prim_in_instance(q, space, index, &tri, &t)
                        : bvh_prim_triangle(q, &tri, &t)))
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
        best->edges =
            doubt ? tri_edges_make(&q->tri, &tri)
                  : (struct tri_edges){lanes->e[0][lane], lanes->e[1][lane], lanes->e[2][lane]};
    }
    return false;
}

static inline __attribute__((always_inline)) bool block_hit(const struct bvh_query *q,
                                                            const struct bvh_space *space,
                                                            const struct stage_block *b, bool any,
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

static bool round_ref_hit(const struct bvh_query *q, uint32_t ref, bool any, struct best *best)
{
    const struct stage_place place = {(bvh_ref_kind(ref) - BVH_BLOCK) & 7,
                                      bvh_ref_index(ref) & 0x1fffffff};
    float t;
    uint32_t prim;
    if (!bvh_prim_round(q, place, &t, &prim))
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

/* Its data, before they are needed: they come from far away in a large scene. (For what is neither
 * node nor block, some other data: a prefetch may fail.) */
static inline void fetch(const struct bvh_query *q, uint32_t ref)
{
    const unsigned char *at = data_at(q, ref);
    for (int line = 0; line < BVH_NODE_LINES; line += 2) /* the one beside it comes along */
        __builtin_prefetch(at + BVH_LINE * line);
}

/* The nearest child is returned to go on with, the others wait on the stack, the nearer above. One
 * or two are the rule: for them there is nothing to mispredict but the number. */
static inline __attribute__((always_inline)) uint32_t nearest_child(const struct bvh_query *q,
                                                                    const struct bvh_node *node,
                                                                    uint32_t hits, f32x8 near,
                                                                    entry *stack, uint32_t *waiting)
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

static bool instance_hit(const struct bvh_query *, const struct bvh_space *world, uint32_t instance,
                         bool any, struct best *);

/* any: the first hit will do, in no order. True: it has been found. Inlined, so that there is one
 * loop for each answer. */
static inline __attribute__((always_inline)) bool walk(const struct bvh_query *q,
                                                       const struct bvh_space *space, uint32_t ref,
                                                       bool any, bool instanced, struct best *best)
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
    next:; /* boxes as near as the best hit are still opened: an equal hit may have a smaller number
            */
        const entry limit = any ? UINT64_MAX : entry_limit(best->t);
        do {
            if (!waiting)
                return false;
        } while (stack[--waiting] > limit);
        ref = (uint32_t)stack[waiting];
    }
}

static __attribute__((noinline)) bool instance_hit(const struct bvh_query *q,
                                                   const struct bvh_space *world, uint32_t instance,
                                                   bool any, struct best *best)
{
    struct bvh_space space;
    if (!bvh_space_make(q, world, instance, &space))
        return false;
    const uint32_t root = root_of(q->stage, stage_instance_at(q->stage, instance)->tree);
    return any ? walk(q, &space, root, true, true, best) : walk(q, &space, root, false, true, best);
}

/* In the world. True: something has been found. */
static inline __attribute__((always_inline)) bool ask(const struct stage *s, const struct ray *ray,
                                                      bool any, struct best *best)
{
    struct bvh_query q;
    struct bvh_space world;
    const uint32_t root = root_of(s, 0);
    if (root == bvh_ref_make(BVH_NOTHING, 0) || !bvh_query_make(s, ray, &q))
        return false;
    bvh_world_make(&q, &world);
    *best = (struct best){.t = q.t_max, .prim = STAGE_NONE};
    return walk(&q, &world, root, any, false, best) || best->prim != STAGE_NONE;
}

bool bvh_hit_closest(const struct stage *s, const struct ray *ray, struct ray_hit *hit)
{
    struct best best;
    if (!ask(s, ray, false, &best))
        return false;
    *hit = (struct ray_hit){best.t, best.prim, 0, 0, best.place, best.instance};
    tri_weights(best.edges, &hit->u, &hit->v);
    return true;
}

bool bvh_hit_any(const struct stage *s, const struct ray *ray)
{
    struct best best;
    return ask(s, ray, true, &best);
}
