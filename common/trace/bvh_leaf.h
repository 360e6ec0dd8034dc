/* bvh_leaf.h - the test of a block of eight triangles, all at once; here none must be lost, what a
 * hit is stands in bvh_prim.h. Private to what walks the hierarchy (bvh_hit.c, bvh_batch.c).
 * SPDX-License-Identifier: MIT */
#ifndef COMMON_TRACE_BVH_LEAF_H
#define COMMON_TRACE_BVH_LEAF_H

#include "common/trace/bvh_prim.h"

/* The nearest hit so far; what only the last one is asked for is not computed yet. */
struct bvh_best {
    float t;
    uint32_t prim;
    vec3 edges; /* struct tri_edges of a triangle, written and read as one */
    struct stage_place place;
    uint32_t instance;
};

struct lanes {                            /* of a block */
    _Alignas(32) float e[3][STAGE_LANES]; /* tri_edges */
    uint32_t met;                         /* bit i: tri_meets may hold, and t be in (0, t_max] */
};

/* A node or a block. */
static inline const void *bvh_data_at(const struct bvh_query *q, uint32_t ref)
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
static inline bool is_nearer(const struct bvh_best *best, float t, uint32_t prim)
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

/* Lanes that are not asked: of the triangles that the ray starts and ends on. */
static inline uint32_t lanes_own(const struct bvh_query *q, const struct stage_block *b,
                                 uint32_t prim_begin)
{
    const struct ray *ray = q->tri.ray;
    const u32x8 prim = u32x8_load(b->prim);
    return i32x8_mask(
        (i32x8)((prim == ray->from - 1 - prim_begin) | (prim == ray->to - 1 - prim_begin)));
}

/* inside: NULL in the world. any: the first hit will do. True: it has been found. */
static inline __attribute__((always_inline)) bool bvh_block_hit(const struct bvh_query *q,
                                                                const struct bvh_space *inside,
                                                                const struct stage_block *b,
                                                                bool any, struct bvh_best *best)
{
    struct lanes lanes;
    if (!(inside ? lanes_make_in_instance(q, b, inside->instance, best->t, &lanes)
                 : lanes_make(&q->tri, b->v, best->t, &lanes)))
        return false;
    const uint32_t prim_begin = inside ? inside->prim_begin : 0;
    for (uint32_t met = lanes.met & ~lanes_own(q, b, prim_begin); met; met &= met - 1) {
        const uint32_t lane = (uint32_t)__builtin_ctz(met);
        const struct stage_block *blocks = stage_at(q->stage, q->stage->blocks);
        const uint32_t index = STAGE_LANES * (uint32_t)(b - blocks) + lane;
        const uint32_t instance = inside ? inside->instance : STAGE_NONE;
        const float t = inside ? lane_t_in_instance(q, inside, index) : lane_t(q, b, lane);
        if (!(t > 0))
            continue;
        const uint32_t prim = b->prim[lane] + prim_begin;
        struct tri_edges e;
        if ((!any && !is_nearer(best, t, prim)) || !lane_edges(q, &lanes, index, instance, &e))
            continue;
        *best = (struct bvh_best){
            t, prim, {e.e0, e.e1, e.e2}, {STAGE_TRIANGLE, index & 0x1fffffff}, instance};
        if (any)
            return true;
    }
    return false;
}

#endif
