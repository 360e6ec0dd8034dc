/* SPDX-License-Identifier: MIT */
#include "common/trace/bsdf_retro.h"

#include "common/trace/local.h"
#include "common/trace/microfacet.h"

rgb bsdf_retro_eval(const struct material *m, vec3 wo, vec3 wi)
{
    const vec3 i = local_reflect(wi);
    return m->retro.reflectance * microfacet_reflect(wo, i, vec3_unit(wo + i), m->retro.alpha);
}

/* From the directions, in sampling too (bsdf_conductor.c). */
float bsdf_retro_pdf_w(const struct material *m, vec3 wo, vec3 wi)
{
    return microfacet_reflect_pdf_w(wo, vec3_unit(wo + local_reflect(wi)), m->retro.alpha);
}

bool bsdf_retro_sample(const struct material *m, vec3 wo, struct square q, struct bsdf_sample *s)
{
    const float alpha = m->retro.alpha;
    s->weight = m->retro.reflectance;
    if (bsdf_is_delta(m)) {
        s->wi = wo;
        s->pdf_w = 0;
        return true;
    }
    const vec3 h = microfacet_visible(wo, alpha, q);
    s->wi = local_reflect(vec3_unit(2 * vec3_dot(wo, h) * h - wo));
    if (!(s->wi[2] > 0)) /* into the surface */
        return false;
    s->pdf_w = bsdf_retro_pdf_w(m, wo, s->wi);
    s->weight *= microfacet_weight(wo, s->wi, alpha);
    return true;
}
