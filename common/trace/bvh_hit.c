/* Traversal: A. Fuetterling et al., "Accelerated Single Ray Tracing for Wide Vector Units", HPG 2017,
 * for its ideas of order; the loop is the plain one. SPDX-License-Identifier: MIT */
#include "common/trace/bvh.h"

#include <float.h>

#include "common/trace/box.h"
#include "common/trace/box8.h"
#include "common/trace/sphere.h"
#include "common/trace/tri.h"

/* What does not change along the way of one ray. */
struct query {
    const struct stage *stage;
    const struct bvh_node *nodes;
    const struct stage_block *blocks;
    const struct ray *ray;
    struct tri_ray tri;
    float t_max; /* the ray's, finite */
};

/* The tree that is walked: the world's (instance STAGE_NONE) or an instance's in its space. */
struct space {
    struct box8_ray box;
    uint32_t instance;
    uint32_t prim_begin; /* what a block's numbers count from */
    float t[2];          /* where the ray enters and leaves the instance's box in the world */
};

struct entry { /* of the stack */
    uint32_t ref;
    float t; /* where the ray enters its box */
};

static bool is_finite(vec3 v)
{
    const vec3 zero = v - v; /* NaN for an infinity, too */
    return zero[0] == 0 && zero[1] == 0 && zero[2] == 0;
}

/* False when nothing can be hit: no tree, or a ray that is no ray. */
static inline bool query_make(const struct stage *s, const struct ray *ray, struct query *q)
{
    if (!is_finite(ray->origin) || !is_finite(ray->dir) || !(ray->t_max > 0) ||
        rgb_is_black(ray->dir))
        return false;
    q->stage = s;
    q->nodes = stage_at(s, s->nodes);
    q->blocks = stage_at(s, s->blocks);
    q->ray = ray;
    q->tri = tri_ray_make(ray);
    q->t_max = ray->t_max < FLT_MAX ? ray->t_max : FLT_MAX;
    return true;
}

static inline void world_make(const struct query *q, struct space *w)
{
    w->box = box8_ray_make(q->ray->origin, q->ray->dir, box8_error(q->ray->origin));
    w->instance = STAGE_NONE;
    w->prim_begin = 0;
    w->t[0] = 0;
    w->t[1] = FLT_MAX;
}

static inline const struct stage_tree *tree_at(const struct query *q, uint32_t i)
{
    return (const struct stage_tree *)stage_at(q->stage, q->stage->trees) + i;
}

static uint32_t root_of(const struct query *q, uint32_t instance)
{
    return tree_at(q, stage_instance_at(q->stage, instance)->tree)->root;
}

/* One box alone, by the test of eight. */
static bool box_alone(const struct box8_ray *r, const float lo[3], const float hi[3], float t[2])
{
    _Alignas(32) float plane[BOX8_PLANES][8] = {{0}};
    box8_store(plane, 0, lo, hi);
    f32x8 near, far;
    const uint32_t hits = box8_hit(r, (const float(*)[8])plane, FLT_MAX, &near, &far);
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
    if (!box_alone(&world->box, of->lo, of->hi, space->t))
        return false;
    vec3 origin = {0}, dir = {0};
    for (int k = 0; k < 3; k++) {
        const double *m = of->to_object[k];
        double o = m[3], d = 0;
        for (int j = 0; j < 3; j++) {
            o += m[j] * (double)q->ray->origin[j];
            d += m[j] * (double)q->ray->dir[j];
        }
        origin[k] = (float)o;
        dir[k] = (float)d;
    }
    const float lo = box8_reach(vec3_load(of->lo)), hi = box8_reach(vec3_load(of->hi));
    const float error = BOX8_PAD * ((lo > hi ? lo : hi) + box8_reach(q->ray->origin));
    space->box = box8_ray_make(origin, dir, box8_error(origin) + error * vec3_load(of->spread));
    space->instance = instance;
    space->prim_begin = of->prim_begin;
    return true;
}

/* --- one primitive --- */

/* A hit lies between where the ray enters the primitive's own box and where it leaves it. Rounding could
 * place it before, and then a tree that skips boxes behind the nearest hit would find one or the
 * other of two near hits as its shape has it; a grazing ray's, far beside the primitive. */
static inline bool settle(const struct query *q, float t, const float own[2], struct ray_hit *hit)
{
    hit->t = t < own[0] ? own[0] : t > own[1] ? own[1] : t;
    return hit->t > 0 && hit->t < q->t_max;
}

static inline bool settle_in_world(const struct query *q, float t, const float lo[3],
                                   const float hi[3], struct ray_hit *hit)
{
    const struct box_ray box = box_ray_make(q->ray);
    float own[2];
    return box_hit(&box, lo, hi, FLT_MAX, own) && settle(q, t, own, hit);
}

/* In object space a triangle has its own box, too: the one that the nodes above are made of. */
static bool settle_in_object(const struct query *q, const struct space *space, float t,
                             uint32_t index, struct ray_hit *hit)
{
    const struct stage_triangle tri = stage_triangle_at(q->stage, index, STAGE_NONE);
    float lo[3], hi[3], own[2];
    tri_bounds(tri.v, lo, hi);
    if (!box_alone(&space->box, lo, hi, own))
        return false;
    own[0] = own[0] > space->t[0] ? own[0] : space->t[0];
    own[1] = own[1] < space->t[1] ? own[1] : space->t[1];
    return own[0] <= own[1] && settle(q, t, own, hit);
}

static inline bool triangle_hit(const struct query *q, const struct space *space, uint32_t index,
                                struct ray_hit *hit)
{
    const struct stage_triangle tri = stage_triangle_at(q->stage, index, space->instance);
    struct tri_found f;
    if (!tri_hit(&q->tri, tri.v, &f))
        return false;
    hit->u = f.u;
    hit->v = f.v;
    if (space->instance != STAGE_NONE)
        return settle_in_object(q, space, f.t, index, hit);
    float lo[3], hi[3];
    tri_bounds(tri.v, lo, hi);
    return settle_in_world(q, f.t, lo, hi, hit);
}

static bool round_hit(const struct query *q, struct stage_place place, struct ray_hit *hit)
{
    const float *center = NULL;
    float radius = 0, t = 0;
    hit->u = hit->v = 0;
    switch ((enum stage_kind)place.kind) {
    case STAGE_SPHERE: {
        const struct stage_sphere *s =
            (const struct stage_sphere *)stage_at(q->stage, q->stage->spheres) + place.index;
        if (!sphere_hit(q->ray, s, &t))
            return false;
        center = s->center;
        radius = s->radius;
        hit->prim = s->prim;
        break;
    }
    case STAGE_DISC: {
        const struct stage_disc *s =
            (const struct stage_disc *)stage_at(q->stage, q->stage->discs) + place.index;
        if (!sphere_disc_hit(q->ray, s, &t))
            return false;
        center = s->center;
        radius = s->radius;
        hit->prim = s->prim;
        break;
    }
    case STAGE_TRIANGLE:
    case STAGE_KINDS:
        __builtin_unreachable();
    }
    float lo[3], hi[3];
    sphere_bounds(center, radius, lo, hi);
    return settle_in_world(q, t, lo, hi, hit);
}

bool bvh_hit_prim(const struct stage *s, const struct ray *ray, struct ray_hit *hit)
{
    struct query q;
    struct space world, inner;
    if (!query_make(s, ray, &q))
        return false;
    if (hit->place.kind != STAGE_TRIANGLE)
        return round_hit(&q, hit->place, hit);
    world_make(&q, &world);
    if (hit->instance == STAGE_NONE)
        return triangle_hit(&q, &world, hit->place.index, hit);
    return space_make(&q, &world, hit->instance, &inner) &&
           triangle_hit(&q, &inner, hit->place.index, hit);
}

/* --- a leaf --- */

/* Eight triangles by the arithmetic of tri_hit, operation by operation: bit i is clear only when
 * tri_hit would refuse lane i. */
static inline uint32_t inside_lanes(const struct tri_ray *r, const float (*v)[3][STAGE_LANES])
{
    f32x8 x[3], y[3];
    for (int i = 0; i < 3; i++) {
        const f32x8 z = f32x8_load(v[i][r->kz]) - r->origin[r->kz];
        x[i] = (f32x8_load(v[i][r->kx]) - r->origin[r->kx]) - r->sx * z;
        y[i] = (f32x8_load(v[i][r->ky]) - r->origin[r->ky]) - r->sy * z;
    }
    const f32x8 e0 = x[2] * y[1] - y[2] * x[1];
    const f32x8 e1 = x[0] * y[2] - y[0] * x[2];
    const f32x8 e2 = x[1] * y[0] - y[1] * x[0];
    const f32x8 least = f32x8_min(e0, f32x8_min(e1, e2)), most = f32x8_max(e0, f32x8_max(e1, e2));
    return i32x8_mask((least >= 0) | (most <= 0));
}

/* The vertices as xform_point makes them. */
static uint32_t inside_lanes_of_instance(const struct query *q, const struct stage_block *b,
                                         uint32_t instance)
{
    const struct stage_instance *of = stage_instance_at(q->stage, instance);
    const float(*m)[4] = of->to_world.m;
    _Alignas(32) float world[3][3][STAGE_LANES];
    for (int i = 0; i < 3; i++) {
        const f32x8 x = f32x8_load(b->v[i][0]), y = f32x8_load(b->v[i][1]),
                    z = f32x8_load(b->v[i][2]);
        for (int k = 0; k < 3; k++) {
            const f32x8 p = m[k][0] * x + m[k][1] * y + m[k][2] * z + m[k][3];
            memcpy(world[of->mirrored ? (3 - i) % 3 : i][k], &p, sizeof p);
        }
    }
    return inside_lanes(&q->tri, (const float(*)[3][STAGE_LANES])world);
}

static inline uint32_t candidates(const struct query *q, const struct space *space, uint32_t block)
{
    const struct stage_block *b = &q->blocks[block];
    return space->instance == STAGE_NONE ? inside_lanes(&q->tri, b->v)
                                         : inside_lanes_of_instance(q, b, space->instance);
}

/* The nearer one, among equals the one with the smaller number. */
static inline void keep_nearer(struct ray_hit *best, const struct ray_hit *found)
{
    if (found->t < best->t || (found->t == best->t && found->prim < best->prim))
        *best = *found;
}

static inline bool lane_hit(const struct query *q, const struct space *space, uint32_t block,
                            uint32_t lane, struct ray_hit *found)
{
    found->prim = space->prim_begin + q->blocks[block].prim[lane];
    found->place = (struct stage_place){STAGE_TRIANGLE, (STAGE_LANES * block + lane) & 0x1fffffff};
    found->instance = space->instance;
    return triangle_hit(q, space, found->place.index, found);
}

static inline void block_closest(const struct query *q, const struct space *space, uint32_t block,
                                 struct ray_hit *best)
{
    for (uint32_t lanes = candidates(q, space, block); lanes; lanes &= lanes - 1) {
        struct ray_hit found;
        if (lane_hit(q, space, block, (uint32_t)__builtin_ctz(lanes), &found))
            keep_nearer(best, &found);
    }
}

static inline bool block_any(const struct query *q, const struct space *space, uint32_t block)
{
    for (uint32_t lanes = candidates(q, space, block); lanes; lanes &= lanes - 1) {
        struct ray_hit found;
        if (lane_hit(q, space, block, (uint32_t)__builtin_ctz(lanes), &found))
            return true;
    }
    return false;
}

static inline bool round_ref_hit(const struct query *q, uint32_t ref, struct ray_hit *found)
{
    found->place = (struct stage_place){(bvh_ref_kind(ref) - BVH_BLOCK) & 7,
                                        bvh_ref_index(ref) & 0x1fffffff};
    found->instance = STAGE_NONE;
    return round_hit(q, found->place, found);
}

/* --- the walk --- */

/* The nearest child is returned to go on with, the others wait on the stack, the nearer above. */
static inline uint32_t nearest_child(const struct bvh_node *node, uint32_t hits, f32x8 near,
                                     struct entry *stack, int *waiting)
{
    uint32_t i = (uint32_t)__builtin_ctz(hits);
    uint32_t ref = node->child[i];
    hits &= hits - 1;
    if (!hits)
        return ref;
    _Alignas(32) float t[BVH_WIDTH];
    memcpy(t, &near, sizeof t);
    float ref_t = t[i];
    const int bottom = *waiting;
    do {
        i = (uint32_t)__builtin_ctz(hits);
        hits &= hits - 1;
        struct entry e = {node->child[i], t[i]};
        if (e.t < ref_t) {
            const struct entry nearer = e;
            e = (struct entry){ref, ref_t};
            ref = nearer.ref;
            ref_t = nearer.t;
        }
        int at = (*waiting)++;
        for (; at > bottom && stack[at - 1].t < e.t; at--)
            stack[at] = stack[at - 1];
        stack[at] = e;
    } while (hits);
    return ref;
}

static void closest_in(const struct query *q, const struct space *space, uint32_t ref,
                       struct ray_hit *best)
{
    struct entry stack[BVH_STACK];
    int waiting = 0;
    for (;;) {
        while (bvh_ref_kind(ref) == BVH_NODE) {
            const struct bvh_node *node = &q->nodes[ref];
            f32x8 near, far;
            const uint32_t hits =
                box8_hit(&space->box, node->plane, best->t, &near, &far) & node->used;
            if (!hits)
                goto next;
            ref = nearest_child(node, hits, near, stack, &waiting);
        }
        if (bvh_ref_kind(ref) == BVH_BLOCK) {
            block_closest(q, space, bvh_ref_index(ref), best);
        } else if (bvh_ref_kind(ref) == BVH_INSTANCE) {
            struct space inner;
            if (space_make(q, space, bvh_ref_index(ref), &inner))
                closest_in(q, &inner, root_of(q, bvh_ref_index(ref)), best);
        } else {
            struct ray_hit found;
            if (round_ref_hit(q, ref, &found))
                keep_nearer(best, &found);
        }
    next: /* boxes as near as the best hit are still opened: an equal hit may have a smaller number */
        do {
            if (!waiting)
                return;
        } while (!(stack[--waiting].t <= best->t));
        ref = stack[waiting].ref;
    }
}

bool bvh_hit_closest(const struct stage *s, const struct ray *ray, struct ray_hit *hit)
{
    struct query q;
    struct space world;
    if (!query_make(s, ray, &q))
        return false;
    const uint32_t root = tree_at(&q, 0)->root;
    if (root == bvh_ref_make(BVH_NOTHING, 0))
        return false;
    world_make(&q, &world);
    struct ray_hit best = {.t = q.t_max, .prim = STAGE_NONE};
    closest_in(&q, &world, root, &best);
    *hit = best;
    return best.prim != STAGE_NONE;
}

static bool any_in(const struct query *q, const struct space *space, uint32_t ref)
{
    uint32_t stack[BVH_STACK];
    int waiting = 0;
    for (;;) {
        while (bvh_ref_kind(ref) == BVH_NODE) {
            const struct bvh_node *node = &q->nodes[ref];
            f32x8 near, far;
            uint32_t hits = box8_hit(&space->box, node->plane, q->t_max, &near, &far) & node->used;
            if (!hits)
                goto next;
            ref = node->child[__builtin_ctz(hits)];
            for (hits &= hits - 1; hits; hits &= hits - 1)
                stack[waiting++] = node->child[__builtin_ctz(hits)];
        }
        if (bvh_ref_kind(ref) == BVH_BLOCK) {
            if (block_any(q, space, bvh_ref_index(ref)))
                return true;
        } else if (bvh_ref_kind(ref) == BVH_INSTANCE) {
            struct space inner;
            if (space_make(q, space, bvh_ref_index(ref), &inner) &&
                any_in(q, &inner, root_of(q, bvh_ref_index(ref))))
                return true;
        } else {
            struct ray_hit found;
            if (round_ref_hit(q, ref, &found))
                return true;
        }
    next:
        if (!waiting)
            return false;
        ref = stack[--waiting];
    }
}

bool bvh_hit_any(const struct stage *s, const struct ray *ray)
{
    struct query q;
    struct space world;
    if (!query_make(s, ray, &q))
        return false;
    const uint32_t root = tree_at(&q, 0)->root;
    if (root == bvh_ref_make(BVH_NOTHING, 0))
        return false;
    world_make(&q, &world);
    return any_in(&q, &world, root);
}
