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
 * Where they do not for the size of the numbers themselves, they are NaN and f32x8_min and _max
 * keep the box.
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
    vec3 inv;       /* 1 / d */
    vec3 near, far; /* origin / d, the origin moved by its error so that a box is met early,
                     * left late */
    const uint16_t
        *planes; /* which it enters by along x, y, z, then leaves by: in floats from the first */
};

static inline float box8_reach(vec3 v)
{
    const vec3 a = vec3_abs(v);
    const float x = a[0], y = a[1], z = a[2];
    const float xy = x > y ? x : y;
    return xy > z ? xy : z;
}

/* By the signs of the direction, bit k for component k. */
static const uint16_t box8_planes[8][6] = {
    {0, 8, 16, 24, 32, 40}, {24, 8, 16, 0, 32, 40}, {0, 32, 16, 24, 8, 40}, {24, 32, 16, 0, 8, 40},
    {0, 8, 40, 24, 32, 16}, {24, 8, 40, 0, 32, 16}, {0, 32, 40, 24, 8, 16}, {24, 32, 40, 0, 8, 16},
};

/* longest: box8_reach(dir). error: of the origin and of everything that goes with it, along each
 * axis. */
static inline void box8_ray_init(struct box8_ray *r, vec3 origin, vec3 dir, float longest,
                                 vec3 error)
{
    const vec3 least = vec3_splat(0x1p-40f * longest), none = {0};
    const i32x4 back = dir < none;
    const vec3 inv = 1 / vec3_choose(vec3_abs(dir) < least, vec3_choose(back, -least, least), dir);
    const vec3 at = origin * inv, off = error * vec3_abs(inv);
    r->inv = inv;
    r->near = at + off;
    r->far = at - off;
    r->planes = box8_planes[i32x4_mask(back) & 7];
}

static inline vec3 box8_error(vec3 origin)
{
    return vec3_splat(BOX8_PAD * box8_reach(origin));
}

/* The planes of box `lane`, moved outwards. Monotone: a box inside another has planes inside. */
static inline void box8_store(float plane[BOX8_PLANES][8], uint32_t lane, vec3 lo, vec3 hi)
{
    const float a = box8_reach(lo), b = box8_reach(hi);
    const float pad = BOX8_PAD * (a > b ? a : b);
    for (int k = 0; k < 3; k++) {
        plane[k][lane] = lo[k] - pad;
        plane[k + 3][lane] = hi[k] + pad;
    }
}

/* The ray's numbers eight times over, for a loop to keep in registers. */
struct box8_wide {
    f32x8 inv0, inv1, inv2, near0, near1, near2, far0, far1, far2;
};

static inline struct box8_wide box8_widen(const struct box8_ray *r)
{
    return (struct box8_wide){
        f32x8_splat(r->inv[0]),  f32x8_splat(r->inv[1]),  f32x8_splat(r->inv[2]),
        f32x8_splat(r->near[0]), f32x8_splat(r->near[1]), f32x8_splat(r->near[2]),
        f32x8_splat(r->far[0]),  f32x8_splat(r->far[1]),  f32x8_splat(r->far[2]),
    };
}

/* Bit i: the ray passes box i within [0, t_max]; near: where it enters, far: where it leaves. */
static inline uint32_t box8_hit(const struct box8_ray *r, const struct box8_wide *w,
                                const float (*plane)[8], float t_max, f32x8 *near, f32x8 *far)
{
    const float *p = plane[0];
    const f32x8 x0 = f32x8_fused(f32x8_fetch(p + r->planes[0]), w->inv0, w->near0);
    const f32x8 y0 = f32x8_fused(f32x8_fetch(p + r->planes[1]), w->inv1, w->near1);
    const f32x8 z0 = f32x8_fused(f32x8_fetch(p + r->planes[2]), w->inv2, w->near2);
    const f32x8 x1 = f32x8_fused(f32x8_fetch(p + r->planes[3]), w->inv0, w->far0);
    const f32x8 y1 = f32x8_fused(f32x8_fetch(p + r->planes[4]), w->inv1, w->far1);
    const f32x8 z1 = f32x8_fused(f32x8_fetch(p + r->planes[5]), w->inv2, w->far2);
    const f32x8 none = {0};
    *near = f32x8_max(x0, f32x8_max(y0, f32x8_max(z0, none)));
    *far = f32x8_min(x1, f32x8_min(y1, f32x8_min(z1, f32x8_splat(t_max))));
    return i32x8_mask(*near <= *far);
}

#endif
