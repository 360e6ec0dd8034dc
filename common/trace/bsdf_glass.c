/* SPDX-License-Identifier: MIT */
#include "common/trace/bsdf_glass.h"

#include "common/trace/fresnel.h"
#include "common/trace/glass_albedo.h"
#include "common/trace/microfacet.h"
#include "common/trace/several.h"

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

/* --- several facets --- */

struct several {
    struct glass_albedo of;
    float sum;   /* of the means, by n^2 */
    float above; /* of it above */
};

static struct several several_make(const struct material *m)
{
    const float n = m->dielectric.ior;
    struct several s = {.of = {n, m->dielectric.alpha}};
    s.above = glass_albedo_mean(&s.of, false);
    s.sum = s.above + n * n * glass_albedo_mean(&s.of, true);
    return s;
}

static float several_missing(const struct several *s, vec3 w)
{
    return s->sum > SEVERAL_LEAST ? glass_albedo_missing(&s->of, w[2] < 0, w[2] < 0 ? -w[2] : w[2])
                                  : 0;
}

float bsdf_glass_several_missing(const struct material *m, vec3 wo)
{
    const struct several s = several_make(m);
    return several_missing(&s, wo);
}

float bsdf_glass_several_eval(const struct material *m, vec3 wo, vec3 wi)
{
    const struct several s = several_make(m);
    const float both = several_missing(&s, wo) * several_missing(&s, wi);
    const float nn = wo[2] > 0 ? 1 : s.of.ior * s.of.ior;
    return both > 0 ? both * nn / s.sum * warp_cosine_pdf_w(upright(wi)[2]) : 0;
}

static float both_pdf_w(const struct several *s, float once, vec3 wo, vec3 wi)
{
    const float chance = several_missing(s, wo);
    if (!(chance > 0))
        return once;
    const float side = (wi[2] > 0 ? s->above : s->sum - s->above) / s->sum;
    return (1 - chance) * once + chance * side * several_pdf_w(upright(wi), s->of.alpha);
}

/* number: in [0, 1). */
static vec3 several_sample(const struct several *s, float number, struct square q)
{
    const float above = s->above / s->sum;
    const bool up = number < above;
    const vec3 w =
        several_direction(up ? number / above : (number - above) / (1 - above), q, s->of.alpha);
    return up ? w : vec3_make(w[0], w[1], -w[2]);
}

/* --- all --- */

static float once_eval(const struct material *m, vec3 wo, vec3 wi)
{
    const float eta = eta_from(m, wo), sides = wo[2] * wi[2];
    if (sides > 0)
        return reflect_eval(m, eta, upright(wo), upright(wi));
    if (sides < 0)
        return refract_pdf_w(m, wo, wi) * refract_weight(m, 1 / (eta * eta), wi);
    return 0;
}

static float once_pdf_w(const struct material *m, vec3 wo, vec3 wi)
{
    const float sides = wo[2] * wi[2];
    if (sides > 0)
        return reflect_pdf_w(m, eta_from(m, wo), upright(wo), upright(wi));
    return sides < 0 ? refract_pdf_w(m, wo, wi) : 0;
}

rgb bsdf_glass_eval(const struct material *m, vec3 wo, vec3 wi)
{
    const float once = once_eval(m, wo, wi);
    return rgb_gray(m->dielectric.multiscatter ? once + bsdf_glass_several_eval(m, wo, wi) : once);
}

float bsdf_glass_pdf_w(const struct material *m, vec3 wo, vec3 wi)
{
    const float once = once_pdf_w(m, wo, wi);
    if (!m->dielectric.multiscatter)
        return once;
    const struct several s = several_make(m);
    return both_pdf_w(&s, once, wo, wi);
}

static bool once_sample(const struct material *m, vec3 wo, float lobe, struct square q,
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
    s->pdf_w = once_pdf_w(m, wo, s->wi);
    s->weight =
        rgb_gray(reflects ? microfacet_weight(o, i, alpha) : refract_weight(m, s->scale, s->wi));
    return s->pdf_w > 0; /* else rounding has left no facet for it, and 0 says delta */
}

bool bsdf_glass_sample(const struct material *m, vec3 wo, float lobe, struct square q,
                       struct bsdf_sample *s)
{
    if (!m->dielectric.multiscatter)
        return once_sample(m, wo, lobe, q, s);
    const struct several several = several_make(m);
    const float chance = several_missing(&several, wo), eta = eta_from(m, wo);
    if (lobe < chance) {
        s->wi = several_sample(&several, lobe / chance, q);
        s->scale = s->wi[2] * wo[2] > 0 ? 1 : 1 / (eta * eta);
    } else if (!once_sample(m, wo, (lobe - chance) / (1 - chance), q, s)) {
        return false;
    }
    s->pdf_w = both_pdf_w(&several, once_pdf_w(m, wo, s->wi), wo, s->wi);
    s->weight = bsdf_glass_eval(m, wo, s->wi) / s->pdf_w;
    return s->pdf_w > 0 && s->wi[2] != 0;
}
