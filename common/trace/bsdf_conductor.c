/* SPDX-License-Identifier: MIT */
#include "common/trace/bsdf_conductor.h"

#include "common/trace/fresnel.h"
#include "common/trace/local.h"
#include "common/trace/microfacet.h"

rgb bsdf_conductor_eval(const struct material *m, vec3 wo, vec3 wi)
{
    const vec3 h = vec3_unit(wo + wi);
    const rgb f = fresnel_conductor(vec3_dot(wo, h), m->conductor.eta, m->conductor.k);
    return f * microfacet_reflect(wo, wi, h, m->conductor.alpha);
}

/* From the directions, in sampling too, although h is known there: a narrow lobe magnifies the
 * rounding of wi, and both sides of an MIS weight must see the same. */
float bsdf_conductor_pdf_w(const struct material *m, vec3 wo, vec3 wi)
{
    return microfacet_reflect_pdf_w(wo, vec3_unit(wo + wi), m->conductor.alpha);
}

bool bsdf_conductor_sample(const struct material *m, vec3 wo, struct square q,
                           struct bsdf_sample *s)
{
    const float alpha = m->conductor.alpha;
    const bool delta = bsdf_is_delta(m);
    const vec3 h = delta ? vec3_make(0, 0, 1) : microfacet_visible(wo, alpha, q);
    const float cos = vec3_dot(wo, h);
    const rgb f = fresnel_conductor(cos, m->conductor.eta, m->conductor.k);
    if (delta) {
        s->wi = local_reflect(wo);
        s->pdf_w = 0;
        s->weight = f;
        return true;
    }
    s->wi = vec3_unit(2 * cos * h - wo);
    if (!(s->wi[2] > 0)) /* into the surface: the light would meet a second facet */
        return false;
    s->pdf_w = bsdf_conductor_pdf_w(m, wo, s->wi);
    s->weight = f * microfacet_weight(wo, s->wi, alpha);
    return true;
}
