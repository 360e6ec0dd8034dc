/* box8.h - ray against the eight boxes of a node at once, for the price of one: bounds that may be
 * a little too wide, never too narrow.
 *
 * What a ray hits is decided by the primitives' own tests (tri.h, sphere.h) and their own boxes
 * (box.h); a node only has to let every such hit through. With u half an ulp of 1, A the box's
 * largest coordinate and O the origin's, both as absolute numbers, a primitive's own test and
 * box err by at most 19 u (A + O) along each axis (box.h: 10 u in the slab, 6 u in the padding of
 * the far distance, 3 u of roundings), the test below by at most 5 u (A + O), for with one fused
 * multiply-subtract per plane, plane / d - origin / d, the quotients round by their own size. So
 * planes are stored moved out by BOX8_PAD A and the ray's part of it, BOX8_PAD O, goes into
 * origin / d once per ray: no operation per node.
 *
 * A direction with a zero, or nearly: the component becomes 2^-40 of the longest one. Over the
 * length of the scene that moves the ray by less than the padding, and all quotients stay finite.
 * Where they do not for the size of the numbers themselves, they are NaN and f32x8_min and _max keep
 * the box.
 *
 * Layout and test: I. Wald et al., "Embree: A Kernel Framework for Efficient CPU Ray Tracing",
 * SIGGRAPH 2014; padding after T. Ize, "Robust BVH Ray Traversal", JCGT 2(2), 2013.
 * SPDX-License-Identifier: MIT */
#ifndef COMMON_TRACE_BOX8_H
#define COMMON_TRACE_BOX8_H

#include "common/trace/ray.h"
#include "common/trace/simd.h"

#define BOX8_PAD 0x1p-19f /* 32 u */

enum { BOX8_PLANES = 6 }; /* low x, y, z, then high x, y, z */

struct box8_ray {
    f32x8 inv[3];         /* 1 / d */
    f32x8 near[3], far[3]; /* origin / d, the origin moved by its error so that a box is met early,
                            * left late */
    uint32_t near_plane[3], far_plane[3];
};

static inline float box8_reach(vec3 v)
{
    const float x = __builtin_fabsf(v[0]), y = __builtin_fabsf(v[1]), z = __builtin_fabsf(v[2]);
    const float xy = x > y ? x : y;
    return xy > z ? xy : z;
}

/* error: of the origin and of everything that goes with it, along each axis. */
static inline struct box8_ray box8_ray_make(vec3 origin, vec3 dir, vec3 error)
{
    struct box8_ray r;
    const float least = 0x1p-40f * box8_reach(dir);
    for (int k = 0; k < 3; k++) {
        const bool back = dir[k] < 0;
        const float d = __builtin_fabsf(dir[k]) < least ? (back ? -least : least) : dir[k];
        const float inv = 1 / d;
        const float at = origin[k] * inv, off = error[k] * __builtin_fabsf(inv);
        r.inv[k] = f32x8_splat(inv);
        r.near[k] = f32x8_splat(at + off);
        r.far[k] = f32x8_splat(at - off);
        r.near_plane[k] = (uint32_t)(back ? k + 3 : k);
        r.far_plane[k] = (uint32_t)(back ? k : k + 3);
    }
    return r;
}

static inline vec3 box8_error(vec3 origin)
{
    const float e = BOX8_PAD * box8_reach(origin);
    return vec3_make(e, e, e);
}

/* The planes of box `lane`, moved outwards. Monotone: a box inside another has planes inside. */
static inline void box8_store(float plane[BOX8_PLANES][8], int lane, const float lo[3],
                              const float hi[3])
{
    const float a = box8_reach(vec3_load(lo)), b = box8_reach(vec3_load(hi));
    const float pad = BOX8_PAD * (a > b ? a : b);
    for (int k = 0; k < 3; k++) {
        plane[k][lane] = lo[k] - pad;
        plane[k + 3][lane] = hi[k] + pad;
    }
}

/* Bit i: the ray passes box i within [0, t_max]; near: where it enters, far: where it leaves. */
static inline uint32_t box8_hit(const struct box8_ray *r, const float (*plane)[8], float t_max,
                                f32x8 *near, f32x8 *far)
{
    f32x8 t0 = f32x8_splat(0), t1 = f32x8_splat(t_max);
    for (int k = 0; k < 3; k++) {
        const f32x8 a = f32x8_load(plane[r->near_plane[k]]);
        const f32x8 b = f32x8_load(plane[r->far_plane[k]]);
        t0 = f32x8_max(f32x8_fused(a, r->inv[k], r->near[k]), t0);
        t1 = f32x8_min(f32x8_fused(b, r->inv[k], r->far[k]), t1);
    }
    *near = t0;
    *far = t1;
    return i32x8_mask(t0 <= t1);
}

#endif
