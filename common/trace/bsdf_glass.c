/* SPDX-License-Identifier: MIT */
#include "common/trace/bsdf_glass.h"

#include "common/trace/fresnel.h"
#include "common/trace/microfacet.h"

static vec3 upright(vec3 w)
{
    return vec3_make(w[0], w[1], w[2] < 0 ? -w[2] : w[2]);
}

/* far / near, seen from wo. */
static float eta_from(const struct material *m, vec3 wo)
{
    return wo[2] > 0 ? m->dielectric.ior : 1 / m->dielectric.ior;
}

/* --- reflection; o and i upright --- */

/* The cosine at the facet is half of |o + i|: the same both ways to the last bit, which matters
 * where F is infinitely steep, at the critical angle. */
static float reflected_share(vec3 o, vec3 i, float eta, vec3 *h)
{
    const vec3 sum = o + i;
    const float length = vec3_length(sum);
    float cos_t;
    *h = sum / length;
    return fresnel_dielectric(0.5f * length, eta, &cos_t);
}

static float reflect_pdf_w(const struct material *m, float eta, vec3 o, vec3 i)
{
    vec3 h;
    const float f = reflected_share(o, i, eta, &h);
    return f * microfacet_reflect_pdf_w(o, h, m->dielectric.alpha);
}

static float reflect_eval(const struct material *m, float eta, vec3 o, vec3 i)
{
    vec3 h;
    const float f = reflected_share(o, i, eta, &h);
    return f * microfacet_reflect(o, i, h, m->dielectric.alpha);
}

/* --- refraction --- */

/* G1(o) D |o.h| / o.z (1 - F), times what facets per direction are: n_i^2 |i.h| / L^2 with
 * L = |n_o o + n_i i|. Facet and F are found from the direction above, whichever it is: the same
 * both ways, and no critical angle. 0 where no facet turned upwards refracts one into the other. */
static float refract_pdf_w(const struct material *m, vec3 wo, vec3 wi)
{
    const bool down = wo[2] > 0; /* light is looked for below */
    const float n = m->dielectric.ior;
    const vec3 above = down ? wo : wi, below = down ? wi : wo;
    const vec3 sum = -(above + n * below);
    const float length = vec3_length(sum); /* n - 1 at least */
    const vec3 h = sum / length;
    const float cos_above = vec3_dot(above, h), cos_below = -vec3_dot(below, h);
    if (!(h[2] > 0 && cos_above > 0 && cos_below > 0))
        return 0;
    float cos_t;
    const float passed = 1 - fresnel_dielectric(cos_above, n, &cos_t);
    const float n_i = (down ? n : 1) / length;
    return passed * microfacet_reflect_pdf_w(upright(wo), h, m->dielectric.alpha) *
           (4 * cos_above * cos_below * n_i * n_i);
}

/* eval / pdf_w: G1(i), times the change of radiance. */
static float refract_weight(const struct material *m, float scale, vec3 wi)
{
    return microfacet_g1(upright(wi), m->dielectric.alpha) * scale;
}

/* --- both --- */

rgb bsdf_glass_eval(const struct material *m, vec3 wo, vec3 wi)
{
    const float eta = eta_from(m, wo), sides = wo[2] * wi[2];
    if (sides > 0)
        return rgb_gray(reflect_eval(m, eta, upright(wo), upright(wi)));
    if (sides < 0)
        return rgb_gray(refract_pdf_w(m, wo, wi) * refract_weight(m, 1 / (eta * eta), wi));
    return rgb_gray(0);
}

float bsdf_glass_pdf_w(const struct material *m, vec3 wo, vec3 wi)
{
    const float sides = wo[2] * wi[2];
    if (sides > 0)
        return reflect_pdf_w(m, eta_from(m, wo), upright(wo), upright(wi));
    return sides < 0 ? refract_pdf_w(m, wo, wi) : 0;
}

bool bsdf_glass_sample(const struct material *m, vec3 wo, float lobe, struct square q,
                       struct bsdf_sample *s)
{
    const float alpha = m->dielectric.alpha, eta = eta_from(m, wo);
    const vec3 o = upright(wo), h = microfacet_visible(o, alpha, q);
    const float cos = vec3_dot(o, h);
    float cos_t;
    const bool reflects = lobe < fresnel_dielectric(cos, eta, &cos_t);
    const vec3 i = vec3_unit(reflects ? 2 * cos * h - o : (cos / eta - cos_t) * h - o / eta);
    if (!(reflects ? i[2] > 0 : i[2] < 0)) /* the light would meet a second facet */
        return false;
    s->wi = wo[2] > 0 ? i : vec3_make(i[0], i[1], -i[2]);
    s->scale = reflects ? 1 : 1 / (eta * eta);
    /* From the directions: both sides of an MIS weight must see the same (bsdf.c, conductor). */
    s->pdf_w = bsdf_glass_pdf_w(m, wo, s->wi);
    s->weight =
        rgb_gray(reflects ? microfacet_weight(o, i, alpha) : refract_weight(m, s->scale, s->wi));
    return s->pdf_w > 0; /* else rounding has left no facet for it, and 0 says delta */
}
