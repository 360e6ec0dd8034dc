/* simd.h - eight floats at once: the few operations that the operators of a vector type cannot say.
 *
 * The only file with intrinsics. Each operation has a plain version beside it, for a compiler
 * without AVX2 and FMA; both give the same bits, but for f32x8_fused, which promises one rounding
 * or two: it is for bounds with room for either (box8.h), never for what reaches a pixel.
 *
 * min and max return b when either is a NaN, as minps and maxps do: f32x8_max(x, keep) keeps.
 * SPDX-License-Identifier: MIT */
#ifndef COMMON_TRACE_SIMD_H
#define COMMON_TRACE_SIMD_H

#include <string.h>

#include "common/vec.h"

typedef float f32x8 __attribute__((vector_size(32)));
typedef int32_t i32x8 __attribute__((vector_size(32)));
typedef uint32_t u32x8 __attribute__((vector_size(32)));
typedef int32_t i32x4 __attribute__((vector_size(16)));
typedef double f64x4 __attribute__((vector_size(32)));

static inline f32x8 f32x8_load(const float *aligned32)
{
    return *(const f32x8 *)(const void *)aligned32;
}

/* The same, into a register. gcc else reads memory in the middle of a fused operation, where it
 * must then copy the other operand, which that overwrites. */
static inline f32x8 f32x8_fetch(const float *aligned32)
{
    f32x8 v = f32x8_load(aligned32);
#ifdef __AVX__
    __asm__("" : "+x"(v));
#endif
    return v;
}

static inline f32x8 f32x8_splat(float x)
{
    return (f32x8){x, x, x, x, x, x, x, x};
}

static inline u32x8 u32x8_load(const uint32_t *aligned32)
{
    return *(const u32x8 *)(const void *)aligned32;
}

static inline u32x8 u32x8_splat(uint32_t x)
{
    return (u32x8){x, x, x, x, x, x, x, x};
}

static inline vec3 f32x8_low(f32x8 v)
{
    return __builtin_shufflevector(v, v, 0, 1, 2, 3);
}

static inline vec3 f32x8_high(f32x8 v)
{
    return __builtin_shufflevector(v, v, 4, 5, 6, 7);
}

/* Lane by lane a where m is -1, b where it is 0. */
static inline f32x8 f32x8_choose(i32x8 m, f32x8 a, f32x8 b)
{
    return (f32x8)(((i32x8)a & m) | ((i32x8)b & ~m));
}

static inline f64x4 f64x4_of(vec3 v)
{
    return __builtin_convertvector(v, f64x4);
}

static inline vec3 f64x4_round(f64x4 v)
{
    return __builtin_convertvector(v, vec3);
}

/* Each component as a[i] * b[j] - a[j] * b[i]; lane 3 comes of the lanes 3. */
static inline f64x4 f64x4_cross(f64x4 a, f64x4 b)
{
    const f64x4 aa = __builtin_shufflevector(a, a, 1, 2, 0, 3);
    const f64x4 bb = __builtin_shufflevector(b, b, 1, 2, 0, 3);
    const f64x4 c = a * bb - aa * b; /* z, x, y */
    return __builtin_shufflevector(c, c, 1, 2, 0, 3);
}

/* All four lanes: one instruction, where vec3_make takes four. */
static inline vec3 vec3_splat(float x)
{
    return (vec3){x, x, x, x};
}

static inline vec3 vec3_abs(vec3 v)
{
    const i32x4 keep = {0x7fffffff, 0x7fffffff, 0x7fffffff, 0x7fffffff};
    return (vec3)((i32x4)v & keep);
}

/* Lane by lane a where m is -1, b where it is 0. */
static inline vec3 vec3_choose(i32x4 m, vec3 a, vec3 b)
{
    return (vec3)(((i32x4)a & m) | ((i32x4)b & ~m));
}

#if defined __AVX2__ && defined __FMA__

#include <immintrin.h>

static inline void f32x8_store(float *aligned32, f32x8 v)
{
    _mm256_store_ps(aligned32, (__m256)v);
}

static inline void f32x8_store_bits(uint32_t *aligned32, f32x8 v)
{
    _mm256_store_si256((__m256i *)(void *)aligned32, (__m256i)v);
}

static inline f32x8 f32x8_min(f32x8 a, f32x8 b)
{
    return (f32x8)_mm256_min_ps((__m256)a, (__m256)b);
}

static inline f32x8 f32x8_max(f32x8 a, f32x8 b)
{
    return (f32x8)_mm256_max_ps((__m256)a, (__m256)b);
}

/* v[lane], eight times. */
static inline f32x8 f32x8_spread(f32x8 v, u32x8 lane)
{
    return (f32x8)_mm256_permutevar8x32_ps((__m256)v, (__m256i)lane);
}

static inline f32x8 f32x8_sqrt(f32x8 a)
{
    return (f32x8)_mm256_sqrt_ps((__m256)a);
}

/* a * b - c */
static inline f32x8 f32x8_fused(f32x8 a, f32x8 b, f32x8 c)
{
    return (f32x8)_mm256_fmsub_ps((__m256)a, (__m256)b, (__m256)c);
}

/* Bit i: lane i of a comparison is true. */
static inline uint32_t i32x8_mask(i32x8 m)
{
    return (uint32_t)_mm256_movemask_ps((__m256)m);
}

static inline vec3 vec3_min(vec3 a, vec3 b)
{
    return (vec3)_mm_min_ps((__m128)a, (__m128)b);
}

static inline vec3 vec3_max(vec3 a, vec3 b)
{
    return (vec3)_mm_max_ps((__m128)a, (__m128)b);
}

/* Bit i: lane i of a comparison is true. */
static inline uint32_t i32x4_mask(i32x4 m)
{
    return (uint32_t)_mm_movemask_ps((__m128)m);
}

/* Towards zero; lanes out of range are anything. */
static inline i32x4 vec3_truncate(vec3 v)
{
    return (i32x4)_mm_cvttps_epi32((__m128)v);
}

#else

static inline void f32x8_store(float *aligned32, f32x8 v)
{
    memcpy(aligned32, &v, sizeof v);
}

static inline void f32x8_store_bits(uint32_t *aligned32, f32x8 v)
{
    memcpy(aligned32, &v, sizeof v);
}

static inline f32x8 f32x8_min(f32x8 a, f32x8 b)
{
    for (int i = 0; i < 8; i++)
        b[i] = a[i] < b[i] ? a[i] : b[i];
    return b;
}

static inline f32x8 f32x8_max(f32x8 a, f32x8 b)
{
    for (int i = 0; i < 8; i++)
        b[i] = a[i] > b[i] ? a[i] : b[i];
    return b;
}

static inline f32x8 f32x8_spread(f32x8 v, u32x8 lane)
{
    return f32x8_splat(v[lane[0]]);
}

static inline f32x8 f32x8_sqrt(f32x8 a)
{
    for (int i = 0; i < 8; i++)
        a[i] = __builtin_sqrtf(a[i]);
    return a;
}

static inline f32x8 f32x8_fused(f32x8 a, f32x8 b, f32x8 c)
{
    return a * b - c;
}

static inline uint32_t i32x8_mask(i32x8 m)
{
    uint32_t bits = 0;
    for (int i = 0; i < 8; i++)
        bits |= m[i] < 0 ? 1u << i : 0;
    return bits;
}

static inline vec3 vec3_min(vec3 a, vec3 b)
{
    for (int i = 0; i < 4; i++)
        b[i] = a[i] < b[i] ? a[i] : b[i];
    return b;
}

static inline vec3 vec3_max(vec3 a, vec3 b)
{
    for (int i = 0; i < 4; i++)
        b[i] = a[i] > b[i] ? a[i] : b[i];
    return b;
}

static inline uint32_t i32x4_mask(i32x4 m)
{
    uint32_t bits = 0;
    for (int i = 0; i < 4; i++)
        bits |= m[i] < 0 ? 1u << i : 0;
    return bits;
}

static inline i32x4 vec3_truncate(vec3 v)
{
    i32x4 out = {0};
    for (int i = 0; i < 4; i++)
        out[i] = v[i] >= -0x1p30f && v[i] <= 0x1p30f ? (int32_t)v[i] : INT32_MIN;
    return out;
}

#endif

#endif
