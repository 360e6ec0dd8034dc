/* half.h - numbers of 16 bits (IEEE 754 binary16), as textures keep them. Finite ones only.
 * SPDX-License-Identifier: MIT */
#ifndef COMMON_TRACE_HALF_H
#define COMMON_TRACE_HALF_H

#include <string.h>

#include "common/base.h"

#define HALF_MAX 65504.f

/* Exact: a half's bits, moved up, are a float too small by 2^112, subnormal ones included. */
static inline float half_load(uint16_t h)
{
    const uint32_t bits = (uint32_t)(h & 0x7fff) << 13;
    float f;
    memcpy(&f, &bits, sizeof f);
    return h & 0x8000 ? f * -0x1p112f : f * 0x1p112f;
}

/* To the nearest, ties to even; what is larger than the largest becomes it. */
static inline uint16_t half_make(float f)
{
    const uint16_t sign = f < 0 ? 0x8000 : 0;
    const float size = f < 0 ? -f : f;
    if (size >= HALF_MAX)
        return sign | 0x7bff;
    if (size < 0x1p-14f) { /* multiples of 2^-24, which this sum rounds to */
        const float steps = (size * 0x1p24f + 0x1p23f) - 0x1p23f;
        return (uint16_t)(sign | (uint32_t)steps);
    }
    uint32_t bits;
    memcpy(&bits, &size, sizeof bits);
    bits += 0xfff + (bits >> 13 & 1); /* 13 bits go */
    return (uint16_t)(sign | (bits - (112u << 23)) >> 13);
}

#endif
