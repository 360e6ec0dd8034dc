/* SPDX-License-Identifier: MIT */
#include "common/trace/bsdf_plastic.h"

#include "common/trace/coat.h"
#include "common/trace/fresnel.h"
#include "common/trace/local.h"
#include "common/trace/microfacet.h"
#include "common/trace/warp.h"

/* What depends on wo alone. */
struct plastic {
    struct coat coat;
    rgb base;        /* f of the base is this times what passes on the light's way */
    float reflected; /* the chance that sampling takes the coat's reflection */
};

static bool is_smooth(const struct coat *c)
{
    return c->alpha < BSDF_LEAST_ALPHA;
}

static struct plastic plastic_make(const struct material *m, vec3 wo)
{
    struct plastic p = {.coat = {m->plastic.ior, m->plastic.alpha}};
    const float passes = coat_passes(&p.coat, wo[2]), mean = coat_passes_mean(&p.coat);
    const rgb back = coat_base(&p.coat, mean, m->plastic.albedo) * passes;
    p.base = back / mean;
    p.reflected = (1 - passes) / ((1 - passes) + rgb_max(back));
    return p;
}

/* The cosine at the facet is half of |o + i|: the same both ways to the last bit. */
static float reflect_eval(const struct coat *c, vec3 wo, vec3 wi)
{
    const vec3 sum = wo + wi;
    const float length = vec3_length(sum);
    float cos_t;
    return fresnel_dielectric(0.5f * length, c->ior, &cos_t) *
           microfacet_reflect(wo, wi, sum / length, c->alpha);
}

static rgb eval(const struct plastic *p, vec3 wo, vec3 wi)
{
    const rgb base = p->base * (coat_passes(&p->coat, wi[2]) * warp_cosine_pdf_w(wi[2]));
    return is_smooth(&p->coat) ? base : base + reflect_eval(&p->coat, wo, wi);
}

static float pdf_w(const struct plastic *p, vec3 wo, vec3 wi)
{
    const float base = (1 - p->reflected) * warp_cosine_pdf_w(wi[2]);
    if (is_smooth(&p->coat))
        return base;
    return base + p->reflected * microfacet_reflect_pdf_w(wo, vec3_unit(wo + wi), p->coat.alpha);
}

rgb bsdf_plastic_eval(const struct material *m, vec3 wo, vec3 wi)
{
    const struct plastic p = plastic_make(m, wo);
    return eval(&p, wo, wi);
}

float bsdf_plastic_pdf_w(const struct material *m, vec3 wo, vec3 wi)
{
    const struct plastic p = plastic_make(m, wo);
    return pdf_w(&p, wo, wi);
}

bool bsdf_plastic_sample(const struct material *m, vec3 wo, float lobe, struct square q,
                         struct bsdf_sample *s)
{
    const struct plastic p = plastic_make(m, wo);
    if (lobe >= p.reflected) {
        s->wi = warp_cosine(q);
    } else if (is_smooth(&p.coat)) {
        float cos_t;
        s->wi = local_reflect(wo);
        s->pdf_w = 0;
        s->weight = rgb_gray(fresnel_dielectric(wo[2], p.coat.ior, &cos_t) / p.reflected);
        return true;
    } else {
        const vec3 h = microfacet_visible(wo, p.coat.alpha, q);
        s->wi = vec3_unit(2 * vec3_dot(wo, h) * h - wo);
    }
    if (!(s->wi[2] > 0))
        return false;
    s->pdf_w = pdf_w(&p, wo, s->wi);
    s->weight = eval(&p, wo, s->wi) / s->pdf_w;
    return s->pdf_w > 0;
}
