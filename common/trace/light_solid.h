/* light_solid.h - triangles as lights that are near: points chosen uniformly in the solid angle
 * they fill.
 *
 * J. Arvo, "Stratified Sampling of Spherical Triangles", SIGGRAPH 1995, in the terms of C. Peters,
 * "BRDF Importance Sampling for Polygonal Lights", ACM TOG 40(4), 2021: no angle of the triangle is
 * computed, so none is lost to cancellation. Let a, b, c be the unit directions to its corners and
 *
 *     g0 = a . (b x c),   g1 = (a + b) . c,   g2 = 1 + a . b.
 *
 * Its solid angle is 2 atan2(g0, g1 + g2) (A. van Oosterom, J. Strackee, "The Solid Angle of a
 * Plane Triangle", IEEE Trans. Biomed. Eng. 30(2), 1983). Let c wander from b to where it is: the
 * triangle up to it has the angle 2 phi when c' is b mirrored at the direction
 *
 *     (g0 cos phi - g1 sin phi) b + (g2 sin phi) c,
 *
 * which follows from the same formula, since b + c' lies along the mirror. u of the square chooses
 * c', and v a place between a and c', linear in the cosine from a. (Roles: a stays, b wanders to
 * c.)
 *
 * A flat quad is a fan of two triangles that share a, and the second's b is the first's c: all of
 * it is chosen from uniformly, and u wanders from one side of it to the other.
 *
 * It pays where the light is near (docs/design.md): at contact, area sampling has an infinite
 * variance. All in double.
 * SPDX-License-Identifier: MIT */
#ifndef COMMON_TRACE_LIGHT_SOLID_H
#define COMMON_TRACE_LIGHT_SOLID_H

#include "common/trace/fmath.h"
#include "common/trace/simd.h"
#include "common/trace/sobol.h"
#include "common/trace/stage.h"

/* In radii of the triangle, or of the quad whose half it is. */
#define LIGHT_SOLID_NEAR 1.5f

struct light_solid { /* a triangle, or two that share corner 0, as seen from a point */
    f64x4 to[4];     /* unit directions to the corners; the second triangle's are 0, 2 and 3 */
    f64x4 inverse;   /* of their distances */
    double g[2][3];
    double half[2]; /* of the solid angles; 0: nothing of the front is seen */
};

/* Whether it is near the point, and the point before it. middle, near_dd: the emitter's. */
static inline bool light_solid_is_near(vec3 middle, float near_dd, vec3 ng, vec3 p)
{
    const vec3 d = middle - p;
    return vec3_dot(d, d) < near_dd && vec3_dot(d, ng) < 0;
}

static inline double light_solid_dot(f64x4 a, f64x4 b)
{
    const f64x4 c = a * b;
    return c[0] + c[1] + c[2];
}

static inline void light_solid_look(struct light_solid *s, uint32_t i)
{
    const f64x4 a = s->to[0], b = s->to[1 + i], c = s->to[2 + i];
    double *g = s->g[i];
    g[0] = -light_solid_dot(a, f64x4_cross(b, c)); /* the front is seen: clockwise */
    g[1] = light_solid_dot(a + b, c);
    g[2] = 1 + light_solid_dot(a, b);
    s->half[i] = g[0] > 0 ? fmath_atan2_wide(g[0], g[1] + g[2]) : 0;
}

/* count: of corners, 3 or 4; all four are read. */
static inline struct light_solid light_solid_make(const vec3 corners[4], uint32_t count, vec3 from)
{
    struct light_solid s = {.half = {0, 0}};
    f64x4 dd = {0};
    for (int i = 0; i < 4; i++) {
        s.to[i] = f64x4_of(corners[i]) - f64x4_of(from);
        dd[i] = light_solid_dot(s.to[i], s.to[i]);
    }
    s.inverse = 1 / f64x4_sqrt(dd);
    for (int i = 0; i < 4; i++)
        s.to[i] *= s.inverse[i];
    light_solid_look(&s, 0);
    if (count > 3)
        light_solid_look(&s, 1);
    return s;
}

struct light_solid_place {
    uint32_t triangle; /* 0, 1 */
    struct square b;   /* weights of its corners 1 and 2 */
};

/* u, v in [0, 1). */
static inline struct light_solid_place light_solid_sample(const struct light_solid *s, double u,
                                                          double v)
{
    const double place = u * (s->half[0] + s->half[1]);
    const uint32_t i = s->half[1] > 0 && place >= s->half[0];
    const f64x4 a = s->to[0], b = s->to[1 + i], c = s->to[2 + i];
    const double *g = s->g[i];
    double sine, cosine;
    fmath_sincos_wide(i ? place - s->half[0] : place, &sine, &cosine);
    const double of_b = g[0] * cosine - g[1] * sine, of_c = g[2] * sine;
    const f64x4 mirror = b * of_b + c * of_c;
    const double k = 2 * light_solid_dot(b, mirror) / light_solid_dot(mirror, mirror);
    const f64x4 end = mirror * k - b, way = end - a;
    /* The direction is (1 - down - t (1 - most)) a + t end; most and down: 1 - its cosine from a,
     * at the end and at the place chosen */
    const double most = light_solid_dot(way, way) / 2, down = v * most;
    const double t = __builtin_sqrt(v * (2 - down) / (2 - most));
    const double wa = (1 - t - (down - t * most)) * s->inverse[0];
    const double wb = t * (k * of_b - 1) * s->inverse[1 + i], wc = t * k * of_c * s->inverse[2 + i];
    const double sum = wa + wb + wc;
    const double first = wb > 0 ? wb / sum : 0, second = wc > 0 ? wc / sum : 0;
    return (struct light_solid_place){
        i, {(float)first, (float)(first + second < 1 ? second : 1 - first)}};
}

#endif
