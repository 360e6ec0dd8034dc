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
    vec3 origin, dir;
    int kx, ky, kz;   /* z: the axis along which the ray is longest; x, y keep the winding */
    float sx, sy;     /* the shear */
    float ox, oy, oz; /* the origin along kx, ky, kz */
    f64x4 o, d;       /* origin and dir once more */
};

/* The axes of a ray: kx, ky, kz in a byte each. compared: bit 0: |y| >= |x|, 1: |z| >= |y|, 2: |z|
 * >= |x|; negative: bit k: component k is below 0. A table, since branches would be mispredicted
 * more often than not. */
static inline void tri_axes(uint32_t compared, uint32_t negative, int *kx, int *ky, int *kz)
{
    static const unsigned char longest[8] = {0, 1, 0, 2, 2, 1, 2, 2};
    static const unsigned char next[6] = {1, 2, 2, 0, 0, 1}; /* x, y of an axis; for -z exchanged */
    const uint32_t z = longest[compared], back = negative >> z & 1;
    *kx = next[2 * z + back];
    *ky = next[2 * z + (back ^ 1)];
    *kz = (int)z;
}

static inline struct tri_ray tri_ray_make(vec3 origin, vec3 dir)
{
    const vec3 a = vec3_abs(dir), none = {0};
    const i32x4 compared =
        __builtin_shufflevector(a, a, 1, 2, 2, 3) >= __builtin_shufflevector(a, a, 0, 1, 0, 3);
    int kx, ky, kz;
    tri_axes(i32x4_mask(compared) & 7, i32x4_mask(dir < none), &kx, &ky, &kz);
    return (struct tri_ray){.origin = origin,
                            .dir = dir,
                            .kx = kx,
                            .ky = ky,
                            .kz = kz,
                            .sx = dir[kx] / dir[kz],
                            .sy = dir[ky] / dir[kz],
                            .ox = origin[kx],
                            .oy = origin[ky],
                            .oz = origin[kz],
                            .o = f64x4_of(origin),
                            .d = f64x4_of(dir)};
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

/* t of the triangle's plane. Differences of floats are exact in double and so are their products,
 * all but always: t is right to a rounding of float, and its sign is, unless the origin is nearer
 * to the plane than 1e-15 of the triangle's distance. A NaN for a ray in the plane. */
static inline float tri_plane_t(const struct tri_ray *r, const struct stage_triangle *t)
{
    const double px = (double)t->v[0][0], py = (double)t->v[0][1], pz = (double)t->v[0][2];
    const double ex = (double)t->v[1][0] - px, ey = (double)t->v[1][1] - py,
                 ez = (double)t->v[1][2] - pz;
    const double fx = (double)t->v[2][0] - px, fy = (double)t->v[2][1] - py,
                 fz = (double)t->v[2][2] - pz;
    const double nx = ey * fz - ez * fy, ny = ez * fx - ex * fz, nz = ex * fy - ey * fx;
    const double height = nx * (px - r->o[0]) + ny * (py - r->o[1]) + nz * (pz - r->o[2]);
    const double speed = nx * r->d[0] + ny * r->d[1] + nz * r->d[2];
    return (float)(height / speed);
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
    const vec3 a = vec3_load(t->v[0]) - r->origin, b = vec3_load(t->v[1]) - r->origin,
               c = vec3_load(t->v[2]) - r->origin;
    const float ax = a[r->kx] - r->sx * a[r->kz], ay = a[r->ky] - r->sy * a[r->kz];
    const float bx = b[r->kx] - r->sx * b[r->kz], by = b[r->ky] - r->sy * b[r->kz];
    const float cx = c[r->kx] - r->sx * c[r->kz], cy = c[r->ky] - r->sy * c[r->kz];
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
