/* vec8.h - eight vec3 in the lanes of vectors: the functions of vec.h, operation by operation, so
 * that each lane holds the bits that a vec3 would.
 *
 * A lane that means nothing holds anything; who reads a lane knows that it means something.
 * SPDX-License-Identifier: MIT */
#ifndef COMMON_TRACE_VEC8_H
#define COMMON_TRACE_VEC8_H

#include "common/trace/simd.h"

struct vec8 {
    f32x8 x, y, z;
};

static inline struct vec8 vec8_add(struct vec8 a, struct vec8 b)
{
    return (struct vec8){a.x + b.x, a.y + b.y, a.z + b.z};
}

static inline struct vec8 vec8_sub(struct vec8 a, struct vec8 b)
{
    return (struct vec8){a.x - b.x, a.y - b.y, a.z - b.z};
}

static inline struct vec8 vec8_mul(struct vec8 a, struct vec8 b)
{
    return (struct vec8){a.x * b.x, a.y * b.y, a.z * b.z};
}

static inline struct vec8 vec8_scale(struct vec8 a, f32x8 s)
{
    return (struct vec8){a.x * s, a.y * s, a.z * s};
}

static inline struct vec8 vec8_over(struct vec8 a, f32x8 s)
{
    return (struct vec8){a.x / s, a.y / s, a.z / s};
}

static inline struct vec8 vec8_negative(struct vec8 a)
{
    return (struct vec8){-a.x, -a.y, -a.z};
}

static inline struct vec8 vec8_abs(struct vec8 a)
{
    return (struct vec8){f32x8_abs(a.x), f32x8_abs(a.y), f32x8_abs(a.z)};
}

static inline f32x8 vec8_dot(struct vec8 a, struct vec8 b)
{
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

static inline struct vec8 vec8_choose(i32x8 m, struct vec8 a, struct vec8 b)
{
    return (struct vec8){f32x8_choose(m, a.x, b.x), f32x8_choose(m, a.y, b.y),
                         f32x8_choose(m, a.z, b.z)};
}

/* As rgb_max, rgb_is_black. */
static inline f32x8 vec8_most(struct vec8 c)
{
    return f32x8_max(f32x8_max(c.x, c.y), c.z);
}

static inline i32x8 vec8_is_zero(struct vec8 c)
{
    const f32x8 none = {0};
    return (c.x == none) & (c.y == none) & (c.z == none);
}

/* v[i] -> lane i, and back; lane 3 of the vectors is never read, and 0. */
static inline struct vec8 vec8_gather(const vec3 v[8])
{
    f32x8 k[3];
    f32x8_columns(v, k);
    return (struct vec8){k[0], k[1], k[2]};
}

static inline void vec8_scatter(struct vec8 a, vec3 v[8])
{
    f32x8_rows(a.x, a.y, a.z, (f32x8){0}, v);
}

/* Where m is -1, lane k[i] of a; where it is 0, b. */
static inline struct vec8 vec8_take(i32x8 m, struct vec8 a, u32x8 k, struct vec8 b)
{
    const struct vec8 moved = {f32x8_permute(a.x, k), f32x8_permute(a.y, k), f32x8_permute(a.z, k)};
    return vec8_choose(m, moved, b);
}

static inline u32x8 u32x8_take(i32x8 m, u32x8 a, u32x8 k, u32x8 b)
{
    return (u32x8)f32x8_choose(m, f32x8_permute((f32x8)a, k), (f32x8)b);
}

/* One lane alone. */
static inline vec3 vec8_lane(const struct vec8 *a, uint32_t i)
{
    return vec3_make(a->x[i], a->y[i], a->z[i]);
}

static inline void vec8_set_lane(struct vec8 *a, uint32_t i, vec3 v)
{
    a->x[i] = v[0];
    a->y[i] = v[1];
    a->z[i] = v[2];
}

#endif
