/* SPDX-License-Identifier: MIT */
#include "common/trace/bsdf.h"

#include "common/trace/bsdf_glass.h"
#include "common/trace/fresnel.h"
#include "common/trace/microfacet.h"
#include "common/trace/warp.h"

static const rgb black = {0, 0, 0, 0};

static vec3 flip_z(vec3 w)
{
    return vec3_make(w[0], w[1], -w[2]);
}

static vec3 reflect_z(vec3 w)
{
    return vec3_make(-w[0], -w[1], w[2]);
}

/* --- diffuse: f = albedo / pi, sampled by the cosine, so that the weight is the albedo --- */

static bool diffuse_sample(const struct material *m, vec3 wo, struct square q,
                           struct bsdf_sample *s)
{
    s->wi = warp_cosine(q);
    s->pdf_w = warp_cosine_pdf_w(s->wi[2]);
    s->weight = m->diffuse.albedo;
    if (wo[2] < 0)
        s->wi = flip_z(s->wi);
    return s->pdf_w > 0;
}

/* --- mirror, and a conductor too smooth to have a lobe --- */

static bool mirror_sample(rgb reflectance, vec3 wo, struct bsdf_sample *s)
{
    s->wi = reflect_z(wo);
    s->pdf_w = 0;
    s->weight = reflectance;
    return true;
}

/* --- smooth dielectric: reflection with the chance of what it reflects, else refraction --- */

static bool dielectric_sample(const struct material *m, vec3 wo, float lobe, struct bsdf_sample *s)
{
    const float eta = wo[2] > 0 ? m->dielectric.ior : 1 / m->dielectric.ior; /* far / near */
    float cos_t;
    const float f = fresnel_dielectric(wo[2] > 0 ? wo[2] : -wo[2], eta, &cos_t);
    s->pdf_w = 0;
    s->weight = rgb_gray(1);
    if (lobe < f) {
        s->wi = reflect_z(wo);
        return true;
    }
    s->wi = vec3_make(-wo[0] / eta, -wo[1] / eta, wo[2] > 0 ? -cos_t : cos_t);
    s->scale = 1 / (eta * eta);
    s->weight = rgb_gray(s->scale);
    return true;
}

/* --- conductor: GGX, sampled by visible facets; wo and wi on the front side --- */

static rgb conductor_eval(const struct material *m, vec3 wo, vec3 wi)
{
    const vec3 h = vec3_unit(wo + wi);
    const rgb f = fresnel_conductor(vec3_dot(wo, h), m->conductor.eta, m->conductor.k);
    return f * microfacet_reflect(wo, wi, h, m->conductor.alpha);
}

/* From the directions, in sampling too, although h is known there: a narrow lobe magnifies the
 * rounding of wi, and both sides of an MIS weight must see the same. */
static float conductor_pdf_w(const struct material *m, vec3 wo, vec3 wi)
{
    return microfacet_reflect_pdf_w(wo, vec3_unit(wo + wi), m->conductor.alpha);
}

static bool conductor_sample(const struct material *m, vec3 wo, struct square q,
                             struct bsdf_sample *s)
{
    const float alpha = m->conductor.alpha;
    const bool below = wo[2] < 0;
    if (below)
        wo = flip_z(wo);
    const bool delta = bsdf_is_delta(m);
    const vec3 h = delta ? vec3_make(0, 0, 1) : microfacet_visible(wo, alpha, q);
    const float cos = vec3_dot(wo, h);
    const rgb f = fresnel_conductor(cos, m->conductor.eta, m->conductor.k);
    if (delta)
        return mirror_sample(f, below ? flip_z(wo) : wo, s);
    s->wi = vec3_unit(2 * cos * h - wo);
    if (!(s->wi[2] > 0)) /* into the surface: the light would meet a second facet */
        return false;
    s->pdf_w = conductor_pdf_w(m, wo, s->wi);
    s->weight = f * microfacet_weight(wo, s->wi, alpha);
    if (below)
        s->wi = flip_z(s->wi);
    return true;
}

/* --- the choice --- */

rgb bsdf_eval(const struct material *m, vec3 wo, vec3 wi)
{
    if (bsdf_is_delta(m))
        return black;
    if (m->kind == MATERIAL_DIELECTRIC)
        return bsdf_glass_eval(m, wo, wi);
    if (!(wo[2] * wi[2] > 0))
        return black;
    if (wo[2] < 0) {
        wo = flip_z(wo);
        wi = flip_z(wi);
    }
    switch (m->kind) {
    case MATERIAL_DIFFUSE:
        return m->diffuse.albedo * warp_cosine_pdf_w(wi[2]);
    case MATERIAL_CONDUCTOR:
        return conductor_eval(m, wo, wi);
    case MATERIAL_MIRROR:
    case MATERIAL_DIELECTRIC:
        break;
    }
    return black;
}

float bsdf_pdf_w(const struct material *m, vec3 wo, vec3 wi)
{
    if (bsdf_is_delta(m))
        return 0;
    if (m->kind == MATERIAL_DIELECTRIC)
        return bsdf_glass_pdf_w(m, wo, wi);
    if (!(wo[2] * wi[2] > 0))
        return 0;
    if (wo[2] < 0) {
        wo = flip_z(wo);
        wi = flip_z(wi);
    }
    switch (m->kind) {
    case MATERIAL_DIFFUSE:
        return warp_cosine_pdf_w(wi[2]);
    case MATERIAL_CONDUCTOR:
        return conductor_pdf_w(m, wo, wi);
    case MATERIAL_MIRROR:
    case MATERIAL_DIELECTRIC:
        break;
    }
    return 0;
}

bool bsdf_sample(const struct material *m, vec3 wo, float lobe, struct square direction,
                 struct bsdf_sample *s)
{
    s->scale = 1;
    if (wo[2] == 0) /* seen exactly from the side: a surface without extent */
        return false;
    switch (m->kind) {
    case MATERIAL_DIFFUSE:
        return diffuse_sample(m, wo, direction, s);
    case MATERIAL_MIRROR:
        return mirror_sample(m->mirror.reflectance, wo, s);
    case MATERIAL_DIELECTRIC:
        return bsdf_is_delta(m) ? dielectric_sample(m, wo, lobe, s)
                                : bsdf_glass_sample(m, wo, lobe, direction, s);
    case MATERIAL_CONDUCTOR:
        return conductor_sample(m, wo, direction, s);
    }
    __builtin_unreachable();
}
