/* surface8.h - points of triangles and the rays that leave them, in the lanes of vectors: the part
 * of surface.h that most vertices of most paths need. The same bits.
 * SPDX-License-Identifier: MIT */
#ifndef COMMON_TRACE_SURFACE8_H
#define COMMON_TRACE_SURFACE8_H

#include "common/trace/round.h"
#include "common/trace/surface.h"
#include "common/trace/vec8.h"

struct surface8 { /* as struct surface */
    struct vec8 p, p_error, ng;
    u32x8 prim;
};

struct surface8_corners { /* of triangles, in the world */
    struct vec8 a, b, c;
};

/* at[i]: a triangle's first number in its block. Beside each other they are in no memory. */
static inline f32x8 surface8_column(const float *const at[8], size_t from)
{
    return (f32x8){at[0][from], at[1][from], at[2][from], at[3][from],
                   at[4][from], at[5][from], at[6][from], at[7][from]};
}

static inline struct vec8 surface8_corner(const float *const at[8], size_t vertex)
{
    enum { AXIS = STAGE_LANES, VERTEX = 3 * STAGE_LANES };
    return (struct vec8){surface8_column(at, vertex * VERTEX),
                         surface8_column(at, vertex * VERTEX + AXIS),
                         surface8_column(at, vertex * VERTEX + 2 * AXIS)};
}

static inline struct surface8_corners surface8_corners_at(const float *const at[8])
{
    return (struct surface8_corners){surface8_corner(at, 0), surface8_corner(at, 1),
                                     surface8_corner(at, 2)};
}

/* Of four triangles, in double. */
static inline void surface8_normal_half(const f64x4 u[3], const f64x4 v[3], vec3 n[3])
{
    const f64x4 x = u[1] * v[2] - u[2] * v[1], y = u[2] * v[0] - u[0] * v[2],
                z = u[0] * v[1] - u[1] * v[0];
    const f64x4 length = f64x4_sqrt(x * x + y * y + z * z);
    n[0] = f64x4_round(x / length);
    n[1] = f64x4_round(y / length);
    n[2] = f64x4_round(z / length);
}

static inline struct vec8 surface8_normal(const struct surface8_corners *t)
{
    const f32x8 a[3] = {t->a.x, t->a.y, t->a.z}, b[3] = {t->b.x, t->b.y, t->b.z},
                c[3] = {t->c.x, t->c.y, t->c.z};
    f64x4 u[2][3], v[2][3];
    vec3 n[2][3];
    for (int k = 0; k < 3; k++) {
        const f64x4 low = f64x4_of(f32x8_low(a[k])), high = f64x4_of(f32x8_high(a[k]));
        u[0][k] = f64x4_of(f32x8_low(b[k])) - low;
        v[0][k] = f64x4_of(f32x8_low(c[k])) - low;
        u[1][k] = f64x4_of(f32x8_high(b[k])) - high;
        v[1][k] = f64x4_of(f32x8_high(c[k])) - high;
    }
    surface8_normal_half(u[0], v[0], n[0]);
    surface8_normal_half(u[1], v[1], n[1]);
    return (struct vec8){f32x8_join(n[0][0], n[1][0]), f32x8_join(n[0][1], n[1][1]),
                         f32x8_join(n[0][2], n[1][2])};
}

/* p and p_error of the points with weights u and v. */
static inline void surface8_place(const struct surface8_corners *t, f32x8 u, f32x8 v,
                                  struct surface8 *at)
{
    const struct vec8 a = vec8_scale(t->a, 1 - u - v), b = vec8_scale(t->b, u),
                      c = vec8_scale(t->c, v);
    at->p = vec8_add(vec8_add(a, b), c);
    at->p_error = vec8_scale(vec8_add(vec8_add(vec8_abs(a), vec8_abs(b)), vec8_abs(c)),
                             f32x8_splat(round_gamma(7)));
}

/* As round_along. */
static inline f32x8 surface8_round(f32x8 p, f32x8 way)
{
    const f32x8 none = {0};
    const i32x8 down = way < none, mirror = down & INT32_MIN;
    const f32x8 x = (f32x8)((i32x8)p ^ mirror);
    const i32x8 bits = (i32x8)x & (x != none);
    const i32x8 next = (i32x8)((u32x8)bits + (u32x8)((x < none) | 1)); /* of a NaN it may wrap */
    const i32x8 moves = (down | (way > none)) & (x < none + __builtin_inff());
    return f32x8_choose(moves, (f32x8)(next ^ mirror), p);
}

static inline struct vec8 surface8_outside(const struct surface8 *s, struct vec8 p_error,
                                           struct vec8 dir)
{
    const f32x8 distance = vec8_dot(vec8_abs(s->ng), p_error), none = {0};
    const i32x8 behind = vec8_dot(dir, s->ng) < none;
    const struct vec8 offset = vec8_scale(s->ng, f32x8_choose(behind, -distance, distance));
    const struct vec8 p = vec8_add(s->p, offset);
    return (struct vec8){surface8_round(p.x, offset.x), surface8_round(p.y, offset.y),
                         surface8_round(p.z, offset.z)};
}

/* Written as rays. */
static inline void surface8_rays(struct vec8 origin, struct vec8 dir, struct ray rays[8])
{
    vec3 o[8], d[8];
    vec8_scatter(origin, o);
    vec8_scatter(dir, d);
    for (int i = 0; i < 8; i++) {
        rays[i].origin = o[i];
        rays[i].dir = d[i];
    }
}

static inline void surface8_leave(const struct surface8 *s, struct vec8 dir, struct ray rays[8])
{
    surface8_rays(surface8_outside(s, s->p_error, dir), dir, rays);
    for (int i = 0; i < 8; i++) {
        rays[i].t_max = __builtin_inff();
        rays[i].from = s->prim[i] + 1;
        rays[i].to = 0;
    }
}

/* way: to.p - from.p, its length is `length`. */
static inline void surface8_to_surface(const struct surface8 *from, const struct surface8 *to,
                                       struct vec8 way, f32x8 length, struct ray rays[8])
{
    const struct vec8 origin = surface8_outside(from, from->p_error, way);
    const f32x8 blur = round_gamma(6) * length;
    const struct vec8 error = vec8_add(to->p_error, (struct vec8){blur, blur, blur});
    const struct vec8 target = surface8_outside(to, error, vec8_negative(way));
    surface8_rays(origin, vec8_sub(target, origin), rays);
    for (int i = 0; i < 8; i++) {
        rays[i].t_max = 1;
        rays[i].from = from->prim[i] + 1;
        rays[i].to = to->prim[i] + 1;
    }
}

#endif
