/* warp.h - maps from the unit square, each beside its pdf.
 *
 * All keep the square's stratification: they are continuous and bend it little. pdf_w is per
 * steradian, pdf_a per unit area. Any point of [0, 1)^2 gives a finite result.
 * SPDX-License-Identifier: MIT */
#ifndef COMMON_TRACE_WARP_H
#define COMMON_TRACE_WARP_H

#include "common/trace/fmath.h"
#include "common/trace/simd.h"
#include "common/trace/sobol.h"

struct warp_frame { /* right-handed, orthonormal: x, y, z as seen from outside */
    vec3 x, y, z;
};

/* T. Duff et al., "Building an Orthonormal Basis, Revisited", JCGT 6(1), 2017. z: unit. */
static inline struct warp_frame warp_frame_make(vec3 z)
{
    const vec3 one = vec3_make(1, 1, 1), none = vec3_make(0, 0, 0);
    const float sign = vec3_choose(z < none, -one, one)[2]; /* no branch: it is as likely as not */
    const float a = -1 / (sign + z[2]);
    const float b = z[0] * z[1] * a;
    return (struct warp_frame){
        .x = vec3_make(1 + sign * z[0] * z[0] * a, sign * b, -sign * z[0]),
        .y = vec3_make(b, sign + z[1] * z[1] * a, -z[1]),
        .z = z,
    };
}

static inline vec3 warp_to_local(const struct warp_frame *f, vec3 v)
{
    return vec3_make(vec3_dot(v, f->x), vec3_dot(v, f->y), vec3_dot(v, f->z));
}

static inline vec3 warp_to_world(const struct warp_frame *f, vec3 v)
{
    return f->x * v[0] + f->y * v[1] + f->z * v[2];
}

/* The unit disc, pdf_a 1 / pi; z is 0. P. Shirley, K. Chiu, "A Low Distortion Map Between Disk and
 * Square", JGT 2(3), 1997. */
static inline vec3 warp_disc(struct square q)
{
    const float a = 2 * q.u - 1, b = 2 * q.v - 1; /* exact */
    const i32x4 wide =
        (i32x4){0} - (a * a > b * b); /* of all lanes: which it is nobody can guess */
    const vec3 most = vec3_choose(wide, vec3_make(a, b, 0), vec3_make(b, a, 0));
    if (most[0] == 0)
        return vec3_make(0, 0, 0);
    float s, c;
    fmath_sincos_octant(0.5f * FMATH_HALF_PI * (most[1] / most[0]), &s, &c);
    const vec3 d = most[0] * vec3_choose(wide, vec3_make(c, s, 0), vec3_make(s, c, 0));
    return vec3_make(d[0], d[1], 0);
}

/* The regular polygon of n corners (3 to 64) on the unit circle, the first one on x; z is 0; pdf_a
 * 2 / (n sin(2 pi / n)). u goes around, v outwards: slices from the middle to an edge. */
static inline vec3 warp_polygon(struct square q, uint32_t n)
{
    const float around = q.u * (float)n; /* below n: 1 - 2^-24 times n never rounds to n */
    const uint32_t slice = (uint32_t)around;
    const float along = around - (float)slice, out = __builtin_sqrtf(q.v);
    float s[2], c[2];
    for (uint32_t i = 0; i < 2; i++)
        fmath_sincos_turns((float)(slice + i) / (float)n, &s[i], &c[i]);
    return vec3_make(out * (c[0] + along * (c[1] - c[0])), out * (s[0] + along * (s[1] - s[0])), 0);
}

/* The hemisphere around z, pdf_w cos / pi: the disc, lifted (Malley's method). */
static inline vec3 warp_cosine(struct square q)
{
    const vec3 d = warp_disc(q);
    const float zz = 1 - d[0] * d[0] - d[1] * d[1];
    return vec3_make(d[0], d[1], __builtin_sqrtf(zz > 0 ? zz : 0));
}

static inline float warp_cosine_pdf_w(float cos)
{
    return cos * FMATH_INV_PI;
}

/* The cap of directions around z with 1 - cos <= k, k in (0, 2]. k = 2 is the whole sphere. k, and
 * not the cosine, is the parameter because 1 - cos of a small cap has no digits left in float. */
static inline vec3 warp_cap(struct square q, float k)
{
    const float m = k * q.u; /* 1 - cos */
    const float r = __builtin_sqrtf(m * (2 - m));
    float s, c;
    fmath_sincos_turns(q.v, &s, &c);
    return vec3_make(r * c, r * s, 1 - m);
}

static inline float warp_cap_pdf_w(float k)
{
    return 0.5f * FMATH_INV_PI / k;
}

/* Weights of vertices 1 and 2, uniform on the triangle; pdf_a 1 / area. E. Heitz, "A Low-Distortion
 * Map Between Triangle and Square", 2019 (https://hal.science/hal-02073696). */
static inline struct square warp_triangle(struct square q)
{
    if (q.v > q.u)
        return (struct square){0.5f * q.u, q.v - 0.5f * q.u};
    return (struct square){q.u - 0.5f * q.v, 0.5f * q.v};
}

#endif
