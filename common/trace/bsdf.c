/* SPDX-License-Identifier: MIT */
#include "common/trace/bsdf.h"

#include "common/trace/bsdf_conductor.h"
#include "common/trace/bsdf_glass.h"
#include "common/trace/bsdf_metal.h"
#include "common/trace/fresnel.h"
#include "common/trace/local.h"
#include "common/trace/warp.h"

static const rgb black = {0, 0, 0, 0};

/* --- diffuse: f = albedo / pi, sampled by the cosine, so that the weight is the albedo --- */

static bool diffuse_sample(const struct material *m, struct square q, struct bsdf_sample *s)
{
    s->wi = warp_cosine(q);
    s->pdf_w = warp_cosine_pdf_w(s->wi[2]);
    s->weight = m->diffuse.albedo;
    return s->pdf_w > 0;
}

/* --- mirror --- */

static bool mirror_sample(const struct material *m, vec3 wo, struct bsdf_sample *s)
{
    s->wi = local_reflect(wo);
    s->pdf_w = 0;
    s->weight = m->mirror.reflectance;
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
        s->wi = local_reflect(wo);
        return true;
    }
    s->wi = vec3_make(-wo[0] / eta, -wo[1] / eta, wo[2] > 0 ? -cos_t : cos_t);
    s->scale = 1 / (eta * eta);
    s->weight = rgb_gray(s->scale);
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
        wo = local_flip(wo);
        wi = local_flip(wi);
    }
    switch (m->kind) {
    case MATERIAL_DIFFUSE:
        return m->diffuse.albedo * warp_cosine_pdf_w(wi[2]);
    case MATERIAL_CONDUCTOR:
        return bsdf_conductor_eval(m, wo, wi);
    case MATERIAL_METAL:
        return bsdf_metal_eval(m, wo, wi);
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
        wo = local_flip(wo);
        wi = local_flip(wi);
    }
    switch (m->kind) {
    case MATERIAL_DIFFUSE:
        return warp_cosine_pdf_w(wi[2]);
    case MATERIAL_CONDUCTOR:
        return bsdf_conductor_pdf_w(m, wo, wi);
    case MATERIAL_METAL:
        return bsdf_metal_pdf_w(m, wo, wi);
    case MATERIAL_MIRROR:
    case MATERIAL_DIELECTRIC:
        break;
    }
    return 0;
}

/* Of an opaque material, seen from its front. */
static bool opaque_sample(const struct material *m, vec3 wo, float lobe, struct square direction,
                          struct bsdf_sample *s)
{
    switch (m->kind) {
    case MATERIAL_DIFFUSE:
        return diffuse_sample(m, direction, s);
    case MATERIAL_MIRROR:
        return mirror_sample(m, wo, s);
    case MATERIAL_CONDUCTOR:
        return bsdf_conductor_sample(m, wo, direction, s);
    case MATERIAL_METAL:
        return bsdf_metal_sample(m, wo, lobe, direction, s);
    case MATERIAL_DIELECTRIC:
        break;
    }
    return false;
}

bool bsdf_sample(const struct material *m, vec3 wo, float lobe, struct square direction,
                 struct bsdf_sample *s)
{
    s->scale = 1;
    if (wo[2] == 0) /* seen exactly from the side: a surface without extent */
        return false;
    if (m->kind == MATERIAL_DIELECTRIC)
        return bsdf_is_delta(m) ? dielectric_sample(m, wo, lobe, s)
                                : bsdf_glass_sample(m, wo, lobe, direction, s);
    if (wo[2] > 0)
        return opaque_sample(m, wo, lobe, direction, s);
    if (!opaque_sample(m, local_flip(wo), lobe, direction, s))
        return false;
    s->wi = local_flip(s->wi);
    return true;
}
