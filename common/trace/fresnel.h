/* fresnel.h - how much of unpolarised light a smooth boundary reflects.
 *
 * The formulas are those of any optics text (M. Born, E. Wolf, "Principles of Optics", sections
 * 1.5 and 14.2), averaged over the two polarisations, rearranged so that nothing cancels.
 * SPDX-License-Identifier: MIT */
#ifndef COMMON_TRACE_FRESNEL_H
#define COMMON_TRACE_FRESNEL_H

#include "common/color.h"

/* Dielectric; eta = (index on the far side) / (index on the near side), cos_i in [0, 1]. Also the
 * cosine on the far side, 0 beyond the critical angle. Equal indices reflect nothing: said
 * apart, since at grazing angles the formula would be 0 / 0. */
static inline float fresnel_dielectric(float cos_i, float eta, float *cos_t)
{
    if (eta == 1) {
        *cos_t = cos_i;
        return 0;
    }
    /* (eta^2 - 1) + cos_i^2 = eta^2 - sin_i^2 */
    const float tt = (eta - 1) * (eta + 1) + cos_i * cos_i;
    if (!(tt > 0)) {
        *cos_t = 0;
        return 1;
    }
    const float n_cos_t = __builtin_sqrtf(tt); /* eta cos_t */
    *cos_t = n_cos_t / eta;
    const float rs = (cos_i - n_cos_t) / (cos_i + n_cos_t);
    const float rp = (eta * cos_i - *cos_t) / (eta * cos_i + *cos_t);
    const float f = 0.5f * (rs * rs + rp * rp);
    return f < 1 ? f : 1;
}

/* Conductor in vacuum, one channel: index eta + i k, cos in [0, 1]. */
static inline float fresnel_conductor_channel(float cos, float eta, float k)
{
    const float cc = cos * cos, ss = 1 - cc;
    const float t0 = (eta - k) * (eta + k) - ss;
    const float aabb = __builtin_sqrtf(t0 * t0 + 4 * eta * eta * k * k); /* a^2 + b^2 */
    const float ab = eta * k, aa = t0 >= 0 ? 0.5f * (aabb + t0) : 2 * ab * ab / (aabb - t0);
    const float t1 = aabb + cc, t2 = 2 * cos * __builtin_sqrtf(aa);
    const float t3 = cc * aabb + ss * ss, t4 = t2 * ss;
    if (!(t1 + t2 > 0 && t3 + t4 > 0)) /* grazing and eta + i k = 1 */
        return 1;
    const float rs = (t1 - t2) / (t1 + t2);
    const float f = 0.5f * rs * (1 + (t3 - t4) / (t3 + t4));
    return f > 0 ? (f < 1 ? f : 1) : 0;
}

static inline rgb fresnel_conductor(float cos, rgb eta, rgb k)
{
    return vec3_make(fresnel_conductor_channel(cos, eta[0], k[0]),
                     fresnel_conductor_channel(cos, eta[1], k[1]),
                     fresnel_conductor_channel(cos, eta[2], k[2]));
}

#endif
