/* tri.h - ray against triangle, watertight.
 *
 * S. Woop, C. Benthin, I. Wald, "Watertight Ray/Triangle Intersection", JCGT 2(1), 2013. The ray is
 * sheared onto an axis once; a triangle is then tested by three 2-D edge functions. Two triangles
 * that share an edge compute the same products for it with the terms exchanged, so the values are
 * exact negatives of each other and a ray cannot slip between: true as long as the compiler
 * contracts nothing into a fused multiply-add (tests/test_canary.c).
 *
 * Which side of the surface the origin is on decides what a ray that starts there meets, and
 * whether a wall a hair's breadth away throws its shadow. So t is computed in double from the
 * plane, for the few triangles that pass: there is neither an epsilon nor a bound on errors to stay
 * clear of. SPDX-License-Identifier: MIT */
#ifndef COMMON_TRACE_TRI_H
#define COMMON_TRACE_TRI_H

#include "common/trace/ray.h"
#include "common/trace/simd.h"

struct tri_ray {
    const struct ray *ray;
    i32x4 row; /* 8 * the axis, in order kx, ky, kz: z is that along which the ray is longest, x and
                * y keep the winding; so many floats into a struct stage_block's vertex it begins */
    vec3 at;   /* the origin along these axes */
    vec3 shear; /* dir along kx, ky / dir along kz; then 1, a NaN for no direction at all; and 1 /
                 * dir along kz */
};

/* The axes of a ray, its longest one last. A table, since branches would be mispredicted more
 * often than not. */
static inline i32x4 tri_axes(vec3 dir)
{
    static const unsigned char longest[8] = {0, 1, 0, 2, 2, 1, 2, 2};
    static const i32x4 axes[6] = {{1, 2, 0, 3}, {2, 1, 0, 3}, {2, 0, 1, 3},
                                  {0, 2, 1, 3}, {0, 1, 2, 3}, {1, 0, 2, 3}};
    const vec3 a = vec3_abs(dir), none = {0};
    /* bit 0: |y| >= |x|, 1: |z| >= |y|, 2: |z| >= |x| */
    const i32x4 compared =
        __builtin_shufflevector(a, a, 1, 2, 2, 3) >= __builtin_shufflevector(a, a, 0, 1, 0, 3);
    const uint32_t z = longest[i32x4_mask(compared) & 7];
    const uint32_t back = i32x4_mask(dir < none) >> z & 1; /* x and y exchanged */
    return axes[2 * z + back];
}

/* The ray must stay where it is. */
static inline struct tri_ray tri_ray_make(const struct ray *ray)
{
    const i32x4 k = tri_axes(ray->dir);
    vec3 d = vec3_permute(ray->dir, k);
    const float longest = d[2];
    d[3] = 1;
    return (struct tri_ray){ray, STAGE_LANES * k, vec3_permute(ray->origin, k), d / longest};
}

/* Eight at once: row, at and shear of each. */
struct tri_rays {
    i32x4 row[8];
    vec3 at[8], shear[8];
};

/* Lane by lane v[k] for the axis k along which the ray is longest, and the two after it: by z2 (it
 * is 2) and z1 (it is 1), and y before x where `back`. */
static inline void tri_rays_permute(const f32x8 v[3], i32x8 z2, i32x8 z1, i32x8 back, f32x8 out[3])
{
    const f32x8 x = f32x8_choose(z2, v[0], f32x8_choose(z1, v[2], v[1]));
    const f32x8 y = f32x8_choose(z2, v[1], f32x8_choose(z1, v[0], v[2]));
    out[0] = f32x8_choose(back, y, x);
    out[1] = f32x8_choose(back, x, y);
    out[2] = f32x8_choose(z2, v[2], f32x8_choose(z1, v[1], v[0]));
}

/* As tri_ray_make. */
static inline void tri_rays_make(const f32x8 origin[3], const f32x8 dir[3], struct tri_rays *r)
{
    const f32x8 x = f32x8_abs(dir[0]), y = f32x8_abs(dir[1]), z = f32x8_abs(dir[2]), none = {0};
    const i32x8 z2 = (z >= y) & (z >= x), z1 = y >= x;
    const f32x8 longest = f32x8_choose(z2, dir[2], f32x8_choose(z1, dir[1], dir[0]));
    const i32x8 back = longest < none;
    const f32x8 rows[3] = {none, f32x8_splat(STAGE_LANES), f32x8_splat(2 * STAGE_LANES)};
    vec3 row[8];
    f32x8 at[3], d[3], k[3];
    tri_rays_permute(origin, z2, z1, back, at);
    tri_rays_permute(dir, z2, z1, back, d);
    tri_rays_permute(rows, z2, z1, back, k);
    f32x8_rows(at[0], at[1], at[2], none, r->at);
    f32x8_rows(d[0] / longest, d[1] / longest, longest / longest, 1 / longest, r->shear);
    f32x8_rows(k[0], k[1], k[2], none, row);
    for (int i = 0; i < 8; i++)
        r->row[i] = vec3_truncate(row[i]);
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

/* t of the triangle's plane, or 0 where it is not above 0. Differences of floats are exact in
 * double and so are their products, all but always: t is right to a rounding of float, and its sign
 * is, unless the origin is nearer to the plane than 1e-15 of the triangle's distance. A NaN for a
 * ray in the plane. */
static inline float tri_plane_t(const struct tri_ray *r, const struct stage_triangle *t)
{
    const f64x4 p = f64x4_of(vec3_load(t->v[0]));
    const f64x4 n = f64x4_cross(f64x4_of(vec3_load(t->v[1])) - p, f64x4_of(vec3_load(t->v[2])) - p);
    const f64x4 height = n * (p - f64x4_of(r->ray->origin)), speed = n * f64x4_of(r->ray->dir);
    const double up = height[0] + height[1] + height[2], along = speed[0] + speed[1] + speed[2];
    if ((up > 0) != (along > 0)) /* not positive: known before the quotient is */
        return 0;
    return (float)(up / along);
}

static inline void tri_bounds(const struct stage_triangle *t, vec3 *lo, vec3 *hi)
{
    const vec3 a = vec3_load(t->v[0]), b = vec3_load(t->v[1]), c = vec3_load(t->v[2]);
    *lo = vec3_min(vec3_min(a, b), c);
    *hi = vec3_max(vec3_max(a, b), c);
}

/* Three edge functions: ei is of the edge that vertex i is not on. */
struct tri_edges {
    float e0, e1, e2;
};

/* None lies on the other side than the others. A NaN does. */
static inline bool tri_inside(struct tri_edges e)
{
    return (e.e0 >= 0 && e.e1 >= 0 && e.e2 >= 0) || (e.e0 <= 0 && e.e1 <= 0 && e.e2 <= 0);
}

static inline struct tri_edges tri_edges_make(const struct tri_ray *r,
                                              const struct stage_triangle *t)
{
    const vec3 o = r->ray->origin;
    const vec3 a = vec3_load(t->v[0]) - o, b = vec3_load(t->v[1]) - o, c = vec3_load(t->v[2]) - o;
    const int kx = r->row[0] / STAGE_LANES, ky = r->row[1] / STAGE_LANES,
              kz = r->row[2] / STAGE_LANES;
    const float sx = r->shear[0], sy = r->shear[1];
    const float ax = a[kx] - sx * a[kz], ay = a[ky] - sy * a[kz];
    const float bx = b[kx] - sx * b[kz], by = b[ky] - sy * b[kz];
    const float cx = c[kx] - sx * c[kz], cy = c[ky] - sy * c[kz];
    const struct tri_edges e = {tri_edge(cx, cy, bx, by), tri_edge(ax, ay, cx, cy),
                                tri_edge(bx, by, ax, ay)};
    if (e.e0 != 0 && e.e1 != 0 && e.e2 != 0)
        return e;
    return (struct tri_edges){tri_edge_exact(cx, cy, bx, by), tri_edge_exact(ax, ay, cx, cy),
                              tri_edge_exact(bx, by, ax, ay)};
}

/* Both faces. Seen edge-on, it is not hit. */
static inline bool tri_meets(struct tri_edges e)
{
    return tri_inside(e) && e.e0 + e.e1 + e.e2 != 0;
}

/* Weights of vertices 1 and 2. */
static inline void tri_weights(struct tri_edges e, float *u, float *v)
{
    const float det = e.e0 + e.e1 + e.e2;
    *u = e.e1 / det;
    *v = e.e2 / det;
}

#endif
