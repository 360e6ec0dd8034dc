/* Traversal. What a hit is stands in bvh_prim.h; here none must be lost.
 * SPDX-License-Identifier: MIT */
#include "common/trace/bvh_prim.h"

/* The nearest hit so far; what only the last one is asked for is not computed yet. */
struct best {
    float t;
    uint32_t prim;
    vec3 edges; /* struct tri_edges of a triangle, written and read as one */
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
    _Alignas(32) float e[3][STAGE_LANES]; /* tri_edges */
    uint32_t met;                         /* bit i: tri_meets may hold, and t be in (0, t_max] */
};

/* A node or a block. */
static inline const void *data_at(const struct bvh_query *q, uint32_t ref)
{
    return q->first + (size_t)BVH_LINE * bvh_ref_index(ref);
}

/* Lanes whose hit, which lies within their triangle's own box (settle), cannot lie within (0,
 * t_max], as the axis in which the ray is longest shows: box_hit's error is 10 u of the reach
 * there, and 5 u are its roundings and those made here. For triangles of the world; az, bz, cz:
 * the vertices from the origin along that axis. A NaN keeps its lane. */
static inline uint32_t lanes_beyond(const struct tri_ray *r, f32x8 az, f32x8 bz, f32x8 cz,
                                    float t_max)
{
    const f32x8 inv = f32x8_splat(r->shear[3]);
    const f32x8 t0 = az * inv, t1 = bz * inv, t2 = cz * inv;
    const f32x8 least = f32x8_min(t0, f32x8_min(t1, t2)), most = f32x8_max(t0, f32x8_max(t1, t2));
    const float room = 16 * ROUND_UNIT;
    return i32x8_mask((most < room * least) | (least - room * most > f32x8_splat(t_max)));
}

/* Eight triangles by the arithmetic of tri_edges_make, operation by operation, but for edge
 * functions that are 0. False: none is met; then the edges are not written. */
static inline __attribute__((always_inline)) bool lanes_make(const struct tri_ray *r,
                                                             const float (*v)[3][STAGE_LANES],
                                                             float t_max, struct lanes *out)
{
    const float *px = v[0][0] + (uint32_t)r->row[0], *py = v[0][0] + (uint32_t)r->row[1],
                *pz = v[0][0] + (uint32_t)r->row[2];
    const size_t next = sizeof v[0] / sizeof *px; /* vertex */
    const f32x8 ox = f32x8_splat(r->at[0]), oy = f32x8_splat(r->at[1]), oz = f32x8_splat(r->at[2]);
    const f32x8 sx = f32x8_splat(r->shear[0]), sy = f32x8_splat(r->shear[1]);
    const f32x8 az = f32x8_load(pz) - oz;
    const f32x8 ax = (f32x8_load(px) - ox) - sx * az;
    const f32x8 ay = (f32x8_load(py) - oy) - sy * az;
    const f32x8 bz = f32x8_load(pz + next) - oz;
    const f32x8 bx = (f32x8_load(px + next) - ox) - sx * bz;
    const f32x8 by = (f32x8_load(py + next) - oy) - sy * bz;
    const f32x8 cz = f32x8_load(pz + 2 * next) - oz;
    const f32x8 cx = (f32x8_load(px + 2 * next) - ox) - sx * cz;
    const f32x8 cy = (f32x8_load(py + 2 * next) - oy) - sy * cz;
    const f32x8 e0 = cx * by - cy * bx, e1 = ax * cy - ay * cx, e2 = bx * ay - by * ax;
    const f32x8 least = f32x8_min(e0, f32x8_min(e1, e2)), most = f32x8_max(e0, f32x8_max(e1, e2));
    const f32x8 none = {0};
    out->met = i32x8_mask((least >= none) | (most <= none));
    if (!out->met)
        return false;
    out->met &= ~lanes_beyond(r, az, bz, cz, t_max);
    if (!out->met)
        return false;
    f32x8_store(out->e[0], e0);
    f32x8_store(out->e[1], e1);
    f32x8_store(out->e[2], e2);
    return true;
}

/* An edge function that is 0 is made exactly; who gets here by a NaN or without need finds what
 * lanes_make had. False: the triangle is not met. */
static __attribute__((noinline)) bool lane_edges_exact(const struct bvh_query *q, uint32_t index,
                                                       uint32_t instance, struct tri_edges *e)
{
    const struct stage_triangle tri = stage_triangle_at(q->stage, index, instance);
    *e = tri_edges_make(&q->tri, &tri);
    return tri_meets(*e);
}

/* Whether a lane's triangle is met, and its edge functions. */
static inline bool lane_edges(const struct bvh_query *q, const struct lanes *lanes, uint32_t index,
                              uint32_t instance, struct tri_edges *e)
{
    const uint32_t lane = index % STAGE_LANES;
    *e = (struct tri_edges){lanes->e[0][lane], lanes->e[1][lane], lanes->e[2][lane]};
    const float all = e->e0 * e->e1 * e->e2;
    return __builtin_expect(all < 0 || all > 0, 1) || lane_edges_exact(q, index, instance, e);
}

/* Of a triangle of the world; all out of the loop's way. */
static __attribute__((noinline)) float lane_t(const struct bvh_query *q,
                                              const struct stage_block *b, uint32_t lane)
{
    const struct stage_triangle tri = stage_block_lane(b, lane);
    return bvh_prim_triangle(q, &tri);
}

/* The nearer one, among equals the one with the smaller number. */
static inline bool is_nearer(const struct best *best, float t, uint32_t prim)
{
    return t < best->t || (t == best->t && prim < best->prim);
}

/* The same of a mesh inside an instance, its vertices as xform_point makes them. */
static __attribute__((noinline)) bool lanes_make_in_instance(const struct bvh_query *q,
                                                             const struct stage_block *b,
                                                             uint32_t instance, float t_max,
                                                             struct lanes *out)
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
    return lanes_make(&q->tri, (const float(*)[3][STAGE_LANES])world, t_max, out);
}

static __attribute__((noinline)) float
lane_t_in_instance(const struct bvh_query *q, const struct bvh_space *inside, uint32_t index)
{
    const struct stage_triangle tri = stage_triangle_at(q->stage, index, inside->instance);
    return bvh_prim_in_instance(q, inside, index, &tri);
}

/* inside: NULL in the world. any: the first hit will do. True: it has been found. */
static inline __attribute__((always_inline)) bool
block_hit(const struct bvh_query *q, const struct bvh_space *inside, const struct stage_block *b,
          bool any, struct best *best)
{
    struct lanes lanes;
    if (!(inside ? lanes_make_in_instance(q, b, inside->instance, best->t, &lanes)
                 : lanes_make(&q->tri, b->v, best->t, &lanes)))
        return false;
    for (uint32_t met = lanes.met; met; met &= met - 1) {
        const uint32_t lane = (uint32_t)__builtin_ctz(met);
        const uint32_t index = STAGE_LANES * (uint32_t)(b - q->blocks) + lane;
        const uint32_t instance = inside ? inside->instance : STAGE_NONE;
        const float t = inside ? lane_t_in_instance(q, inside, index) : lane_t(q, b, lane);
        if (!(t > 0))
            continue;
        const uint32_t prim = b->prim[lane] + (inside ? inside->prim_begin : 0);
        struct tri_edges e;
        if ((!any && !is_nearer(best, t, prim)) || !lane_edges(q, &lanes, index, instance, &e))
            continue;
        *best = (struct best){t, prim, {e.e0, e.e1, e.e2}, {STAGE_TRIANGLE, index & 0x1fffffff}, instance};
        if (any)
            return true;
    }
    return false;
}

static bool round_ref_hit(const struct bvh_query *q, uint32_t ref, bool any, struct best *best)
{
    const struct stage_place place = {(bvh_ref_kind(ref) - BVH_BLOCK) & 7,
                                      bvh_ref_index(ref) & 0x1fffffff};
    uint32_t prim;
    const float t = bvh_prim_round(q, place, &prim);
    if (!(t > 0) || (!any && !is_nearer(best, t, prim)))
        return false;
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

static bool instance_hit(const struct bvh_query *, const struct box8_ray *world, uint32_t instance,
                         bool any, struct best *);

/* inside: the instance whose tree it is, or NULL. any: the first hit will do, in no order. True: it
 * has been found. Inlined, so that there is one loop for each answer. */
static inline __attribute__((always_inline)) bool walk(const struct bvh_query *q,
                                                       const struct box8_ray *box,
                                                       const struct bvh_space *inside, uint32_t ref,
                                                       bool any, struct best *best)
{
    entry stack[BVH_STACK];
    uint32_t waiting = 0;
    for (;;) {
        while (ref < bvh_ref_make(BVH_NODE + 1, 0)) {
            const struct bvh_node *node = data_at(q, ref);
            f32x8 near, far;
            uint32_t hits = box8_hit(box, node->plane, best->t, &near, &far) & node->used;
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
            if (block_hit(q, inside, data_at(q, ref), any, best))
                return true;
        } else if (inside) {
            __builtin_unreachable(); /* a shared mesh has only triangles */
        } else if (bvh_ref_kind(ref) == BVH_INSTANCE) {
            if (instance_hit(q, box, bvh_ref_index(ref), any, best))
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
                                                   const struct box8_ray *world, uint32_t instance,
                                                   bool any, struct best *best)
{
    struct bvh_space space;
    if (!bvh_space_make(q, world, instance, &space))
        return false;
    const uint32_t root = root_of(q->stage, stage_instance_at(q->stage, instance)->tree);
    return any ? walk(q, &space.box, &space, root, true, best)
               : walk(q, &space.box, &space, root, false, best);
}

/* In the world. True: something has been found. */
static inline __attribute__((always_inline)) bool
ask(const struct bvh_query *q, const struct box8_ray *world, uint32_t root, bool any,
    struct best *best)
{
    best->t = q->t_max;
    best->prim = STAGE_NONE;
    return walk(q, world, NULL, root, any, best) || best->prim != STAGE_NONE;
}

static inline void tell(const struct best *best, struct ray_hit *hit)
{
    *hit = (struct ray_hit){best->t, best->prim, 0, 0, best->place, best->instance};
    const vec3 e = best->edges;
    tri_weights((struct tri_edges){e[0], e[1], e[2]}, &hit->u, &hit->v);
}

bool bvh_hit_closest(const struct stage *s, const struct ray *ray, struct ray_hit *hit)
{
    struct bvh_query q;
    struct box8_ray world;
    struct best best;
    const uint32_t root = root_of(s, 0);
    if (root == bvh_ref_make(BVH_NOTHING, 0) || !bvh_query_make(s, ray, &q, &world) ||
        !ask(&q, &world, root, false, &best))
        return false;
    tell(&best, hit);
    return true;
}

bool bvh_hit_any(const struct stage *s, const struct ray *ray)
{
    struct bvh_query q;
    struct box8_ray world;
    struct best best;
    const uint32_t root = root_of(s, 0);
    return root != bvh_ref_make(BVH_NOTHING, 0) && bvh_query_make(s, ray, &q, &world) &&
           ask(&q, &world, root, true, &best);
}

/* --- up to eight --- */

struct batch { /* made ready at once */
    struct bvh_query query;
    struct box8_ray world;
    struct tri_rays tri;
    struct box8_rays box;
};

static void batch_init(struct batch *b, const struct stage *s, const struct ray rays[],
                       uint32_t count)
{
    vec3 origin[8], dir[8];
    f32x8 o[3], d[3];
    for (uint32_t i = 0; i < 8; i++) {
        const struct ray *ray = &rays[i < count ? i : 0];
        origin[i] = ray->origin;
        dir[i] = ray->dir;
    }
    f32x8_columns(origin, o);
    f32x8_columns(dir, d);
    tri_rays_make(o, d, &b->tri);
    box8_rays_init(&b->box, o, d);
    b->query.stage = s;
    b->query.first = stage_at(s, s->nodes);
    b->query.blocks = stage_at(s, s->blocks);
}

/* False: nothing can be hit. */
static inline bool batch_go(struct batch *b, const struct ray *ray, uint32_t i)
{
    b->query.tri =
        (struct tri_ray){ray->origin, ray->dir, b->tri.row[i], b->tri.at[i], b->tri.shear[i]};
    b->query.t_max = ray->t_max < FLT_MAX ? ray->t_max : FLT_MAX;
    box8_rays_take(&b->box, i, &b->world);
    return bvh_is_ray(ray) && b->query.tri.shear[2] == 1;
}

uint32_t bvh_hit_closest_8(const struct stage *s, const struct ray rays[], uint32_t count,
                           struct ray_hit hits[])
{
    const uint32_t root = root_of(s, 0);
    struct batch b;
    struct best best;
    uint32_t found = 0;
    if (root == bvh_ref_make(BVH_NOTHING, 0))
        return 0;
    batch_init(&b, s, rays, count);
    for (uint32_t i = 0; i < count; i++) {
        if (!batch_go(&b, &rays[i], i) || !ask(&b.query, &b.world, root, false, &best))
            continue;
        tell(&best, &hits[i]);
        found |= 1u << i;
    }
    return found;
}

uint32_t bvh_hit_any_8(const struct stage *s, const struct ray rays[], uint32_t count)
{
    const uint32_t root = root_of(s, 0);
    struct batch b;
    struct best best;
    uint32_t found = 0;
    if (root == bvh_ref_make(BVH_NOTHING, 0))
        return 0;
    batch_init(&b, s, rays, count);
    for (uint32_t i = 0; i < count; i++)
        if (batch_go(&b, &rays[i], i) && ask(&b.query, &b.world, root, true, &best))
            found |= 1u << i;
    return found;
}
