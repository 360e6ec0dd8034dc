/* SPDX-License-Identifier: MIT */
#include "common/trace/bsdf_metal.h"

#include "common/trace/albedo.h"
#include "common/trace/facet.h"
#include "common/trace/fresnel.h"
#include "common/trace/local.h"
#include "common/trace/several.h"
#include "common/trace/thinfilm.h"

/* --- parameters --- */

static struct facet widths(const struct material *m)
{
    const float x = m->metal.alpha_x, y = m->metal.alpha_y;
    return (struct facet){x > BSDF_LEAST_ALPHA ? x : BSDF_LEAST_ALPHA,
                          y > BSDF_LEAST_ALPHA ? y : BSDF_LEAST_ALPHA};
}

/* To the tangents that the widths belong to, and back. */
static vec3 turned(const struct material *m, vec3 w)
{
    const float c = m->metal.turn_cos, s = m->metal.turn_sin;
    return vec3_make(c * w[0] + s * w[1], c * w[1] - s * w[0], w[2]);
}

static vec3 turned_back(const struct material *m, vec3 w)
{
    const float c = m->metal.turn_cos, s = m->metal.turn_sin;
    return vec3_make(c * w[0] - s * w[1], c * w[1] + s * w[0], w[2]);
}

static rgb fresnel(const struct material *m, float cos)
{
    if (m->metal.film.thickness_nm > 0)
        return thinfilm_metal(cos, m->metal.eta, m->metal.k, &m->metal.film);
    return fresnel_conductor(cos, m->metal.eta, m->metal.k);
}

/* --- light that meets several facets; directions are turned --- */

/* The mean of F over the hemisphere, weighted by the cosine: the integral over cos^2, by the Gauss
 * rule of 3 points. */
static rgb fresnel_mean(const struct material *m)
{
    return (fresnel(m, 0.335710f) + fresnel(m, 0.941965f)) * (5 / 18.0f) +
           fresnel(m, 0.707107f) * (8 / 18.0f);
}

/* The chance to sample it. */
static float several_chance(vec3 o, struct facet a)
{
    return albedo_missing_mean(a) > SEVERAL_LEAST ? albedo_missing(o, a) : 0;
}

static rgb several_eval(const struct material *m, vec3 o, vec3 i, struct facet a)
{
    const float missing = albedo_missing_mean(a);
    const rgb f = fresnel_mean(m);
    const float lobe = several_chance(o, a) * albedo_missing(i, a) / missing;
    return f * f * (1 - missing) / (1 - f * missing) * (lobe * warp_cosine_pdf_w(i[2]));
}

static float wider(struct facet a)
{
    return a.x > a.y ? a.x : a.y;
}

/* --- all --- */

rgb bsdf_metal_eval(const struct material *m, vec3 wo, vec3 wi)
{
    const struct facet a = widths(m);
    const vec3 o = turned(m, wo), i = turned(m, wi), sum = o + i;
    const float length = vec3_length(sum); /* twice the cosine at the facet, the same both ways */
    const rgb once = fresnel(m, 0.5f * length) * facet_reflect(o, i, sum / length, a);
    return m->metal.multiscatter ? once + several_eval(m, o, i, a) : once;
}

/* From the directions, in sampling too: bsdf_conductor.c says why. */
float bsdf_metal_pdf_w(const struct material *m, vec3 wo, vec3 wi)
{
    const struct facet a = widths(m);
    const vec3 o = turned(m, wo), i = turned(m, wi);
    const float once = facet_reflect_pdf_w(o, vec3_unit(o + i), a);
    if (!m->metal.multiscatter)
        return once;
    const float several = several_chance(o, a);
    return (1 - several) * once + several * several_pdf_w(i, wider(a));
}

static bool mirror_sample(const struct material *m, vec3 wo, struct bsdf_sample *s)
{
    s->wi = local_reflect(wo);
    s->pdf_w = 0;
    s->weight = fresnel(m, wo[2]);
    return true;
}

bool bsdf_metal_sample(const struct material *m, vec3 wo, float lobe, struct square q,
                       struct bsdf_sample *s)
{
    if (bsdf_is_delta(m))
        return mirror_sample(m, wo, s);
    const struct facet a = widths(m);
    const vec3 o = turned(m, wo);
    const float several = m->metal.multiscatter ? several_chance(o, a) : 0;
    float cos = 0;
    if (lobe < several) {
        s->wi = several_direction(lobe / several, q, wider(a));
    } else {
        const vec3 h = facet_visible(o, a, q);
        cos = vec3_dot(o, h);
        s->wi = vec3_unit(turned_back(m, 2 * cos * h - o));
    }
    if (!(s->wi[2] > 0)) /* into the surface */
        return false;
    s->pdf_w = bsdf_metal_pdf_w(m, wo, s->wi);
    /* Where F is steep, the rounding of wi is felt. */
    s->weight = m->metal.multiscatter || m->metal.film.thickness_nm > 0
                    ? bsdf_metal_eval(m, wo, s->wi) / s->pdf_w
                    : fresnel(m, cos) * facet_weight(o, turned(m, s->wi), a);
    return s->pdf_w > 0;
}
