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
typedef uint64_t u64x4 __attribute__((vector_size(32)));
typedef int64_t i64x4 __attribute__((vector_size(32)));
typedef double f64x4 __attribute__((vector_size(32)));

static inline f32x8 f32x8_load(const float *aligned32)
{
    return *(const f32x8 *)(const void *)aligned32;
}

/* The same, into a register, for good: gcc else loads it again for each use. */
static inline f32x8 f32x8_fetch(f32x8 v)
{
#ifdef __AVX__
    __asm__("" : "+x"(v));
#endif
    return v;
}

static inline f32x8 f32x8_splat(float x)
{
    return (f32x8){x, x, x, x, x, x, x, x};
}

static inline f32x8 f32x8_abs(f32x8 v)
{
    return (f32x8)((i32x8)v & 0x7fffffff);
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

static inline f32x8 f32x8_join(vec3 low, vec3 high)
{
    return __builtin_shufflevector(low, high, 0, 1, 2, 3, 4, 5, 6, 7);
}

/* -1 in lane i where bit i is set. */
static inline i32x8 i32x8_of_bits(uint32_t bits)
{
    const i32x8 bit = {1, 2, 4, 8, 16, 32, 64, 128};
    return (bit & (int32_t)bits) != 0;
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

/* The upper and lower halves of the four-float halves of a and b, alternately. */
static inline f32x8 f32x8_low_pairs(f32x8 a, f32x8 b)
{
    return __builtin_shufflevector(a, b, 0, 8, 1, 9, 4, 12, 5, 13);
}

static inline f32x8 f32x8_high_pairs(f32x8 a, f32x8 b)
{
    return __builtin_shufflevector(a, b, 2, 10, 3, 11, 6, 14, 7, 15);
}

/* Eight vectors -> component k of each, lane by lane, in out[k]. */
static inline void f32x8_columns(const vec3 v[8], f32x8 out[3])
{
    f32x8 r[4];
    for (int i = 0; i < 4; i++)
        r[i] = __builtin_shufflevector(v[i], v[i + 4], 0, 1, 2, 3, 4, 5, 6, 7);
    const f32x8 xy02 = f32x8_low_pairs(r[0], r[2]), xy13 = f32x8_low_pairs(r[1], r[3]);
    const f32x8 zw02 = f32x8_high_pairs(r[0], r[2]), zw13 = f32x8_high_pairs(r[1], r[3]);
    out[0] = f32x8_low_pairs(xy02, xy13);
    out[1] = f32x8_high_pairs(xy02, xy13);
    out[2] = f32x8_low_pairs(zw02, zw13);
}

/* And back: the lanes of x, y, z, w as vectors. */
static inline void f32x8_rows(f32x8 x, f32x8 y, f32x8 z, f32x8 w, vec3 out[8])
{
    const f32x8 xz_low = f32x8_low_pairs(x, z), xz_high = f32x8_high_pairs(x, z);
    const f32x8 yw_low = f32x8_low_pairs(y, w), yw_high = f32x8_high_pairs(y, w);
    const f32x8 r[4] = {f32x8_low_pairs(xz_low, yw_low), f32x8_high_pairs(xz_low, yw_low),
                        f32x8_low_pairs(xz_high, yw_high), f32x8_high_pairs(xz_high, yw_high)};
    for (int i = 0; i < 4; i++) {
        out[i] = __builtin_shufflevector(r[i], r[i], 0, 1, 2, 3);
        out[i + 4] = __builtin_shufflevector(r[i], r[i], 4, 5, 6, 7);
    }
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

/* The 32 bits of each in the opposite order: each byte's halves by a table, then the bytes. */
static inline u32x8 u32x8_reverse(u32x8 x)
{
    const __m256i low = _mm256_set1_epi8(15);
    const __m256i half = _mm256_setr_epi8(0, 8, 4, 12, 2, 10, 6, 14, 1, 9, 5, 13, 3, 11, 7, 15, 0,
                                          8, 4, 12, 2, 10, 6, 14, 1, 9, 5, 13, 3, 11, 7, 15);
    const __m256i bytes = _mm256_setr_epi8(3, 2, 1, 0, 7, 6, 5, 4, 11, 10, 9, 8, 15, 14, 13, 12, 3,
                                           2, 1, 0, 7, 6, 5, 4, 11, 10, 9, 8, 15, 14, 13, 12);
    const __m256i a = _mm256_shuffle_epi8(half, _mm256_and_si256((__m256i)x, low));
    const __m256i b =
        _mm256_shuffle_epi8(half, _mm256_and_si256(_mm256_srli_epi32((__m256i)x, 4), low));
    return (u32x8)_mm256_shuffle_epi8(_mm256_or_si256(_mm256_slli_epi32(a, 4), b), bytes);
}

/* Lane by lane a where m is -1, b where it is 0. */
static inline f32x8 f32x8_choose(i32x8 m, f32x8 a, f32x8 b)
{
    return (f32x8)_mm256_blendv_ps((__m256)b, (__m256)a, (__m256)m);
}

/* v[lane], eight times. */
static inline f32x8 f32x8_spread(f32x8 v, u32x8 lane)
{
    return (f32x8)_mm256_permutevar8x32_ps((__m256)v, (__m256i)lane);
}

/* Lane i: v[from[i]], from below 8. */
static inline f32x8 f32x8_permute(f32x8 v, u32x8 from)
{
    return (f32x8)_mm256_permutevar8x32_ps((__m256)v, (__m256i)from);
}

static inline f32x8 f32x8_sqrt(f32x8 a)
{
    return (f32x8)_mm256_sqrt_ps((__m256)a);
}

static inline f64x4 f64x4_sqrt(f64x4 a)
{
    return (f64x4)_mm256_sqrt_pd((__m256d)a);
}

/* a * b - c, in a's register: left alone, gcc puts it in b's or c's, of which it then makes a copy
 * first. */
static inline f32x8 f32x8_fused(f32x8 a, f32x8 b, f32x8 c)
{
    __asm__("vfmsub213ps %2, %1, %0" : "+x"(a) : "x"(b), "xm"(c));
    return a;
}

/* Bit i: lane i of a comparison is true. */
static inline uint32_t i32x8_mask(i32x8 m)
{
    return (uint32_t)_mm256_movemask_ps((__m256)m);
}

/* gcc's __builtin_convertvector takes five instructions. */
static inline f64x4 f64x4_of(vec3 v)
{
    return (f64x4)_mm256_cvtps_pd((__m128)v);
}

static inline vec3 f64x4_round(f64x4 v)
{
    return (vec3)_mm256_cvtpd_ps((__m256d)v);
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

static inline uint32_t i64x4_mask(i64x4 m)
{
    return (uint32_t)_mm256_movemask_pd((__m256d)m);
}

/* Lane k: component from[k] of v, below 4. */
static inline vec3 vec3_permute(vec3 v, i32x4 from)
{
    return (vec3)_mm_permutevar_ps((__m128)v, (__m128i)from);
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

static inline u32x8 u32x8_reverse(u32x8 x)
{
    x = x << 16 | x >> 16;
    x = (x & 0x00ff00ff) << 8 | (x >> 8 & 0x00ff00ff);
    x = (x & 0x0f0f0f0f) << 4 | (x >> 4 & 0x0f0f0f0f);
    x = (x & 0x33333333) << 2 | (x >> 2 & 0x33333333);
    return (x & 0x55555555) << 1 | (x >> 1 & 0x55555555);
}

static inline f32x8 f32x8_choose(i32x8 m, f32x8 a, f32x8 b)
{
    return (f32x8)(((i32x8)a & m) | ((i32x8)b & ~m));
}

static inline f32x8 f32x8_spread(f32x8 v, u32x8 lane)
{
    return f32x8_splat(v[lane[0]]);
}

static inline f32x8 f32x8_permute(f32x8 v, u32x8 from)
{
    f32x8 out = v;
    for (int i = 0; i < 8; i++)
        out[i] = v[from[i]];
    return out;
}

static inline f32x8 f32x8_sqrt(f32x8 a)
{
    for (int i = 0; i < 8; i++)
        a[i] = __builtin_sqrtf(a[i]);
    return a;
}

static inline f64x4 f64x4_sqrt(f64x4 a)
{
    for (int i = 0; i < 4; i++)
        a[i] = __builtin_sqrt(a[i]);
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

static inline f64x4 f64x4_of(vec3 v)
{
    return __builtin_convertvector(v, f64x4);
}

static inline vec3 f64x4_round(f64x4 v)
{
    return __builtin_convertvector(v, vec3);
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

static inline uint32_t i64x4_mask(i64x4 m)
{
    uint32_t bits = 0;
    for (int i = 0; i < 4; i++)
        bits |= m[i] < 0 ? 1u << i : 0;
    return bits;
}

static inline vec3 vec3_permute(vec3 v, i32x4 from)
{
    return (vec3){v[from[0]], v[from[1]], v[from[2]], v[from[3]]};
}

static inline i32x4 vec3_truncate(vec3 v)
{
    i32x4 out = {0};
    for (int i = 0; i < 4; i++)
        out[i] = v[i] >= -0x1p30f && v[i] <= 0x1p30f ? (int32_t)v[i] : INT32_MIN;
    return out;
}

#endif

/* The least, the greatest of the eight, in every lane. */
static inline f32x8 f32x8_least(f32x8 v)
{
    v = f32x8_min(v, __builtin_shufflevector(v, v, 4, 5, 6, 7, 0, 1, 2, 3));
    v = f32x8_min(v, __builtin_shufflevector(v, v, 2, 3, 0, 1, 6, 7, 4, 5));
    return f32x8_min(v, __builtin_shufflevector(v, v, 1, 0, 3, 2, 5, 4, 7, 6));
}

static inline f32x8 f32x8_most(f32x8 v)
{
    v = f32x8_max(v, __builtin_shufflevector(v, v, 4, 5, 6, 7, 0, 1, 2, 3));
    v = f32x8_max(v, __builtin_shufflevector(v, v, 2, 3, 0, 1, 6, 7, 4, 5));
    return f32x8_max(v, __builtin_shufflevector(v, v, 1, 0, 3, 2, 5, 4, 7, 6));
}

#endif
