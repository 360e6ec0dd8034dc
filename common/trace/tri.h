/* tri.h - ray against triangle, watertight.
 *
 * S. Woop, C. Benthin, I. Wald, "Watertight Ray/Triangle Intersection", JCGT 2(1), 2013. The ray is
 * sheared onto an axis once; a triangle is then tested by three 2-D edge functions. Two triangles
 * that share an edge compute the same products for it with the terms exchanged, so the values are
 * exact negatives of each other and a ray cannot slip between: true as long as the compiler
 * contracts nothing into a fused multiply-add (tests/test_canary.c).
 *
 * Which side of the surface the origin is on decides what a ray that starts there meets, and whether
 * a wall a hair's breadth away throws its shadow. So t is computed in double from the plane, for the
 * few triangles that pass: there is neither an epsilon nor a bound on errors to stay clear of.
 * SPDX-License-Identifier: MIT */
#ifndef COMMON_TRACE_TRI_H
#define COMMON_TRACE_TRI_H

#include "common/trace/ray.h"
#include "common/trace/round.h"

struct tri_ray {
    vec3 origin;
    int kx, ky, kz;   /* z: the axis along which the ray is longest; x, y keep the winding */
    float sx, sy; /* the shear */
    vec3 dir;
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
    return (struct tri_ray){ray->origin, kx, ky, kz, d[kx] / d[kz], d[ky] / d[kz], d};
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

/* t of the triangle's plane. Differences of floats are exact in double and so are their products, all but
 * always: t is right to a rounding of float, and its sign is, unless the origin is nearer to
 * the plane than 1e-15 of the triangle's distance. */
static inline float tri_plane_t(vec3 origin, vec3 dir, const float v[3][3])
{
    double a[3], e[3], f[3], height = 0, speed = 0;
    for (int k = 0; k < 3; k++) {
        a[k] = (double)v[0][k] - (double)origin[k];
        e[k] = (double)v[1][k] - (double)v[0][k];
        f[k] = (double)v[2][k] - (double)v[0][k];
    }
    for (int k = 0; k < 3; k++) {
        const int i = k == 2 ? 0 : k + 1, j = k == 0 ? 2 : k - 1;
        const double n = e[i] * f[j] - e[j] * f[i];
        height += n * a[k];
        speed += n * (double)dir[k];
    }
    return (float)(height / speed);
}

static inline void tri_bounds(const float v[3][3], float lo[3], float hi[3])
{
    for (int k = 0; k < 3; k++) {
        lo[k] = hi[k] = v[0][k];
        for (int i = 1; i < 3; i++) {
            lo[k] = v[i][k] < lo[k] ? v[i][k] : lo[k];
            hi[k] = v[i][k] > hi[k] ? v[i][k] : hi[k];
        }
    }
}

/* None lies on the other side than the others. A NaN does. */
static inline bool tri_inside(float e0, float e1, float e2)
{
    return (e0 >= 0 && e1 >= 0 && e2 >= 0) || (e0 <= 0 && e1 <= 0 && e2 <= 0);
}

/* Both faces, at any t > 0. Comparisons are written so that a NaN is a miss. */
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
    if (!tri_inside(e0, e1, e2))
        return false;
    const float det = e0 + e1 + e2;
    if (det == 0) /* seen edge-on */
        return false;
    const float t = tri_plane_t(r->origin, r->dir, v);
    if (!(t > 0))
        return false;
    *out = (struct tri_found){t, e1 / det, e2 / det};
    return true;
}

#endif
