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

enum { BOX8_PLANES = 6 }; /* low x, high x, low y, high y, low z, high z */

/* A ray made ready, its numbers eight times over. */
struct box8_ray {
    f32x8 inv[3];           /* 1 / d */
    f32x8 near[3], far[3];  /* origin / d, the origin moved by its error so that a box is met
                             * early, left late */
    const uint16_t *planes; /* which it enters by along x, y, z, then leaves by: in floats from the
                             * first */
};

/* By the signs of the direction, bit k for component k. */
static const uint16_t box8_planes[8][6] = {
    {0, 16, 32, 8, 24, 40}, {8, 16, 32, 0, 24, 40}, {0, 24, 32, 8, 16, 40}, {8, 24, 32, 0, 16, 40},
    {0, 16, 40, 8, 24, 32}, {8, 16, 40, 0, 24, 32}, {0, 24, 40, 8, 16, 32}, {8, 24, 40, 0, 16, 32},
};

static inline float box8_reach(vec3 v)
{
    const vec3 a = vec3_abs(v);
    const float x = a[0], y = a[1], z = a[2];
    const float xy = x > y ? x : y;
    return xy > z ? xy : z;
}

/* error: of the origin and of everything that goes with it, along each axis. */
static inline void box8_ray_init(struct box8_ray *r, vec3 origin, vec3 dir, vec3 error)
{
    const vec3 least = vec3_splat(0x1p-40f * box8_reach(dir)), none = {0};
    const i32x4 back = dir < none;
    const vec3 inv = 1 / vec3_choose(vec3_abs(dir) < least, vec3_choose(back, -least, least), dir);
    const vec3 at = origin * inv, off = error * vec3_abs(inv);
    for (int k = 0; k < 3; k++) {
        r->inv[k] = f32x8_splat(inv[k]);
        r->near[k] = f32x8_splat((at + off)[k]);
        r->far[k] = f32x8_splat((at - off)[k]);
    }
    r->planes = box8_planes[i32x4_mask(back) & 7];
}

static inline vec3 box8_error(vec3 origin)
{
    return vec3_splat(BOX8_PAD * box8_reach(origin));
}

/* Eight rays in the lanes, each with its origin's error (box8_error). */
struct box8_rays {
    _Alignas(32) float inv[3][8], near[3][8], far[3][8];
    uint32_t negative[3]; /* bit i: this component of ray i's direction is below 0 */
};

static inline void box8_rays_init(struct box8_rays *r, const f32x8 origin[3], const f32x8 dir[3])
{
    f32x8 longest = f32x8_abs(dir[0]), reach = f32x8_abs(origin[0]);
    for (int k = 1; k < 3; k++) {
        longest = f32x8_max(f32x8_abs(dir[k]), longest);
        reach = f32x8_max(f32x8_abs(origin[k]), reach);
    }
    const f32x8 least = 0x1p-40f * longest, error = BOX8_PAD * reach, none = {0};
    for (int k = 0; k < 3; k++) {
        const i32x8 back = dir[k] < none;
        const f32x8 inv =
            1 / f32x8_choose(f32x8_abs(dir[k]) < least, f32x8_choose(back, -least, least), dir[k]);
        const f32x8 at = origin[k] * inv, off = error * f32x8_abs(inv);
        f32x8_store(r->inv[k], inv);
        f32x8_store(r->near[k], at + off);
        f32x8_store(r->far[k], at - off);
        r->negative[k] = i32x8_mask(back);
    }
}

static inline void box8_rays_take(const struct box8_rays *rays, uint32_t i, struct box8_ray *r)
{
    for (int k = 0; k < 3; k++) {
        r->inv[k] = f32x8_splat(rays->inv[k][i]);
        r->near[k] = f32x8_splat(rays->near[k][i]);
        r->far[k] = f32x8_splat(rays->far[k][i]);
    }
    r->planes = box8_planes[(rays->negative[0] >> i & 1) | (rays->negative[1] >> i & 1) << 1 |
                            (rays->negative[2] >> i & 1) << 2];
}

/* The planes of box `lane`, moved outwards. Monotone: a box inside another has planes inside. */
static inline void box8_store(float plane[BOX8_PLANES][8], uint32_t lane, vec3 lo, vec3 hi)
{
    const float a = box8_reach(lo), b = box8_reach(hi);
    const float pad = BOX8_PAD * (a > b ? a : b);
    for (int k = 0; k < 3; k++) {
        plane[2 * k][lane] = lo[k] - pad;
        plane[2 * k + 1][lane] = hi[k] + pad;
    }
}

/* Bit i: the ray passes box i within [0, t_max]; near: where it enters, far: where it leaves. */
static inline uint32_t box8_hit(const struct box8_ray *r, const float (*plane)[8], float t_max,
                                f32x8 *near, f32x8 *far)
{
    const float *p = plane[0];
    const f32x8 x = f32x8_fetch(r->inv[0]), y = f32x8_fetch(r->inv[1]), z = f32x8_fetch(r->inv[2]);
    const f32x8 x0 = f32x8_fused(f32x8_load(p + r->planes[0]), x, r->near[0]);
    const f32x8 y0 = f32x8_fused(f32x8_load(p + r->planes[1]), y, r->near[1]);
    const f32x8 z0 = f32x8_fused(f32x8_load(p + r->planes[2]), z, r->near[2]);
    const f32x8 x1 = f32x8_fused(f32x8_load(p + r->planes[3]), x, r->far[0]);
    const f32x8 y1 = f32x8_fused(f32x8_load(p + r->planes[4]), y, r->far[1]);
    const f32x8 z1 = f32x8_fused(f32x8_load(p + r->planes[5]), z, r->far[2]);
    const f32x8 none = {0};
    *near = f32x8_max(x0, f32x8_max(y0, f32x8_max(z0, none)));
    *far = f32x8_min(x1, f32x8_min(y1, f32x8_min(z1, f32x8_splat(t_max))));
    return i32x8_mask(*near <= *far);
}

/* Bit i: ray i passes the box `lane` within [0, t_max[i]]. The rays have the signs of planes. */
static inline uint32_t box8_rays_hit(const struct box8_rays *r, const uint16_t *planes,
                                     const float (*plane)[8], uint32_t lane, f32x8 t_max)
{
    const float *p = plane[0] + lane;
    f32x8 near = {0}, far = t_max;
    for (int k = 0; k < 3; k++) {
        const f32x8 inv = f32x8_fetch(f32x8_load(r->inv[k]));
        near = f32x8_max(f32x8_fused(f32x8_splat(p[planes[k]]), inv, f32x8_load(r->near[k])), near);
        far =
            f32x8_min(f32x8_fused(f32x8_splat(p[planes[k + 3]]), inv, f32x8_load(r->far[k])), far);
    }
    return i32x8_mask(near <= far);
}

/* Eight rays with the same signs as one thick one: it passes every box that one of them does.
 *
 * A plane p is met at (p - c) / d - (origin - c) / d, c being the first ray's origin: no sooner
 * than the sooner of the two extreme 1 / d says for the first term, less the most of the second.
 * Against box8_hit that is two more roundings, 2 u (A + O), well within the padding. */
struct box8_fan {
    f32x8 center[3];
    f32x8 inv[2][3];       /* the least and the most of 1 / d */
    f32x8 near[3], far[3]; /* the most and the least of (origin - c) / d, errors included */
    const uint16_t *planes;
};

/* False: they have not, or numbers are too large. */
static inline bool box8_fan_init(struct box8_fan *f, const struct box8_rays *r)
{
    uint32_t signs = 0;
    i32x8 finite = {-1, -1, -1, -1, -1, -1, -1, -1};
    for (int k = 0; k < 3; k++) {
        const f32x8 inv = f32x8_load(r->inv[k]), near = f32x8_load(r->near[k]),
                    far = f32x8_load(r->far[k]);
        if (r->negative[k] != 0 && r->negative[k] != 0xff)
            return false;
        signs |= (r->negative[k] & 1) << k;
        f->center[k] = f32x8_splat((0.5f * (r->near[k][0] + r->far[k][0])) / r->inv[k][0]);
        const f32x8 n = near - f->center[k] * inv, l = far - f->center[k] * inv;
        f->inv[0][k] = f32x8_least(inv);
        f->inv[1][k] = f32x8_most(inv);
        f->near[k] = f32x8_most(n);
        f->far[k] = f32x8_least(l);
        finite &= (n - n == 0) & (l - l == 0);
    }
    f->planes = box8_planes[signs];
    return i32x8_mask(finite) == 0xff;
}

/* Bit i: it passes box i within [0, t_max]; near: not after any of the rays enters. */
static inline uint32_t box8_fan_hit(const struct box8_fan *f, const float (*plane)[8], f32x8 t_max,
                                    f32x8 *near)
{
    const float *p = plane[0];
    f32x8 far = t_max;
    *near = (f32x8){0};
    for (int k = 0; k < 3; k++) {
        const f32x8 in = f32x8_load(p + f->planes[k]) - f->center[k],
                    out = f32x8_load(p + f->planes[k + 3]) - f->center[k];
        *near = f32x8_max(f32x8_min(in * f->inv[0][k], in * f->inv[1][k]) - f->near[k], *near);
        far = f32x8_min(f32x8_max(out * f->inv[0][k], out * f->inv[1][k]) - f->far[k], far);
    }
    return i32x8_mask(*near <= far);
}

#endif
