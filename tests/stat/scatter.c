/* SPDX-License-Identifier: MIT */
#include "tests/stat/scatter.h"

#include <math.h>

#include "tests/dice.h"

/* --- bsdf.h as callbacks --- */

static rgb material_eval(const void *what, vec3 wo, vec3 wi)
{
    return bsdf_eval(what, wo, wi);
}

static float material_pdf_w(const void *what, vec3 wo, vec3 wi)
{
    return bsdf_pdf_w(what, wo, wi);
}

static bool material_sample(const void *what, vec3 wo, float lobe, struct square q,
                            struct bsdf_sample *s)
{
    return bsdf_sample(what, wo, lobe, q, s);
}

static double index_of(const struct material *m)
{
    if (m->kind == MATERIAL_PRINCIPLED && m->principled.transmission > 0)
        return (double)m->principled.ior;
    return m->kind == MATERIAL_DIELECTRIC ? (double)m->dielectric.ior : 1;
}

static float lobe_width(const struct material *m)
{
    switch (m->kind) {
    case MATERIAL_CONDUCTOR:
        return m->conductor.alpha;
    case MATERIAL_DIELECTRIC:
        return m->dielectric.alpha;
    case MATERIAL_METAL:
        return fmaxf(m->metal.alpha_x, m->metal.alpha_y);
    case MATERIAL_RETROREFLECTOR:
        return m->retro.alpha;
    case MATERIAL_PLASTIC: /* a wide lobe, too */
    case MATERIAL_PRINCIPLED:
    case MATERIAL_CLOTH:
    case MATERIAL_DIFFUSE:
    case MATERIAL_MIRROR:
    case MATERIAL_ROUGH_DIFFUSE:
    case MATERIAL_LEAF:
    case MATERIAL_MIX:
    case MATERIAL_MASK:
    case MATERIAL_TWO_SIDED:
    case MATERIAL_PANE:
        break;
    }
    return 1;
}

/* What is sampled by visible facets or by the cosine is 1 at most. */
static double largest_weight(const struct material *m)
{
    if (m->kind == MATERIAL_METAL && m->metal.multiscatter)
        return 3;
    if (m->kind == MATERIAL_DIELECTRIC && m->dielectric.multiscatter)
        return 4;
    if (m->kind == MATERIAL_PLASTIC)
        return 40;
    if (m->kind ==
        MATERIAL_PRINCIPLED) /* seen from the side, a coat of small chance is met head on */
        return 200;
    if (m->kind == MATERIAL_CLOTH)
        return 3;
    if (m->kind == MATERIAL_ROUGH_DIFFUSE)
        return 1.3;
    return m->kind == MATERIAL_LEAF ? 2.00001 : 1.00001;
}

struct scatter scatter_of(const struct material *m)
{
    return (struct scatter){
        .eval = material_eval,
        .pdf_w = material_pdf_w,
        .sample = material_sample,
        .what = m,
        .ior = index_of(m),
        .alpha = lobe_width(m),
        .retro = m->kind == MATERIAL_RETROREFLECTOR,
        .most = largest_weight(m),
        .slow = m->kind == MATERIAL_PRINCIPLED,
    };
}

static bool looked_at(const struct scatter *s, vec3 wo, vec3 wi)
{
    return s->side == SCATTER_ALL || (wo[2] * wi[2] < 0) == (s->side == SCATTER_THROUGH);
}

/* far / near, seen from wo. */
static double eta_from(const struct scatter *s, vec3 wo)
{
    return wo[2] > 0 ? s->ior : 1 / s->ior;
}

/* --- seen from one direction --- */

struct view {
    const struct scatter *s;
    vec3 wo;
    struct dice *lobes; /* what chooses among kinds of scattering */
    int channel;
};

static bool view_sample(const void *what, struct square q, vec3 *w, float *pdf_w)
{
    const struct view *v = what;
    struct bsdf_sample s;
    if (!v->s->sample(v->s->what, v->wo, dice_float(v->lobes), q, &s) ||
        !looked_at(v->s, v->wo, s.wi) || s.pdf_w == 0)
        return false;
    *w = s.wi;
    *pdf_w = s.pdf_w;
    return true;
}

static float view_pdf_w(const void *what, vec3 w)
{
    const struct view *v = what;
    return looked_at(v->s, v->wo, w) ? v->s->pdf_w(v->s->what, v->wo, w) : 0;
}

static double view_eval(const void *what, vec3 w)
{
    const struct view *v = what;
    if (!looked_at(v->s, v->wo, w))
        return 0;
    const double eta = w[2] * v->wo[2] < 0 ? eta_from(v->s, v->wo) : 1;
    return (double)v->s->eval(v->s->what, v->wo, w)[v->channel] * eta * eta;
}

/* Refracted by a smooth surface, or just below the horizon where that would reflect all. */
static vec3 refracted(const struct scatter *s, vec3 wo)
{
    const double eta = eta_from(s, wo), x = -(double)wo[0] / eta, y = -(double)wo[1] / eta;
    const double z = sqrt(fmax(1e-6, 1 - x * x - y * y));
    return vec3_make((float)x, (float)y, (float)(wo[2] > 0 ? -z : z));
}

/* Wide lobes in plain rows, narrow ones around their middle; and no finer than rounding: directions
 * are off by 2^-24, which is so much of a lobe alpha wide. */
static struct sphere_chart view_chart(const struct view *v)
{
    const double alpha = (double)v->s->alpha;
    if (v->s->side == SCATTER_THROUGH) { /* a facet turned by a turns it by (1 - 1 / eta) a */
        const double narrower = 0.5 * alpha * fabs(1 - 1 / eta_from(v->s, v->wo));
        if (alpha < 0.25)
            return sphere_chart_make(refracted(v->s, v->wo), narrower * narrower);
        /* Steep facets turn it by a good deal more: a long tail. Where a smooth surface lets
         * nothing through, the horizon cuts it, and from 89.9 degrees plain rows are better. */
        const double eta = eta_from(v->s, v->wo), sine = hypot((double)v->wo[0], (double)v->wo[1]);
        if (narrower < 0.015 && (sine < eta || fabsf(v->wo[2]) > .01f))
            return sphere_chart_make(refracted(v->s, v->wo), 0.05 * 0.05);
    }
    if (alpha >= 0.25)
        return sphere_chart_make(vec3_make(0, 0, 1), 0);
    if (v->s->retro)
        return sphere_chart_make(v->wo, alpha * alpha);
    return sphere_chart_make(vec3_make(-v->wo[0], -v->wo[1], v->wo[2]), alpha * alpha);
}

static double view_tolerance(const struct view *v)
{
    return fmax(1e-5, 1e-6 / (double)v->s->alpha);
}

struct sphere_chi2_result scatter_follows(const struct scatter *s, vec3 wo, uint32_t samples,
                                          uint64_t seed)
{
    struct dice lobes = dice_make(~seed);
    const struct view v = {s, wo, &lobes, 0};
    const struct sphere_chart chart = view_chart(&v);
    const struct sphere_chi2 t = {.sample = view_sample,
                                  .pdf_w = view_pdf_w,
                                  .what = &v,
                                  .chart = &chart,
                                  .min_depth = s->ior != 1, /* thin ends, which 9 points miss */
                                  .horizon = true,
                                  .more_depth =
                                      stat_is_long() ? 1 : -1, /* as many samples see more */
                                  .tolerance = view_tolerance(&v)};
    return sphere_chi2_run(&t, samples, seed);
}

double scatter_albedo(const struct scatter *s, vec3 wo, int channel)
{
    enum { SIDE = 32 };
    const struct view v = {s, wo, NULL, channel};
    const struct sphere_chart chart = view_chart(&v);
    const bool glass = s->ior != 1; /* its narrow lobe may lie between 9 points of a cell */
    const struct sphere_integrand f = {.f = view_eval,
                                       .what = &v,
                                       .min_depth = glass ? 2 : 1,
                                       .max_depth = stat_is_long() ? 7 : (STAT_SLOW == 1 ? 5 : 3),
                                       .horizon = true,
                                       .trust_zero = !glass,
                                       .tolerance = view_tolerance(&v)};
    double sum = 0;
    for (int i = 0; i < SIDE * SIDE; i++) {
        const double row = i / SIDE, column = i % SIDE;
        sum += sphere_chart_integral(&chart, &f, (struct sphere_place){row / SIDE, column / SIDE},
                                     (struct sphere_place){(row + 1) / SIDE, (column + 1) / SIDE});
    }
    return sum;
}

/* --- many samples --- */

static struct square square_of(struct dice *dice)
{
    struct square q;
    q.u = dice_float(dice);
    q.v = dice_float(dice);
    return q;
}

static vec3 even_direction(struct dice *dice)
{
    const double z = dice_range(dice, -1, 1), phi = dice_range(dice, 0, 6.283185307179586);
    const double r = sqrt(1 - z * z);
    return vec3_make((float)(r * cos(phi)), (float)(r * sin(phi)), (float)z);
}

static bool valid(rgb f, float pdf_w)
{
    bool good = pdf_w >= 0 && isfinite(pdf_w);
    for (int c = 0; c < 3; c++)
        good &= f[c] >= 0 && isfinite(f[c]);
    return good;
}

/* At the horizon, where the smallest change of a direction changes eval and pdf by as much as they
 * are, weights are not compared. */
static const float horizon = 1e-4f;

static void compare_weight(const struct scatter *s, vec3 wo, const struct bsdf_sample *b,
                           struct scatter_draw *d)
{
    const rgb f = s->eval(s->what, wo, b->wi);
    d->invalid += !valid(f, b->pdf_w) || !valid(b->weight, s->pdf_w(s->what, wo, b->wi));
    for (int c = 0; c < 3; c++) {
        const double weight = (double)b->weight[c] * (double)b->pdf_w, eval = (double)f[c];
        if (fabsf(b->wi[2]) > horizon && (weight > 0 || eval > 0))
            d->off = fmax(d->off, fabs(weight - eval) / fmax(weight, eval));
    }
}

struct scatter_draw scatter_draw(const struct scatter *s, vec3 wo, uint32_t samples, uint64_t seed)
{
    struct dice dice = dice_make(seed);
    struct scatter_draw d = {.most = 0};
    for (uint32_t i = 0; i < samples; i++) {
        struct bsdf_sample b = {.scale = 1};
        const float lobe = dice_float(&dice);
        const bool alive =
            s->sample(s->what, wo, lobe, square_of(&dice), &b) && looked_at(s, wo, b.wi);
        for (int c = 0; c < 3; c++) {
            const double weight = alive ? (double)(b.weight[c] / b.scale) : 0;
            const bool delta = alive && b.pdf_w == 0;
            stat_add(&d.albedo[c], delta ? 0 : weight);
            stat_add(&d.delta[c], delta ? weight : 0);
            d.most = fmax(d.most, weight);
        }
        if (alive && b.pdf_w != 0)
            compare_weight(s, wo, &b, &d);
        const vec3 w = even_direction(&dice);
        const rgb f = s->eval(s->what, wo, w);
        const float pdf_w = s->pdf_w(s->what, wo, w);
        d.invalid += !valid(f, pdf_w);
        d.beyond += rgb_max(f) > 0 && !(pdf_w > 0);
    }
    return d;
}

/* f(w -> o) n_w^2, the index at w's side. */
static rgb both_ways(const struct scatter *s, vec3 o, vec3 w)
{
    const float n = w[2] < 0 ? (float)s->ior : 1;
    return s->eval(s->what, o, w) * (n * n / fabsf(w[2]));
}

struct scatter_reciprocal scatter_reciprocal(const struct scatter *s, uint32_t pairs, uint64_t seed)
{
    struct dice dice = dice_make(seed);
    struct scatter_reciprocal r = {0, 0, 0};
    for (uint32_t i = 0; i < pairs; i++) {
        const vec3 o = even_direction(&dice);
        struct bsdf_sample b = {.wi = even_direction(&dice)};
        const float lobe = dice_float(&dice);
        const struct square q = square_of(&dice);
        if (i & 1 && (!s->sample(s->what, o, lobe, q, &b) || b.pdf_w == 0))
            continue;
        if (fabsf(o[2]) < horizon || fabsf(b.wi[2]) < horizon)
            continue;
        const rgb f = both_ways(s, o, b.wi), g = both_ways(s, b.wi, o);
        r.invalid += !valid(f, 0) || !valid(g, 0);
        r.alive += rgb_max(f) > 0;
        const vec3 i_seen = s->retro ? vec3_make(-b.wi[0], -b.wi[1], b.wi[2]) : b.wi;
        const double share = 1e-5 + 0x1p-20 / (double)vec3_length(o + i_seen);
        for (int c = 0; c < 3; c++) {
            const double a = (double)f[c], z = (double)g[c];
            r.worst = fmax(r.worst, fabs(a - z) / (share * fmax(a, z) + 1e-6));
        }
    }
    return r;
}

/* --- single directions --- */

static bool choose(const struct scatter *s, vec3 wo, uint32_t lobe, struct bsdf_sample *b)
{
    return s->sample(s->what, wo, (float)lobe * 0x1p-24f, (struct square){0.5f, 0.5f}, b);
}

static bool same(vec3 a, vec3 b)
{
    return a[0] == b[0] && a[1] == b[1] && a[2] == b[2];
}

int scatter_choices(const struct scatter *s, vec3 wo, struct scatter_choice out[2])
{
    uint32_t lo = 0, hi = (1u << 24) - 1;
    if (!choose(s, wo, lo, &out[0].sample) || !choose(s, wo, hi, &out[1].sample))
        return 0;
    out[0].chance = 1;
    if (same(out[0].sample.wi, out[1].sample.wi))
        return 1;
    while (hi - lo > 1) { /* lo gives the first, hi not */
        const uint32_t lobe = lo + (hi - lo) / 2;
        struct bsdf_sample b;
        if (choose(s, wo, lobe, &b) && same(b.wi, out[0].sample.wi))
            lo = lobe;
        else
            hi = lobe;
    }
    out[0].chance = hi * 0x1p-24;
    out[1].chance = 1 - out[0].chance;
    return 2;
}
