/* tri.h - ray against triangle, watertight.
 *
 * S. Woop, C. Benthin, I. Wald, "Watertight Ray/Triangle Intersection", JCGT 2(1), 2013. The ray is
 * sheared onto an axis once; a triangle is then tested by three 2-D edge functions. Two triangles
 * that share an edge compute the same products for it with the terms exchanged, so the values are
 * exact negatives of each other and a ray cannot slip between: true as long as the compiler
 * contracts nothing into a fused multiply-add (tests/test_canary.c).
 *
 * t > 0 is decided against a bound on the rounding error of t, after M. Pharr, W. Jakob, G. Humphreys,
 * "Physically Based Rendering", 4th ed., section 6.8.7: a hit closer to the origin than that does not
 * count. There is no epsilon.
 * SPDX-License-Identifier: MIT */
#ifndef COMMON_TRACE_TRI_H
#define COMMON_TRACE_TRI_H

#include "common/trace/ray.h"
#include "common/trace/round.h"

struct tri_ray {
    vec3 origin;
    int kx, ky, kz;   /* z: the axis along which the ray is longest; x, y keep the winding */
    float sx, sy, sz; /* the shear */
    float t_max;
};

struct tri_found {
    float t;
    float u, v; /* weights of vertices 1 and 2 */
};

static inline struct tri_ray tri_ray_make(const struct ray *ray)
{
    const vec3 d = ray->dir;
    const float ax = __builtin_fabsf(d[0]), ay = __builtin_fabsf(d[1]), az = __builtin_fabsf(d[2]);
    const int kz = ax > ay ? (ax > az ? 0 : 2) : (ay > az ? 1 : 2);
    int kx = kz == 2 ? 0 : kz + 1, ky = kx == 2 ? 0 : kx + 1;
    if (d[kz] < 0) {
        const int k = kx;
        kx = ky;
        ky = k;
    }
    return (struct tri_ray){ray->origin, kx, ky, kz, d[kx] / d[kz], d[ky] / d[kz],
                            1 / d[kz],   ray->t_max};
}

/* Twice the signed area of (0, a, b): antisymmetric in a and b to the last bit. */
static inline float tri_edge(float ax, float ay, float bx, float by)
{
    return ax * by - ay * bx;
}

/* A float edge function that is exactly zero may hide a sign; doubles hold the products exactly. */
static inline float tri_edge_exact(float ax, float ay, float bx, float by)
{
    return (float)((double)ax * (double)by - (double)ay * (double)bx);
}

static inline float tri_max3(float a, float b, float c)
{
    a = __builtin_fabsf(a);
    b = __builtin_fabsf(b);
    c = __builtin_fabsf(c);
    const float m = a > b ? a : b;
    return m > c ? m : c;
}

/* Bound on the absolute error of t = (u az + v bz + w cz) / det. */
static inline float tri_t_error(float x, float y, float z, float e, float det)
{
    const float dz = round_gamma(3) * z;
    const float dx = round_gamma(5) * (x + z);
    const float dy = round_gamma(5) * (y + z);
    const float de = 2 * (round_gamma(2) * x * y + dy * x + dx * y);
    return 3 * (round_gamma(3) * e * z + de * z + dz * e) / __builtin_fabsf(det);
}

/* Both faces. Comparisons are written so that a NaN is a miss. t == t_max is accepted: the caller
 * decides among equals. */
static inline bool tri_hit(const struct tri_ray *r, const float v[3][3], struct tri_found *out)
{
    const vec3 a = vec3_load(v[0]) - r->origin;
    const vec3 b = vec3_load(v[1]) - r->origin;
    const vec3 c = vec3_load(v[2]) - r->origin;
    const float ax = a[r->kx] - r->sx * a[r->kz], ay = a[r->ky] - r->sy * a[r->kz];
    const float bx = b[r->kx] - r->sx * b[r->kz], by = b[r->ky] - r->sy * b[r->kz];
    const float cx = c[r->kx] - r->sx * c[r->kz], cy = c[r->ky] - r->sy * c[r->kz];
    float e0 = tri_edge(cx, cy, bx, by);
    float e1 = tri_edge(ax, ay, cx, cy);
    float e2 = tri_edge(bx, by, ax, ay);
    if (e0 == 0 || e1 == 0 || e2 == 0) {
        e0 = tri_edge_exact(cx, cy, bx, by);
        e1 = tri_edge_exact(ax, ay, cx, cy);
        e2 = tri_edge_exact(bx, by, ax, ay);
    }
    if ((e0 < 0 || e1 < 0 || e2 < 0) && (e0 > 0 || e1 > 0 || e2 > 0))
        return false;
    const float det = e0 + e1 + e2;
    const float az = r->sz * a[r->kz], bz = r->sz * b[r->kz], cz = r->sz * c[r->kz];
    const float t = (e0 * az + e1 * bz + e2 * cz) / det;
    if (!(t > 0 && t <= r->t_max)) /* also det == 0: t is NaN or infinite */
        return false;
    const float error = tri_t_error(tri_max3(ax, bx, cx), tri_max3(ay, by, cy),
                                    tri_max3(az, bz, cz), tri_max3(e0, e1, e2), det);
    if (!(t > error))
        return false;
    *out = (struct tri_found){t, e1 / det, e2 / det};
    return true;
}

#endif
