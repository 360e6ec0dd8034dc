/* SPDX-License-Identifier: MIT */
#include "common/trace/bsdf_pane.h"

#include "common/trace/fresnel.h"
#include "common/trace/local.h"

/* Reflection with the chance of what it reflects: the weight is 1. */
bool bsdf_pane_sample(const struct material *m, vec3 wo, float lobe, struct bsdf_sample *s)
{
    float cos_t;
    const float f = fresnel_dielectric(wo[2] > 0 ? wo[2] : -wo[2], m->pane.ior, &cos_t);
    s->wi = lobe < 2 * f / (1 + f) ? local_reflect(wo) : -wo;
    s->pdf_w = 0;
    s->weight = rgb_gray(1);
    return true;
}
