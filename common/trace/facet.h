/* facet.h - GGX facets that are wider along one tangent than along the other.
 *
 * What microfacet.h is for one width (papers there; E. Heitz, section 5.4, for two), for surfaces
 * brushed along a tangent: slopes along x are spread by a.x, along y by a.y, both above 0. With
 *     S(w) = |(a.x w.x, a.y w.y, w.z)|
 * the masking functions are those of microfacet.h, and equal widths give its values.
 *
 * Directions are local: z the macroscopic normal, x and y the tangents that the widths belong to;
 * all z > 0.
 * SPDX-License-Identifier: MIT */
#ifndef COMMON_TRACE_FACET_H
#define COMMON_TRACE_FACET_H

#include "common/trace/fmath.h"
#include "common/trace/sobol.h"
#include "common/vec.h"

struct facet {
    float x, y;
};

static inline vec3 facet_stretch(vec3 w, struct facet a)
{
    return vec3_make(a.x * w[0], a.y * w[1], w[2]);
}

static inline float facet_s(vec3 w, struct facet a)
{
    return vec3_length(facet_stretch(w, a));
}

/* D(m): facets' area per macroscopic area and solid angle of their normal m. */
static inline float facet_d(vec3 m, struct facet a)
{
    const float area = a.x * a.y;
    const float t = (m[0] * m[0] * (a.y / a.x) + m[1] * m[1] * (a.x / a.y)) + area * m[2] * m[2];
    return FMATH_INV_PI * area / (t * t);
}

/* D G2 / (4 o.z): the reflection of facets that reflect everything, times the cosine of i. */
static inline float facet_reflect(vec3 o, vec3 i, vec3 m, struct facet a)
{
    return facet_d(m, a) * 0.5f * i[2] / (o[2] * facet_s(i, a) + i[2] * facet_s(o, a));
}

/* pdf_w of the direction that a visible facet reflects o into: G1(o) D(m) / (4 o.z). */
static inline float facet_reflect_pdf_w(vec3 o, vec3 m, struct facet a)
{
    return facet_d(m, a) * 0.5f / (o[2] + facet_s(o, a));
}

/* facet_reflect / facet_reflect_pdf_w = G2 / G1, which lies in [0, 1]. */
static inline float facet_weight(vec3 o, vec3 i, struct facet a)
{
    const float s = facet_s(o, a);
    return i[2] * (o[2] + s) / (o[2] * facet_s(i, a) + i[2] * s);
}

/* A facet's normal, with the density of those visible from o (spherical caps: microfacet.h). */
static inline vec3 facet_visible(vec3 o, struct facet a, struct square q)
{
    const vec3 w = vec3_unit(facet_stretch(o, a));
    const float m = q.v * (1 + w[2]); /* 1 - z of the cap's direction */
    const float r = __builtin_sqrtf(m * (2 - m));
    float s, c;
    fmath_sincos_turns(q.u, &s, &c);
    const float z = (1 + w[2]) * (1 - q.v); /* w.z + 1 - m, but never rounded to 0 */
    return vec3_unit(facet_stretch(vec3_make(w[0] + r * c, w[1] + r * s, z), a));
}

#endif
