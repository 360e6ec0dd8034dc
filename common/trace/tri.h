/* tri.h - ray against triangle, watertight.
 *
 * S. Woop, C. Benthin, I. Wald, "Watertight Ray/Triangle Intersection", JCGT 2(1), 2013. Vertices are
 * moved to the ray's origin and sheared so that the ray becomes an axis; what is left is whether
 * three 2-D edge functions have the same sign. Two triangles that share an edge compute the same two
 * products for it in the other order, and rounding is monotone: the sign of their difference is
 * either right or zero for both, and zero counts as inside. So no ray passes between them, as long
 * as the compiler contracts nothing into a fused multiply-add (tests/test_canary.c).
 *
 * Ours differs in being done in double: with differences of floats nearly nothing is rounded, so a
 * hit is where the exact ray meets the exact triangle to about 2^-48. Boxes need no slack for
 * the shear, slivers give no hits beside themselves, and a ray that starts an ulp off its
 * own surface is seen to. The paper's float version saves a tenth of the time at best.
 * SPDX-License-Identifier: MIT */
#ifndef COMMON_TRACE_TRI_H
#define COMMON_TRACE_TRI_H

#include "common/trace/ray.h"

struct tri_ray {
    int x, y, z; /* z: the axis along which the ray is longest; then cyclic */
    double ox, oy, oz, dx, dy, dz;
};

static inline struct tri_ray tri_ray_make(const struct ray *r)
{
    const vec3 d = r->dir;
    const float ax = __builtin_fabsf(d[0]), ay = __builtin_fabsf(d[1]), az = __builtin_fabsf(d[2]);
    const int z = ax > ay ? (ax > az ? 0 : 2) : (ay > az ? 1 : 2);
    const int x = z == 2 ? 0 : z + 1, y = x == 2 ? 0 : x + 1;
    const vec3 o = r->origin;
    return (struct tri_ray){x,            y,            z,            (double)o[x], (double)o[y],
                            (double)o[z], (double)d[x], (double)d[y], (double)d[z]};
}

/* Twice the signed area of (0, a, b): antisymmetric in a and b to the last bit. */
static inline double tri_edge(double ax, double ay, double bx, double by)
{
    return ax * by - ay * bx;
}

static inline double tri_max3(double a, double b, double c)
{
    a = __builtin_fabs(a);
    b = __builtin_fabs(b);
    c = __builtin_fabs(c);
    const double m = a > b ? a : b;
    return m > c ? m : c;
}

/* Is sum > 0 beyond doubt? sum = e0 z0 + e1 z1 + e2 z2, with the sign of t. When all z_i have the
 * ray's sign there is nothing to doubt: t is their mean with weights of one sign. Else it is held
 * against a bound on its error: M. Pharr, W. Jakob, G. Humphreys, "Physically Based
 * Rendering", 4th ed., section 6.8.7, for our order of operations. With x, y, z the greatest
 * |coordinates|, sheared ones being products x dz: each coordinate passed 4 roundings (relative to
 * x + z, since |dx| <= |dz|), an edge function 2 * 4 + 2, sum 2 * 4 + 2 + 1 + 3 = 14 at most. */
static inline bool tri_in_front(const struct tri_ray *r, const double x[3], const double y[3],
                                const double z[3], double sum)
{
    const double s = r->dz > 0 ? 1 : -1;
    if (s * z[0] > 0 && s * z[1] > 0 && s * z[2] > 0)
        return true;
    const double d = __builtin_fabs(r->dz), mz = tri_max3(z[0], z[1], z[2]);
    const double mx = tri_max3(x[0], x[1], x[2]) + 2 * d * mz;
    const double my = tri_max3(y[0], y[1], y[2]) + 2 * d * mz;
    return sum > 14 * 0x1p-53 * (3 * 2 * mx * my * mz);
}

/* Both faces; 0 < t <= t_max: among equals the caller decides. Comparisons are written so that a NaN
 * is a miss. *hit is changed even by a miss. */
static inline bool tri_hit(const struct tri_ray *r, const float v[3][3], float t_max,
                           struct ray_hit *hit)
{
    double x[3], y[3], z[3];
    for (int i = 0; i < 3; i++) {
        z[i] = (double)v[i][r->z] - r->oz;
        x[i] = ((double)v[i][r->x] - r->ox) * r->dz - z[i] * r->dx;
        y[i] = ((double)v[i][r->y] - r->oy) * r->dz - z[i] * r->dy;
    }
    const double e0 = tri_edge(x[1], y[1], x[2], y[2]);
    const double e1 = tri_edge(x[2], y[2], x[0], y[0]);
    const double e2 = tri_edge(x[0], y[0], x[1], y[1]);
    if ((e0 < 0 || e1 < 0 || e2 < 0) && (e0 > 0 || e1 > 0 || e2 > 0))
        return false;
    const double det = e0 + e1 + e2;
    const double sum = e0 * z[0] + e1 * z[1] + e2 * z[2];
    const double t = sum / (det * r->dz); /* NaN or infinite when det is 0 */
    hit->t = (float)t;
    if (!(hit->t > 0 && hit->t <= t_max))
        return false;
    if (!tri_in_front(r, x, y, z, __builtin_fabs(sum)))
        return false;
    hit->u = (float)(e1 / det);
    hit->v = (float)(e2 / det);
    return true;
}

#endif
