/* microfacet.h - the GGX distribution of facets, isotropic, with Smith's height-correlated masking.
 *
 * B. Walter et al., "Microfacet Models for Refraction through Rough Surfaces", EGSR 2007 (D);
 * E. Heitz, "Understanding the Masking-Shadowing Function in Microfacet-Based BRDFs", JCGT 3(2),
 * 2014 (eq. 99). Single scattering only: light that meets a second facet is lost.
 *
 * Directions are local, z along the macroscopic normal, all z > 0. With
 *     S(w) = sqrt(alpha^2 + (1 - alpha^2) w.z^2)
 * the masking functions need no tangent and are finite down to z = 0:
 *     G1(o)    = 2 o.z / (o.z + S(o))
 *     G2(o, i) = 2 o.z i.z / (o.z S(i) + i.z S(o))
 * SPDX-License-Identifier: MIT */
#ifndef COMMON_TRACE_MICROFACET_H
#define COMMON_TRACE_MICROFACET_H

#include "common/trace/fmath.h"
#include "common/trace/sobol.h"
#include "common/vec.h"

static inline float microfacet_s(vec3 w, float alpha)
{
    const float aa = alpha * alpha;
    return __builtin_sqrtf(aa + (1 - aa) * w[2] * w[2]);
}

static inline float microfacet_g1(vec3 w, float alpha)
{
    return 2 * w[2] / (w[2] + microfacet_s(w, alpha));
}

/* D(m): facets' area per macroscopic area and solid angle of their normal m. */
static inline float microfacet_d(vec3 m, float alpha)
{
    const float aa = alpha * alpha;
    const float t = (m[0] * m[0] + m[1] * m[1]) + aa * m[2] * m[2];
    return FMATH_INV_PI * aa / (t * t);
}

/* D G2 / (4 o.z): the reflection of facets that reflect everything, times the cosine of i. */
static inline float microfacet_reflect(vec3 o, vec3 i, vec3 m, float alpha)
{
    return microfacet_d(m, alpha) * 0.5f * i[2] /
           (o[2] * microfacet_s(i, alpha) + i[2] * microfacet_s(o, alpha));
}

/* pdf_w of the direction that a visible facet reflects o into: G1(o) D(m) / (4 o.z). */
static inline float microfacet_reflect_pdf_w(vec3 o, vec3 m, float alpha)
{
    return microfacet_d(m, alpha) * 0.5f / (o[2] + microfacet_s(o, alpha));
}

/* microfacet_reflect / microfacet_reflect_pdf_w = G2 / G1, which lies in [0, 1]. */
static inline float microfacet_weight(vec3 o, vec3 i, float alpha)
{
    const float s = microfacet_s(o, alpha);
    return i[2] * (o[2] + s) / (o[2] * microfacet_s(i, alpha) + i[2] * s);
}

/* A facet's normal, with the density of those visible from o. J. Dupuy, A. Benyoub, "Sampling
 * Visible GGX Normals with Spherical Caps", CGF 42(8), 2023: stretched until the surface is a
 * hemisphere, the reflected directions are uniform on the cap z > -o.z. */
static inline vec3 microfacet_visible(vec3 o, float alpha, struct square q)
{
    const vec3 w = vec3_unit(vec3_make(o[0] * alpha, o[1] * alpha, o[2]));
    const float m = q.v * (1 + w[2]); /* 1 - z of the cap's direction */
    const float r = __builtin_sqrtf(m * (2 - m));
    float s, c;
    fmath_sincos_turns(q.u, &s, &c);
    const float z = (1 + w[2]) * (1 - q.v); /* w.z + 1 - m, but never rounded to 0 */
    return vec3_unit(vec3_make((w[0] + r * c) * alpha, (w[1] + r * s) * alpha, z));
}

#endif
