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
typedef int32_t i32x4 __attribute__((vector_size(16)));

static inline f32x8 f32x8_load(const float *aligned32)
{
    return *(const f32x8 *)(const void *)aligned32;
}

static inline f32x8 f32x8_splat(float x)
{
    return (f32x8){x, x, x, x, x, x, x, x};
}

#if defined __AVX2__ && defined __FMA__

#include <immintrin.h>

static inline f32x8 f32x8_min(f32x8 a, f32x8 b)
{
    return (f32x8)_mm256_min_ps((__m256)a, (__m256)b);
}

static inline f32x8 f32x8_max(f32x8 a, f32x8 b)
{
    return (f32x8)_mm256_max_ps((__m256)a, (__m256)b);
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

/* Towards zero; lanes out of range are anything. */
static inline i32x4 vec3_truncate(vec3 v)
{
    return (i32x4)_mm_cvttps_epi32((__m128)v);
}

#else

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

static inline i32x4 vec3_truncate(vec3 v)
{
    i32x4 out = {0};
    for (int i = 0; i < 4; i++)
        out[i] = v[i] >= -0x1p30f && v[i] <= 0x1p30f ? (int32_t)v[i] : INT32_MIN;
    return out;
}

#endif

#endif
