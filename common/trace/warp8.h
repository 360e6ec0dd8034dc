/* warp8.h - what surfaces and triangles take of warp.h, in the lanes of vectors. The same bits.
 * SPDX-License-Identifier: MIT */
#ifndef COMMON_TRACE_WARP8_H
#define COMMON_TRACE_WARP8_H

#include "common/trace/fmath.h"
#include "common/trace/sobol8.h"
#include "common/trace/vec8.h"

struct warp8_frame {
    struct vec8 x, y, z;
};

static inline struct warp8_frame warp8_frame_make(struct vec8 z)
{
    const f32x8 one = f32x8_splat(1);
    const f32x8 sign = f32x8_choose(z.z < 0, -one, one);
    const f32x8 a = -1 / (sign + z.z);
    const f32x8 b = z.x * z.y * a;
    return (struct warp8_frame){
        .x = {1 + sign * z.x * z.x * a, sign * b, -sign * z.x},
        .y = {b, sign + z.y * z.y * a, -z.y},
        .z = z,
    };
}

static inline struct vec8 warp8_to_local(const struct warp8_frame *f, struct vec8 v)
{
    return (struct vec8){vec8_dot(v, f->x), vec8_dot(v, f->y), vec8_dot(v, f->z)};
}

static inline struct vec8 warp8_to_world(const struct warp8_frame *f, struct vec8 v)
{
    return vec8_add(vec8_add(vec8_scale(f->x, v.x), vec8_scale(f->y, v.y)), vec8_scale(f->z, v.z));
}

/* As fmath_sincos_octant. */
static inline void warp8_sincos_octant(f32x8 r, f32x8 *s, f32x8 *c)
{
    const f32x8 z = r * r;
    *s = r + r * z * (-0.166666642f + z * (0.00833274797f + z * -0.00019587866f));
    *c = 1 - 0.5f * z + z * z * (0.0416666642f + z * (-0.00138883025f + z * 2.45479168e-05f));
}

static inline struct vec8 warp8_disc(struct sobol8_square q)
{
    const f32x8 a = 2 * q.u - 1, b = 2 * q.v - 1, none = {0};
    const i32x8 wide = a * a > b * b;
    const f32x8 longer = f32x8_choose(wide, a, b), shorter = f32x8_choose(wide, b, a);
    f32x8 s, c;
    warp8_sincos_octant(0.5f * FMATH_HALF_PI * (shorter / longer), &s, &c);
    const struct vec8 d = {longer * f32x8_choose(wide, c, s), longer * f32x8_choose(wide, s, c),
                           none};
    return vec8_choose(longer == none, (struct vec8){none, none, none}, d);
}

static inline struct vec8 warp8_cosine(struct sobol8_square q)
{
    const struct vec8 d = warp8_disc(q);
    const f32x8 zz = 1 - d.x * d.x - d.y * d.y, none = {0};
    return (struct vec8){d.x, d.y, f32x8_sqrt(f32x8_choose(zz > none, zz, none))};
}

static inline f32x8 warp8_cosine_pdf_w(f32x8 cos)
{
    return cos * FMATH_INV_PI;
}

static inline struct sobol8_square warp8_triangle(struct sobol8_square q)
{
    const i32x8 above = q.v > q.u;
    return (struct sobol8_square){f32x8_choose(above, 0.5f * q.u, q.u - 0.5f * q.v),
                                  f32x8_choose(above, q.v - 0.5f * q.u, 0.5f * q.v)};
}

#endif
