/* SPDX-License-Identifier: MIT */
#include "common/trace/bsdf_principled.h"

#include "common/trace/albedo.h"
#include "common/trace/bsdf_glass.h"
#include "common/trace/bsdf_inside.h"
#include "common/trace/coat.h"
#include "common/trace/covers.h"
#include "common/trace/fresnel.h"
#include "common/trace/local.h"
#include "common/trace/microfacet.h"
#include "common/trace/sheen.h"
#include "common/trace/stack.h"
#include "common/trace/warp.h"

enum lobe { LOBE_COAT, LOBE_SHEEN, LOBE_FACETS, LOBE_EVEN, LOBE_GLASS, LOBES };

/* What depends on wo alone. */
struct view {
    const struct material *m;
    struct material glass;
    struct covers over;    /* clear coat and sheen */
    struct coat base;      /* the boundary of what is not metal */
    float opaque, through; /* shares of diffuse base and way through; the rest is metal */
    bool layered;          /* there is a clear coat or sheen */
    rgb passes;            /* coat and sheen, along wo */
    float chance[LOBES];   /* add up to 1, or are all 0 */
    /* For eval alone, by set_even: */
    struct stack layers, clear; /* what passes both, and the coat */
    rgb diffuse;                /* what the diffuse base returns of the light along wo */
    rgb again;                  /* what facets of metal have left to reflect again */
};

static bool is_smooth(float alpha)
{
    return alpha < BSDF_LEAST_ALPHA;
}

static rgb smaller(rgb a, rgb b)
{
    return vec3_choose(a < b, a, b);
}

/* --- what passes --- */

static void stack_layers(struct view *v)
{
    for (int k = 0; v->layered && k <= STACK_CELLS; k++) {
        const float root = (float)k / STACK_CELLS, cos = root * root,
                    coat = covers_coat_passes(&v->over, cos);
        v->clear.passes[k] = rgb_gray(coat);
        v->layers.passes[k] = covers_sheen_passes(&v->over, cos) * coat;
    }
}

/* --- what is left for the wide lobes --- */

/* What the coat keeps of the sheen's light goes down. */
static rgb sheen_loss(const struct view *v, float cos)
{
    const rgb color = v->m->principled.sheen_color;
    if (!(v->m->principled.clearcoat > 0) || rgb_is_black(color))
        return rgb_gray(0);
    return color * stack_loss(&v->clear, STACK_FIBRES, v->m->principled.sheen_roughness, cos);
}

/* And what both keep of what facets of a dielectric reflect. */
static rgb dielectric_loss(const struct view *v, float cos)
{
    const float r = (v->base.ior - 1) / (v->base.ior + 1), f0 = r * r;
    if (is_smooth(v->base.alpha))
        return sheen_loss(v, cos);
    return sheen_loss(v, cos) + stack_loss(&v->layers, STACK_FACETS, v->base.alpha, cos) * f0 +
           stack_loss(&v->layers, STACK_GRAZING, v->base.alpha, cos) * (1 - f0);
}

/* passes: coat and sheen, along the cosine. */
static rgb left_for_diffuse(const struct view *v, float cos, rgb passes)
{
    const float below = coat_passes(&v->base, cos);
    return v->layered ? passes * below + dielectric_loss(v, cos) : rgb_gray(below);
}

/* Over the way through: it comes back up. */
static rgb left_for_glass(const struct view *v, float cos, rgb passes)
{
    (void)passes;
    return dielectric_loss(v, cos);
}

static float missing_at(float alpha, float cos)
{
    const vec3 w = vec3_make(__builtin_sqrtf(cos < 1 ? (1 - cos) * (1 + cos) : 0), 0, cos);
    return albedo_missing(w, (struct facet){alpha, alpha});
}

static rgb left_for_metal(const struct view *v, float cos, rgb passes)
{
    const float alpha = v->base.alpha;
    const rgb missing = rgb_gray(is_smooth(alpha) ? 0 : missing_at(alpha, cos));
    if (!v->layered)
        return missing;
    const rgb left = passes * missing + sheen_loss(v, cos);
    return is_smooth(alpha) ? left : left + stack_loss(&v->layers, STACK_FACETS, alpha, cos);
}

typedef rgb left_for(const struct view *, float cos, rgb passes);

static rgb layered_mean(const struct view *v, left_for *left_for_one)
{
    rgb left[STACK_CELLS + 1];
    for (int k = 0; k <= STACK_CELLS; k++) {
        const float root = (float)k / STACK_CELLS;
        left[k] = left_for_one(v, root * root, v->layers.passes[k]);
    }
    return stack_mean(left);
}

static rgb diffuse_mean(const struct view *v)
{
    return v->layered ? layered_mean(v, left_for_diffuse) : rgb_gray(coat_passes_mean(&v->base));
}

static rgb divisor(rgb mean) /* where nothing is left, 0 is divided by it */
{
    const rgb none = rgb_gray(0x1p-20f);
    return vec3_choose(mean > none, mean, none);
}

static rgb metal_mean(const struct view *v)
{
    if (!v->layered)
        return rgb_gray(albedo_missing_mean((struct facet){v->base.alpha, v->base.alpha}));
    return divisor(layered_mean(v, left_for_metal));
}

/* --- the parts --- */

/* Of the wide lobes what layers leave to them is guessed: it needs all that they let pass. */
static float even_chance(const struct view *v, float cos, float below)
{
    const struct material *m = v->m;
    const float alpha = v->base.alpha, metallic = m->principled.metallic;
    const rgb k = coat_base(&v->base, coat_passes_mean(&v->base), m->principled.base_color);
    const float missing =
        metallic > 0 && !is_smooth(alpha) ? missing_at(alpha, cos) + 0.1f * v->layered * alpha : 0;
    return rgb_max(v->passes * k) * v->opaque * below +
           rgb_max(v->passes * m->principled.base_color) * metallic * missing +
           0.1f * (v->chance[LOBE_SHEEN] + v->layered * alpha * v->through);
}

static void set_chances(struct view *v, vec3 wo)
{
    const struct material *m = v->m;
    const float below = rgb_max(v->passes), base = coat_passes(&v->base, wo[2]);
    const float coat = covers_coat_passes(&v->over, wo[2]), metallic = m->principled.metallic;
    float *c = v->chance, sum = 0;
    c[LOBE_COAT] = 1 - coat;
    c[LOBE_SHEEN] = (1 - vec3_dot(covers_sheen_passes(&v->over, wo[2]), rgb_gray(1.0f / 3))) * coat;
    c[LOBE_FACETS] =
        below * (metallic * rgb_max(m->principled.base_color) + (1 - metallic) * (1 - base));
    c[LOBE_EVEN] = even_chance(v, wo[2], base);
    c[LOBE_GLASS] = below * v->through * base;
    for (int i = 0; i < LOBES; i++)
        sum += c[i];
    for (int i = 0; sum > 0 && i < LOBES; i++)
        c[i] /= sum;
}

/* What of the light that comes along wo the wide lobes return. Kulla and Conty's lobe of what
 * facets reflect again is coloured by F's mean (bsdf_metal.c): in reflect_eval, which needs a mean
 * that costs more. */
static void set_even(struct view *v, vec3 wo)
{
    const struct material *m = v->m;
    v->diffuse = v->again = rgb_gray(0);
    stack_layers(v);
    if (v->opaque > 0)
        v->diffuse = coat_base(&v->base, coat_passes_mean(&v->base), m->principled.base_color) *
                     left_for_diffuse(v, wo[2], v->passes) * v->opaque;
    if (m->principled.metallic > 0 && (v->layered || !is_smooth(v->base.alpha)))
        v->again = left_for_metal(v, wo[2], v->passes) * m->principled.metallic;
}

static rgb metal_again(const struct view *v, float cos, rgb passes)
{
    const rgb mean = metal_mean(v);
    const rgb f = v->m->principled.base_color + (1 - v->m->principled.base_color) * (1.0f / 21);
    return f * f * (1 - mean) / (1 - f * mean) * v->again * left_for_metal(v, cos, passes) / mean;
}

struct material bsdf_principled_glass(const struct material *m)
{
    const float alpha = m->principled.roughness * m->principled.roughness;
    return (struct material){
        .kind = MATERIAL_DIELECTRIC,
        .dielectric = {.ior = m->principled.ior, .alpha = alpha, .multiscatter = true}};
}

static struct view view_make(const struct material *m, vec3 wo)
{
    const float alpha = m->principled.roughness * m->principled.roughness;
    const float clear = (1 - m->principled.metallic) * m->principled.transmission;
    struct view v = {.m = m,
                     .glass = bsdf_principled_glass(m),
                     .over = covers_of(m),
                     .base = {m->principled.ior, alpha},
                     .opaque = (1 - m->principled.metallic) - clear,
                     .through = clear,
                     .chance = {0}};
    v.layered = covers_any(&v.over);
    v.passes = covers_pass(&v.over, wo[2]);
    set_chances(&v, wo);
    return v;
}

/* F of the base's facets. */
static rgb facets(const struct view *v, float cos)
{
    const float metallic = v->m->principled.metallic, c = 1 - cos, cc = c * c;
    const rgb f0 = v->m->principled.base_color;
    float cos_t;
    return (f0 + (1 - f0) * (cc * cc * (c > 0 ? c : 0))) * metallic +
           (1 - metallic) * fresnel_dielectric(cos < 1 ? cos : 1, v->base.ior, &cos_t);
}

/* What comes back of what the way through has left, above. */
static rgb glass_again(const struct view *v, vec3 wo, vec3 wi, rgb passes)
{
    rgb f = rgb_gray(0);
    if (!bsdf_is_delta(&v->glass))
        f = passes * bsdf_glass_several_eval(&v->glass, wo, wi);
    if (v->layered)
        f += dielectric_loss(v, wo[2]) * dielectric_loss(v, wi[2]) /
             divisor(layered_mean(v, left_for_glass)) * warp_cosine_pdf_w(wi[2]);
    return f * v->through;
}

static rgb reflect_eval(struct view *v, vec3 wo, vec3 wi)
{
    set_even(v, wo);
    const vec3 sum = wo + wi;
    const float length = vec3_length(sum), cos = 0.5f * length; /* the same both ways */
    const vec3 h = sum / length;
    const rgb passes = covers_pass(&v->over, wi[2]), less = smaller(v->passes, passes);
    const float even = warp_cosine_pdf_w(wi[2]);
    rgb f = rgb_gray(0);
    if (!rgb_is_black(v->diffuse))
        f += v->diffuse * left_for_diffuse(v, wi[2], passes) / diffuse_mean(v) * even;
    if (!rgb_is_black(v->again))
        f += metal_again(v, wi[2], passes) * even;
    if (!is_smooth(v->base.alpha))
        f += less * facets(v, cos) * microfacet_reflect(wo, wi, h, v->base.alpha);
    if (v->through > 0)
        f += glass_again(v, wo, wi, less);
    if (!rgb_is_black(v->m->principled.sheen_color)) {
        const float a = covers_coat_passes(&v->over, wo[2]),
                    b = covers_coat_passes(&v->over, wi[2]);
        f += v->m->principled.sheen_color *
             ((a < b ? a : b) * sheen_eval(v->m->principled.sheen_roughness, wo, wi));
    }
    float cos_t;
    if (v->m->principled.clearcoat > 0 && !is_smooth(v->over.coat.alpha))
        f += v->m->principled.clearcoat *
             fresnel_dielectric(cos < 1 ? cos : 1, v->over.coat.ior, &cos_t) *
             microfacet_reflect(wo, wi, h, v->over.coat.alpha);
    return f;
}

/* --- all --- */

static rgb eval(struct view *v, vec3 wo, vec3 wi)
{
    if (wi[2] > 0)
        return reflect_eval(v, wo, wi);
    if (!(v->through > 0) || bsdf_is_delta(&v->glass))
        return rgb_gray(0);
    return bsdf_glass_eval(&v->glass, wo, wi) * v->through * v->m->principled.base_color *
           v->passes;
}

static float pdf_w(const struct view *v, vec3 wo, vec3 wi)
{
    const float *c = v->chance;
    float p = 0;
    if (c[LOBE_GLASS] > 0 && !bsdf_is_delta(&v->glass))
        p += c[LOBE_GLASS] * bsdf_glass_pdf_w(&v->glass, wo, wi);
    if (!(wi[2] > 0))
        return p;
    const vec3 h = vec3_unit(wo + wi);
    if (c[LOBE_COAT] > 0 && !is_smooth(v->over.coat.alpha))
        p += c[LOBE_COAT] * microfacet_reflect_pdf_w(wo, h, v->over.coat.alpha);
    if (c[LOBE_SHEEN] > 0)
        p += c[LOBE_SHEEN] * sheen_pdf_w(v->m->principled.sheen_roughness, wo, wi);
    if (c[LOBE_FACETS] > 0 && !is_smooth(v->base.alpha))
        p += c[LOBE_FACETS] * microfacet_reflect_pdf_w(wo, h, v->base.alpha);
    return p + c[LOBE_EVEN] * warp_cosine_pdf_w(wi[2]);
}

rgb bsdf_principled_eval(const struct material *m, vec3 wo, vec3 wi)
{
    if (wo[2] < 0)
        return bsdf_inside_eval(m, wo, wi);
    struct view v = view_make(m, wo);
    return eval(&v, wo, wi);
}

float bsdf_principled_pdf_w(const struct material *m, vec3 wo, vec3 wi)
{
    if (wo[2] < 0)
        return bsdf_inside_pdf_w(m, wo, wi);
    const struct view v = view_make(m, wo);
    return pdf_w(&v, wo, wi);
}

/* --- sampling --- */

/* A mirror's direction, from the front. */
static bool mirrored(const struct view *v, vec3 wo, enum lobe lobe, struct bsdf_sample *s)
{
    float cos_t;
    const rgb f = lobe == LOBE_COAT ? rgb_gray(v->m->principled.clearcoat *
                                               fresnel_dielectric(wo[2], v->over.coat.ior, &cos_t))
                                    : facets(v, wo[2]) * v->passes;
    s->wi = local_reflect(wo);
    s->pdf_w = 0;
    s->weight = f / v->chance[lobe];
    return true;
}

/* Smooth glass: what goes through, the rest is the facets'. */
static bool refracted(const struct view *v, vec3 wo, struct bsdf_sample *s)
{
    const float n = v->base.ior;
    float cos_t;
    const float f = fresnel_dielectric(wo[2], n, &cos_t);
    s->wi = vec3_make(-wo[0] / n, -wo[1] / n, -cos_t);
    s->pdf_w = 0;
    s->scale = 1 / (n * n);
    s->weight = v->passes * v->m->principled.base_color *
                (v->through / v->chance[LOBE_GLASS] * (1 - f) * s->scale);
    return true;
}

static bool around_facet(float alpha, vec3 wo, struct square q, vec3 *wi)
{
    const vec3 h = microfacet_visible(wo, alpha, q);
    *wi = vec3_unit(2 * vec3_dot(wo, h) * h - wo);
    return (*wi)[2] > 0;
}

/* A direction of a lobe that is not single. */
static bool direction_of(const struct view *v, enum lobe lobe, vec3 wo, float rest, struct square q,
                         struct bsdf_sample *s)
{
    switch (lobe) {
    case LOBE_COAT:
        return around_facet(v->over.coat.alpha, wo, q, &s->wi);
    case LOBE_SHEEN:
        return sheen_sample(v->m->principled.sheen_roughness, wo, rest, q, &s->wi);
    case LOBE_FACETS:
        return around_facet(v->base.alpha, wo, q, &s->wi);
    case LOBE_EVEN:
        s->wi = warp_cosine(q);
        return s->wi[2] > 0;
    case LOBE_GLASS:
        return bsdf_glass_sample(&v->glass, wo, rest, q, s);
    case LOBES:
        break;
    }
    __builtin_unreachable();
}

bool bsdf_principled_sample(const struct material *m, vec3 wo, float number, struct square q,
                            struct bsdf_sample *s)
{
    if (wo[2] < 0)
        return bsdf_inside_sample(m, wo, number, q, s);
    struct view v = view_make(m, wo);
    int lobe = 0;
    while (lobe < LOBES && number >= v.chance[lobe])
        number -= v.chance[lobe++];
    if (lobe == LOBES)
        return false;
    const float rest = number / v.chance[lobe];
    if (lobe == LOBE_GLASS && bsdf_is_delta(&v.glass))
        return refracted(&v, wo, s);
    if ((lobe == LOBE_COAT && is_smooth(v.over.coat.alpha)) ||
        (lobe == LOBE_FACETS && is_smooth(v.base.alpha)))
        return mirrored(&v, wo, (enum lobe)lobe, s);
    if (!direction_of(&v, (enum lobe)lobe, wo, rest < 1 ? rest : 1 - 0x1p-24f, q, s))
        return false;
    s->pdf_w = pdf_w(&v, wo, s->wi);
    s->weight = eval(&v, wo, s->wi) / s->pdf_w;
    return s->pdf_w > 0;
}
