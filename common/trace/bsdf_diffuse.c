/* SPDX-License-Identifier: MIT */
#include "common/trace/bsdf_diffuse.h"

#include "common/trace/fmath.h"
#include "common/trace/warp.h"

/* --- rough diffuse --- */

#define LOST     0.287793409f /* 1/2 - 2 / (3 pi): 1 / A - 1 at r = 1, and g at the horizon */
#define LOST_AVG 0.215304213f /* the same less the average of g, 2/3 - 28 / (15 pi) */

static float roughness_a(float r)
{
    return 1 / (1 + LOST * r);
}

/* (1 - E) / (A r): LOST - g, where with s the sine of the angle whose cosine is z
 * pi g = s (acos z - s z) + 2/3 (s / z (1 - s^3) - s), written so that the horizon is no pole. */
static float missing(float z)
{
    const float s = __builtin_sqrtf(z < 1 ? (1 - z) * (1 + z) : 0);
    const float g =
        s * (fmath_acos(z) - s * z) + (2.0f / 3) * s * (z * (1 + s + s * s) / (1 + s) - 1);
    const float m = LOST - FMATH_INV_PI * g;
    return m > 0 ? m : 0;
}

static float cosine_in_plane(vec3 wo, vec3 wi)
{
    return wo[0] * wi[0] + wo[1] * wi[1];
}

rgb bsdf_rough_eval(const struct material *m, vec3 wo, vec3 wi)
{
    const float r = m->rough_diffuse.roughness, a = roughness_a(r);
    const rgb albedo = m->rough_diffuse.albedo;
    const float s = cosine_in_plane(wo, wi), top = wo[2] > wi[2] ? wo[2] : wi[2];
    const float single = 1 + r * (s > 0 ? s / top : s);
    const float more = r * missing(wo[2]) * missing(wi[2]) / LOST_AVG;
    const float lost = a * r * LOST_AVG; /* 1 - E_avg */
    const rgb again = albedo * albedo * (1 - lost) / (1 - albedo * lost);
    return (albedo * single + again * more) * (a * warp_cosine_pdf_w(wi[2]));
}

/* f |i.z| is bounded by the cosine's lobe and, towards wo, by r s: a cosine's lobe around the
 * horizon below wo, both halves of it folded up. What share of the samples is the latter's. */
static float towards(float r, vec3 wo)
{
    const float k = 0.5f * r * __builtin_sqrtf(cosine_in_plane(wo, wo));
    return k / (1 + k);
}

float bsdf_rough_pdf_w(const struct material *m, vec3 wo, vec3 wi)
{
    const float r = m->rough_diffuse.roughness, s = cosine_in_plane(wo, wi);
    return (wi[2] + (s > 0 ? r * s : 0)) * FMATH_INV_PI * (1 - towards(r, wo));
}

bool bsdf_rough_sample(const struct material *m, vec3 wo, float lobe, struct square q,
                       struct bsdf_sample *s)
{
    const vec3 w = warp_cosine(q);
    s->wi = w;
    if (lobe < towards(m->rough_diffuse.roughness, wo)) {
        const vec3 x = vec3_unit(vec3_make(wo[0], wo[1], 0));
        s->wi = vec3_make(x[0] * w[2] - x[1] * w[0], x[1] * w[2] + x[0] * w[0],
                          w[1] < 0 ? -w[1] : w[1]);
    }
    if (!(s->wi[2] > 0))
        return false;
    s->pdf_w = bsdf_rough_pdf_w(m, wo, s->wi);
    s->weight = bsdf_rough_eval(m, wo, s->wi) / s->pdf_w;
    return true;
}

/* --- leaf --- */

/* The chance of reflection. */
static float leaf_back(const struct material *m)
{
    const float back = rgb_max(m->leaf.reflectance), through = rgb_max(m->leaf.transmittance);
    return back + through > 0 ? back / (back + through) : 1;
}

static float upright_pdf_w(vec3 w)
{
    return warp_cosine_pdf_w(w[2] < 0 ? -w[2] : w[2]);
}

rgb bsdf_leaf_eval(const struct material *m, vec3 wo, vec3 wi)
{
    const bool through = (wo[2] < 0) != (wi[2] < 0);
    return (through ? m->leaf.transmittance : m->leaf.reflectance) * upright_pdf_w(wi);
}

float bsdf_leaf_pdf_w(const struct material *m, vec3 wo, vec3 wi)
{
    const float back = leaf_back(m);
    return ((wo[2] < 0) != (wi[2] < 0) ? 1 - back : back) * upright_pdf_w(wi);
}

bool bsdf_leaf_sample(const struct material *m, vec3 wo, float lobe, struct square q,
                      struct bsdf_sample *s)
{
    const float back = leaf_back(m);
    const bool through = lobe >= back;
    const float chance = through ? 1 - back : back;
    s->wi = warp_cosine(q);
    s->pdf_w = chance * warp_cosine_pdf_w(s->wi[2]);
    s->weight = (through ? m->leaf.transmittance : m->leaf.reflectance) / chance;
    if (through == (wo[2] > 0))
        s->wi[2] = -s->wi[2];
    return s->pdf_w > 0;
}
