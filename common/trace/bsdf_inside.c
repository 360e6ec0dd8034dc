/* SPDX-License-Identifier: MIT */
#include "common/trace/bsdf_inside.h"

#include "common/trace/bsdf_glass.h"
#include "common/trace/bsdf_principled.h"
#include "common/trace/covers.h"
#include "common/trace/fresnel.h"
#include "common/trace/glass_albedo.h"
#include "common/trace/inside.h"
#include "common/trace/local.h"
#include "common/trace/microfacet.h"
#include "common/trace/simd.h"
#include "common/trace/warp.h"

enum lobe { LOBE_GLASS, LOBE_MIRRORED, LOBE_EVEN, LOBES };

/* What depends on wo alone; all directions are turned upright, z > 0 inside. */
struct view {
    const struct material *m;
    struct material glass, opaque;
    struct covers over;
    struct inside_glass keeps; /* its kept: by set_kept, for eval alone */
    float clear;               /* share of the way through; the rest is opaque */
    bool smooth;               /* the glass */
    bool layered;
    float chance[LOBES]; /* of the clear share; add up to 1 */
};

static vec3 upright(vec3 w)
{
    return vec3_make(w[0], w[1], __builtin_fabsf(w[2]));
}

/* F, and the refracted cosine. */
static float reflects(const struct view *v, float cos, float *cos_t)
{
    return fresnel_dielectric(cos < 1 ? cos : 1, 1 / v->m->principled.ior, cos_t);
}

/* --- what coat and sheen keep --- */

static void set_kept(struct view *v)
{
    for (int k = 0; k < INSIDE_CELLS; k++) {
        const float root = (float)k / STACK_CELLS;
        v->keeps.kept[k] = 1 - covers_pass(&v->over, root * root);
    }
}

/* Over smooth glass: what the sheen keeps of refracted light, where the coat mirrors its part. */
static rgb kept_by_sheen(const struct view *v, float cos)
{
    return covers_coat_passes(&v->over, cos) * (1 - covers_sheen_passes(&v->over, cos));
}

static rgb left(const struct view *v, vec3 w)
{
    if (!v->smooth)
        return inside_left(&v->keeps, w[2], bsdf_glass_several_missing(&v->glass, local_flip(w)));
    float cos_t;
    const float passed = 1 - reflects(v, w[2], &cos_t);
    return passed > 0 ? passed * kept_by_sheen(v, cos_t) : rgb_gray(0);
}

/* Of light inside, weighted by the cosine; over smooth glass by the cosines outside. */
static rgb left_mean(const struct view *v)
{
    const float n = v->m->principled.ior;
    if (!v->smooth)
        return inside_mean(&v->keeps,
                           glass_albedo_mean(&(struct glass_albedo){n, v->keeps.alpha}, true));
    rgb at[STACK_CELLS + 1];
    for (int k = 0; k <= STACK_CELLS; k++) {
        const float root = (float)k / STACK_CELLS, cos = root * root;
        float cos_t;
        at[k] = (1 - fresnel_dielectric(cos, n, &cos_t)) * kept_by_sheen(v, cos);
    }
    return stack_mean(at) / (n * n);
}

/* What comes back, but for what a smooth coat over smooth glass mirrors. */
static rgb kept_eval(struct view *v, vec3 o, vec3 i)
{
    rgb f = rgb_gray(0);
    if (!v->smooth) {
        const vec3 sum = o + i;
        const float length = vec3_length(sum);
        float cos_t;
        const float passed = 1 - reflects(v, 0.5f * length, &cos_t);
        if (passed > 0)
            f += passed * inside_mirrors(&v->keeps, cos_t) *
                 microfacet_reflect(o, i, sum / length, v->keeps.alpha);
        set_kept(v);
    }
    const rgb mean = left_mean(v), none = rgb_gray(0x1p-20f);
    f += left(v, o) * left(v, i) / vec3_choose(mean > none, mean, none) * warp_cosine_pdf_w(i[2]);
    return f * v->m->principled.base_color * v->m->principled.base_color;
}

/* --- all --- */

/* Guessed from where smooth glass would send the light, seen as it is and as far above as facets
 * are wide: the critical angle may lie between. The mirrored part of smooth glass is chosen
 * together with what goes out. */
static void set_chances(struct view *v, float cos)
{
    float cos_t, *c = v->chance;
    const float alpha = v->smooth ? 0 : v->keeps.alpha;
    const float above = cos + alpha * __builtin_sqrtf(cos < 1 ? (1 - cos) * (1 + cos) : 0);
    const float seen = reflects(v, cos, &cos_t);
    const float passed = 1 - 0.5f * (seen + reflects(v, above, &cos_t));
    const float wide = cos_t + (1 - cos_t) * 0.5f * alpha; /* facets send some of it higher up */
    const float coat = covers_coat_passes(&v->over, wide);
    const rgb sheen = covers_sheen_passes(&v->over, wide);
    const float mirrored = v->smooth ? 0 : passed * inside_mirrors(&v->keeps, cos_t);
    const float kept = passed * rgb_max(v->smooth ? coat * (1 - sheen) : 1 - coat * sheen);
    c[LOBE_GLASS] = 1 - passed * (v->smooth ? 0 : 1 - coat * rgb_max(sheen));
    c[LOBE_MIRRORED] = mirrored;
    c[LOBE_EVEN] = (kept > mirrored ? kept - mirrored : 0) + 0.1f * alpha;
    const float sum = c[LOBE_GLASS] + c[LOBE_MIRRORED] + c[LOBE_EVEN];
    for (int i = 0; i < LOBES; i++)
        c[i] /= sum;
}

/* Of what is not clear the shares are as they were. */
static struct material opaque_of(const struct material *m, float clear)
{
    struct material opaque = *m;
    opaque.principled.transmission = 0;
    if (m->principled.metallic < 1 - clear)
        opaque.principled.metallic = m->principled.metallic / (1 - clear);
    else if (clear < 1) /* all of it, but for rounding */
        opaque.principled.metallic = 1;
    return opaque;
}

static struct view view_make(const struct material *m, vec3 wo)
{
    const float clear = (1 - m->principled.metallic) * m->principled.transmission;
    const float alpha = m->principled.roughness * m->principled.roughness;
    struct view v = {.m = m,
                     .glass = bsdf_principled_glass(m),
                     .opaque = opaque_of(m, clear),
                     .over = covers_of(m),
                     .keeps = {.ior = m->principled.ior, .alpha = alpha},
                     .clear = clear,
                     .chance = {1, 0, 0}};
    v.smooth = bsdf_is_delta(&v.glass);
    v.layered = covers_any(&v.over);
    if (v.layered) {
        v.keeps.straight = 1 - covers_coat_passes(&v.over, 1);
        v.keeps.steep = 1 - covers_coat_passes(&v.over, 0) - v.keeps.straight;
        set_chances(&v, -wo[2]);
    }
    return v;
}

static rgb eval(struct view *v, vec3 wo, vec3 wi)
{
    const rgb glass =
        v->smooth || !(v->clear > 0) ? rgb_gray(0) : bsdf_glass_eval(&v->glass, wo, wi);
    if (wi[2] > 0)
        return glass * v->clear * v->m->principled.base_color * covers_pass(&v->over, wi[2]);
    rgb f = glass * v->clear;
    if (v->layered && v->clear > 0)
        f += v->clear * kept_eval(v, upright(wo), upright(wi));
    if (v->clear < 1)
        f += (1 - v->clear) * bsdf_principled_eval(&v->opaque, upright(wo), upright(wi));
    return f;
}

/* Of the wide lobe: over smooth glass only where light leaves, as even light from above arrives. */
static float even_pdf_w(const struct view *v, float cos)
{
    if (!v->smooth)
        return warp_cosine_pdf_w(cos);
    const float nn = v->m->principled.ior * v->m->principled.ior;
    return nn * cos * cos > nn - 1 ? nn * warp_cosine_pdf_w(cos) : 0;
}

static vec3 even_direction(const struct view *v, struct square q)
{
    const vec3 w = warp_cosine(q);
    if (!v->smooth)
        return w;
    const float n = v->m->principled.ior, x = w[0] / n, y = w[1] / n;
    return vec3_make(x, y, __builtin_sqrtf(1 - x * x - y * y));
}

static float clear_pdf_w(const struct view *v, vec3 wo, vec3 wi)
{
    const float *c = v->chance;
    float p = v->smooth ? 0 : c[LOBE_GLASS] * bsdf_glass_pdf_w(&v->glass, wo, wi);
    if (wi[2] > 0)
        return p;
    const vec3 o = upright(wo), i = upright(wi);
    if (c[LOBE_MIRRORED] > 0)
        p += c[LOBE_MIRRORED] * microfacet_reflect_pdf_w(o, vec3_unit(o + i), v->keeps.alpha);
    return p + c[LOBE_EVEN] * even_pdf_w(v, i[2]);
}

static float pdf_w(const struct view *v, vec3 wo, vec3 wi)
{
    float p = v->clear > 0 ? v->clear * clear_pdf_w(v, wo, wi) : 0;
    if (v->clear < 1 && wi[2] < 0)
        p += (1 - v->clear) * bsdf_principled_pdf_w(&v->opaque, upright(wo), upright(wi));
    return p;
}

rgb bsdf_inside_eval(const struct material *m, vec3 wo, vec3 wi)
{
    struct view v = view_make(m, wo);
    return eval(&v, wo, wi);
}

float bsdf_inside_pdf_w(const struct material *m, vec3 wo, vec3 wi)
{
    const struct view v = view_make(m, wo);
    return pdf_w(&v, wo, wi);
}

/* --- sampling --- */

/* Smooth glass: a mirror, its own and the coat's, or straight out. */
static bool smooth_sample(const struct view *v, vec3 wo, float lobe, struct bsdf_sample *s)
{
    const float n = v->m->principled.ior;
    float cos_t;
    const float f = reflects(v, -wo[2], &cos_t);
    const float kept = (1 - f) * (1 - covers_coat_passes(&v->over, cos_t));
    const rgb out = (1 - f) * covers_pass(&v->over, cos_t), tint = v->m->principled.base_color;
    const float back = (f + kept) / (f + kept + rgb_max(out));
    s->pdf_w = 0;
    if (lobe < back) {
        s->wi = local_reflect(wo);
        s->weight = (f + kept * tint * tint) / (v->chance[LOBE_GLASS] * back);
        return true;
    }
    s->wi = vec3_make(-wo[0] * n, -wo[1] * n, cos_t);
    s->scale = n * n;
    s->weight = out * tint * (s->scale / (v->chance[LOBE_GLASS] * (1 - back)));
    return back < 1;
}

static bool opaque_sample(const struct view *v, vec3 wo, float number, struct square q,
                          struct bsdf_sample *s)
{
    if (!bsdf_principled_sample(&v->opaque, upright(wo), number, q, s))
        return false;
    s->wi = local_flip(s->wi);
    return true;
}

static bool clear_sample(const struct view *v, vec3 wo, float number, struct square q,
                         struct bsdf_sample *s)
{
    const float *c = v->chance;
    if (number < c[LOBE_GLASS]) {
        const float rest = number / c[LOBE_GLASS];
        const float lobe = rest < 1 ? rest : 1 - 0x1p-24f;
        return v->smooth ? smooth_sample(v, wo, lobe, s)
                         : bsdf_glass_sample(&v->glass, wo, lobe, q, s);
    }
    vec3 i = even_direction(v, q);
    if (number < c[LOBE_GLASS] + c[LOBE_MIRRORED]) {
        const vec3 o = upright(wo), h = microfacet_visible(o, v->keeps.alpha, q);
        i = vec3_unit(2 * vec3_dot(o, h) * h - o);
    }
    s->wi = local_flip(i);
    s->pdf_w = 1; /* not a single direction */
    return i[2] > 0;
}

bool bsdf_inside_sample(const struct material *m, vec3 wo, float number, struct square q,
                        struct bsdf_sample *s)
{
    struct view v = view_make(m, wo);
    const bool clear = number < v.clear;
    const float rest = clear ? number / v.clear : (number - v.clear) / (1 - v.clear);
    const float lobe = rest < 1 ? rest : 1 - 0x1p-24f;
    if (!(clear ? clear_sample : opaque_sample)(&v, wo, lobe, q, s))
        return false;
    if (s->pdf_w == 0)
        return true;
    s->pdf_w = pdf_w(&v, wo, s->wi);
    s->weight = eval(&v, wo, s->wi) / s->pdf_w;
    return s->pdf_w > 0;
}
