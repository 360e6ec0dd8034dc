/* SPDX-License-Identifier: MIT */
#include "common/trace/bsdf_cloth.h"

#include "common/trace/sheen.h"
#include "common/trace/warp.h"

/* What depends on wo alone. */
struct cloth {
    rgb base;     /* f of the base is this times what passes on the light's way */
    float fibres; /* the chance that sampling takes them */
};

static struct cloth cloth_make(const struct material *m, vec3 wo)
{
    const rgb color = m->cloth.color;
    const float e = sheen_albedo(m->cloth.roughness, wo[2]);
    const rgb back = m->cloth.albedo * (1 - color * e);
    const float fibres = rgb_max(color) * e, all = fibres + rgb_max(back);
    return (struct cloth){back / (1 - color * sheen_mean(m->cloth.roughness)),
                          all > 0 ? fibres / all : 0};
}

static rgb eval(const struct material *m, const struct cloth *c, vec3 wo, vec3 wi)
{
    const rgb passes = 1 - m->cloth.color * sheen_albedo(m->cloth.roughness, wi[2]);
    return m->cloth.color * sheen_eval(m->cloth.roughness, wo, wi) +
           c->base * passes * warp_cosine_pdf_w(wi[2]);
}

static float pdf_w(const struct material *m, const struct cloth *c, vec3 wo, vec3 wi)
{
    return c->fibres * sheen_pdf_w(m->cloth.roughness, wo, wi) +
           (1 - c->fibres) * warp_cosine_pdf_w(wi[2]);
}

rgb bsdf_cloth_eval(const struct material *m, vec3 wo, vec3 wi)
{
    const struct cloth c = cloth_make(m, wo);
    return eval(m, &c, wo, wi);
}

float bsdf_cloth_pdf_w(const struct material *m, vec3 wo, vec3 wi)
{
    const struct cloth c = cloth_make(m, wo);
    return pdf_w(m, &c, wo, wi);
}

bool bsdf_cloth_sample(const struct material *m, vec3 wo, float lobe, struct square q,
                       struct bsdf_sample *s)
{
    const struct cloth c = cloth_make(m, wo);
    if (lobe < c.fibres) {
        if (!sheen_sample(m->cloth.roughness, wo, lobe / c.fibres, q, &s->wi))
            return false;
    } else {
        s->wi = warp_cosine(q);
    }
    s->pdf_w = pdf_w(m, &c, wo, s->wi);
    if (!(s->wi[2] > 0 && s->pdf_w > 0))
        return false;
    s->weight = eval(m, &c, wo, s->wi) / s->pdf_w;
    return true;
}
