/* SPDX-License-Identifier: MIT */
#include "common/trace/coat.h"

#include "common/trace/albedo.h"
#include "common/trace/bsdf.h"
#include "common/trace/coat_table.h"
#include "common/trace/fresnel.h"
#include "common/trace/knot.h"
#include "common/trace/microfacet.h"

#define R_LEAST 0.0476190476f /* (n - 1) / (n + 1) of 1.1 */
#define R_MOST  0.5f          /* of 3 */

static float r_of(float ior)
{
    return (ior - 1) / (ior + 1);
}

static struct knot knot_of_ior(float ior)
{
    return knot_of((r_of(ior) - R_LEAST) / (R_MOST - R_LEAST), COAT_IORS);
}

static struct knot knot_of_width(float alpha)
{
    return knot_of(__builtin_sqrtf(alpha), COAT_WIDTHS);
}

static float plane(const uint16_t t[COAT_WIDTHS][COAT_SLOPES], struct knot width, struct knot slope)
{
    const uint16_t *a = t[width.i] + slope.i, *b = t[width.i + 1] + slope.i;
    return knot_blend(knot_blend(a[0], a[1], slope.f), knot_blend(b[0], b[1], slope.f), width.f);
}

/* What a table between its knots may be too large by, taken off. */
#define TOO_LARGE 0.002f

float coat_table_passes(const struct coat_table *t, float ior, float alpha, float cos)
{
    const vec3 w = vec3_make(__builtin_sqrtf(cos < 1 ? (1 - cos) * (1 + cos) : 0), 0, cos);
    const float sum = cos + microfacet_s(w, alpha);
    const struct knot n = knot_of_ior(ior), width = knot_of_width(alpha);
    const struct knot slope = knot_of(__builtin_sqrtf(alpha * w[0] / sum), COAT_SLOPES);
    const float ratio = knot_blend(plane(t->ratio[n.i], width, slope),
                                   plane(t->ratio[n.i + 1], width, slope), n.f) *
                        (1.0f / COAT_RATIO_ONE);
    float cos_t;
    const float dark = 1 - fresnel_dielectric(0.5f * sum, ior, &cos_t);
    const float once = 1 - albedo_missing(w, (struct facet){alpha, alpha});
    const float passes = 1 - once * (1 - ratio * dark) - TOO_LARGE;
    return passes > 0 ? (passes < 1 ? passes : 1) : 0;
}

float coat_passes(const struct coat *c, float cos)
{
    float cos_t;
    if (c->alpha < BSDF_LEAST_ALPHA)
        return 1 - fresnel_dielectric(cos, c->ior, &cos_t);
    return coat_table_passes(&coat_table, c->ior, c->alpha, cos);
}

/* The mean of F, which is Duntley's, to 1e-5: a polynomial in r, interpolated at the Chebyshev
 * nodes. */
static float smooth_mean(float r)
{
    const float low = 0.00121205626f + r * (0.558973014f + r * (-1.51176918f + r * 8.03477097f));
    const float high = -22.1949558f + r * (40.1916504f + r * (-40.8754997f + r * 17.7891521f));
    return low + (r * r) * (r * r) * high;
}

float coat_passes_mean(const struct coat *c)
{
    if (c->alpha < BSDF_LEAST_ALPHA)
        return 1 - smooth_mean(r_of(c->ior));
    const struct knot n = knot_of_ior(c->ior), width = knot_of_width(c->alpha);
    const float *a = coat_table.mean[n.i] + width.i, *b = coat_table.mean[n.i + 1] + width.i;
    return knot_blend(knot_blend(a[0], a[1], width.f), knot_blend(b[0], b[1], width.f), n.f);
}

rgb coat_base(const struct coat *c, float mean, rgb albedo)
{
    const float leaves = mean / (c->ior * c->ior); /* of even light inside */
    return albedo * leaves / (1 - albedo * (1 - leaves));
}
