/* SPDX-License-Identifier: MIT */
#include "common/trace/bsdf.h"

#include "common/trace/bsdf_conductor.h"
#include "common/trace/bsdf_diffuse.h"
#include "common/trace/bsdf_glass.h"
#include "common/trace/bsdf_plastic.h"
#include "common/trace/bsdf_principled.h"
#include "common/trace/bsdf_cloth.h"
#include "common/trace/bsdf_retro.h"
#include "common/trace/bsdf_metal.h"
#include "common/trace/bsdf_pane.h"
#include "common/trace/fresnel.h"
#include "common/trace/local.h"
#include "common/trace/warp.h"

static const rgb black = {0, 0, 0, 0};

/* --- diffuse: f = albedo / pi, sampled by the cosine, so that the weight is the albedo. From
 * either side, and before the choice among all others: most surfaces are --- */

static float diffuse_pdf_w(vec3 wo, vec3 wi)
{
    return wo[2] * wi[2] > 0 ? warp_cosine_pdf_w(wi[2] < 0 ? -wi[2] : wi[2]) : 0;
}

static bool diffuse_sample(const struct material *m, vec3 wo, struct square q,
                           struct bsdf_sample *s)
{
    const vec3 wi = warp_cosine(q);
    s->pdf_w = warp_cosine_pdf_w(wi[2]);
    s->weight = m->diffuse.albedo;
    s->wi = wo[2] > 0 ? wi : local_flip(wi);
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

/* A principled material that is not the same from both sides. */
static bool is_clear(const struct material *m)
{
    return m->kind == MATERIAL_PRINCIPLED && m->principled.transmission > 0;
}

rgb bsdf_eval(const struct material *m, vec3 wo, vec3 wi)
{
    if (m->kind == MATERIAL_DIFFUSE)
        return m->diffuse.albedo * diffuse_pdf_w(wo, wi);
    if (bsdf_is_delta(m))
        return black;
    if (m->kind == MATERIAL_DIELECTRIC)
        return bsdf_glass_eval(m, wo, wi);
    if (m->kind == MATERIAL_LEAF)
        return bsdf_leaf_eval(m, wo, wi);
    if (is_clear(m) && wo[2] * wi[2] != 0)
        return bsdf_principled_eval(m, wo, wi);
    if (!(wo[2] * wi[2] > 0))
        return black;
    if (wo[2] < 0) {
        wo = local_flip(wo);
        wi = local_flip(wi);
    }
    switch (m->kind) {
    case MATERIAL_CONDUCTOR:
        return bsdf_conductor_eval(m, wo, wi);
    case MATERIAL_ROUGH_DIFFUSE:
        return bsdf_rough_eval(m, wo, wi);
    case MATERIAL_RETROREFLECTOR:
        return bsdf_retro_eval(m, wo, wi);
    case MATERIAL_PLASTIC:
        return bsdf_plastic_eval(m, wo, wi);
    case MATERIAL_PRINCIPLED:
        return bsdf_principled_eval(m, wo, wi);
    case MATERIAL_CLOTH:
        return bsdf_cloth_eval(m, wo, wi);
    case MATERIAL_METAL:
        return bsdf_metal_eval(m, wo, wi);
    case MATERIAL_MIRROR:
    case MATERIAL_DIELECTRIC:
    case MATERIAL_LEAF:
    case MATERIAL_DIFFUSE:
    case MATERIAL_MIX:
    case MATERIAL_MASK:
    case MATERIAL_TWO_SIDED:
    case MATERIAL_PANE:
        break;
    }
    return black;
}

float bsdf_pdf_w(const struct material *m, vec3 wo, vec3 wi)
{
    if (m->kind == MATERIAL_DIFFUSE)
        return diffuse_pdf_w(wo, wi);
    if (bsdf_is_delta(m))
        return 0;
    if (m->kind == MATERIAL_DIELECTRIC)
        return bsdf_glass_pdf_w(m, wo, wi);
    if (m->kind == MATERIAL_LEAF)
        return bsdf_leaf_pdf_w(m, wo, wi);
    if (is_clear(m) && wo[2] * wi[2] != 0)
        return bsdf_principled_pdf_w(m, wo, wi);
    if (!(wo[2] * wi[2] > 0))
        return 0;
    if (wo[2] < 0) {
        wo = local_flip(wo);
        wi = local_flip(wi);
    }
    switch (m->kind) {
    case MATERIAL_CONDUCTOR:
        return bsdf_conductor_pdf_w(m, wo, wi);
    case MATERIAL_ROUGH_DIFFUSE:
        return bsdf_rough_pdf_w(m, wo, wi);
    case MATERIAL_RETROREFLECTOR:
        return bsdf_retro_pdf_w(m, wo, wi);
    case MATERIAL_PLASTIC:
        return bsdf_plastic_pdf_w(m, wo, wi);
    case MATERIAL_PRINCIPLED:
        return bsdf_principled_pdf_w(m, wo, wi);
    case MATERIAL_CLOTH:
        return bsdf_cloth_pdf_w(m, wo, wi);
    case MATERIAL_METAL:
        return bsdf_metal_pdf_w(m, wo, wi);
    case MATERIAL_MIRROR:
    case MATERIAL_DIELECTRIC:
    case MATERIAL_LEAF:
    case MATERIAL_DIFFUSE:
    case MATERIAL_MIX:
    case MATERIAL_MASK:
    case MATERIAL_TWO_SIDED:
    case MATERIAL_PANE:
        break;
    }
    return 0;
}

/* Of an opaque material, seen from its front. */
static bool opaque_sample(const struct material *m, vec3 wo, float lobe, struct square direction,
                          struct bsdf_sample *s)
{
    switch (m->kind) {
    case MATERIAL_MIRROR:
        return mirror_sample(m, wo, s);
    case MATERIAL_CONDUCTOR:
        return bsdf_conductor_sample(m, wo, direction, s);
    case MATERIAL_ROUGH_DIFFUSE:
        return bsdf_rough_sample(m, wo, lobe, direction, s);
    case MATERIAL_RETROREFLECTOR:
        return bsdf_retro_sample(m, wo, direction, s);
    case MATERIAL_PLASTIC:
        return bsdf_plastic_sample(m, wo, lobe, direction, s);
    case MATERIAL_PRINCIPLED:
        return bsdf_principled_sample(m, wo, lobe, direction, s);
    case MATERIAL_CLOTH:
        return bsdf_cloth_sample(m, wo, lobe, direction, s);
    case MATERIAL_METAL:
        return bsdf_metal_sample(m, wo, lobe, direction, s);
    case MATERIAL_DIELECTRIC:
    case MATERIAL_LEAF:
    case MATERIAL_DIFFUSE:
    case MATERIAL_MIX:
    case MATERIAL_MASK:
    case MATERIAL_TWO_SIDED:
    case MATERIAL_PANE:
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
    if (m->kind == MATERIAL_DIFFUSE)
        return diffuse_sample(m, wo, direction, s);
    if (m->kind == MATERIAL_DIELECTRIC)
        return bsdf_is_delta(m) ? dielectric_sample(m, wo, lobe, s)
                                : bsdf_glass_sample(m, wo, lobe, direction, s);
    if (m->kind == MATERIAL_LEAF)
        return bsdf_leaf_sample(m, wo, lobe, direction, s);
    if (is_clear(m))
        return bsdf_principled_sample(m, wo, lobe, direction, s);
    if (m->kind == MATERIAL_PANE)
        return bsdf_pane_sample(m, wo, lobe, s);
    if (wo[2] > 0)
        return opaque_sample(m, wo, lobe, direction, s);
    if (!opaque_sample(m, local_flip(wo), lobe, direction, s))
        return false;
    s->wi = local_flip(s->wi);
    return true;
}
