/* vec.h - three floats with the operators of the paper.
 *
 * `vec3` is a GCC/Clang vector type: + - * / work lane by lane and with a scalar.
 * Lane 3 is never read. In memory that is stored or sent, use float[3] through
 * vec3_load / vec3_store.
 * SPDX-License-Identifier: MIT */
#ifndef COMMON_VEC_H
#define COMMON_VEC_H

#include "common/base.h"

typedef float vec3 __attribute__((vector_size(16)));

static inline vec3 vec3_make(float x, float y, float z)
{
    return (vec3){x, y, z, 0};
}

static inline vec3 vec3_load(const float v[3])
{
    return (vec3){v[0], v[1], v[2], 0};
}

static inline void vec3_store(float out[3], vec3 v)
{
    out[0] = v[0];
    out[1] = v[1];
    out[2] = v[2];
}

static inline float vec3_dot(vec3 a, vec3 b)
{
    const vec3 p = a * b;
    return p[0] + p[1] + p[2];
}

static inline vec3 vec3_cross(vec3 a, vec3 b)
{
    return vec3_make(a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2],
                     a[0] * b[1] - a[1] * b[0]);
}

/* IEEE square root: one correctly rounded instruction everywhere, unlike libm's functions. */
static inline float vec3_length(vec3 v)
{
    return __builtin_sqrtf(vec3_dot(v, v));
}

static inline vec3 vec3_unit(vec3 v)
{
    return v / vec3_length(v);
}

/* 3 x 4 affine map, row-major: point p -> m[.][0..2] p + m[.][3]. */
struct xform {
    float m[3][4];
};

static inline struct xform xform_identity(void)
{
    return (struct xform){{{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}}};
}

static inline vec3 xform_vector(const struct xform *x, vec3 v)
{
    return vec3_make(x->m[0][0] * v[0] + x->m[0][1] * v[1] + x->m[0][2] * v[2],
                     x->m[1][0] * v[0] + x->m[1][1] * v[1] + x->m[1][2] * v[2],
                     x->m[2][0] * v[0] + x->m[2][1] * v[1] + x->m[2][2] * v[2]);
}

static inline vec3 xform_point(const struct xform *x, vec3 p)
{
    return xform_vector(x, p) + vec3_make(x->m[0][3], x->m[1][3], x->m[2][3]);
}

#endif
