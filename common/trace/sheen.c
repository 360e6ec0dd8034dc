/* SPDX-License-Identifier: MIT */
#include "common/trace/sheen.h"

#include "common/trace/fmath.h"
#include "common/trace/knot.h"

/* --- how much --- */

static struct knot knot_of_width(float roughness)
{
    return knot_of((roughness - 0.1f) / 0.9f, SHEEN_WIDTHS);
}

/* What a table between its knots may be too small by, put on. */
#define TOO_SMALL 0.003f

float sheen_table_albedo(const struct sheen_table *t, float roughness, float cos)
{
    const struct knot w = knot_of_width(roughness);
    const struct knot z = knot_of(__builtin_sqrtf(cos), SHEEN_COSINES);
    const float *a = t->albedo[w.i] + z.i, *b = t->albedo[w.i + 1] + z.i;
    const float e =
        knot_blend(knot_blend(a[0], a[1], z.f), knot_blend(b[0], b[1], z.f), w.f) + TOO_SMALL;
    return e < 1 ? e : 1;
}

float sheen_albedo(float roughness, float cos)
{
    return sheen_table_albedo(&sheen_table, roughness, cos);
}

float sheen_mean(float roughness)
{
    const struct knot w = knot_of_width(roughness);
    return knot_blend(sheen_table.mean[w.i], sheen_table.mean[w.i + 1], w.f);
}

/* --- where to --- */

static float power_of(float roughness)
{
    return 1 / (roughness * roughness);
}

static float d_of(float k, vec3 h)
{
    const float sine = __builtin_sqrtf(h[0] * h[0] + h[1] * h[1]);
    return (k + 2) * 0.5f * FMATH_INV_PI * fmath_pow(sine, k);
}

float sheen_eval(float roughness, vec3 wo, vec3 wi)
{
    const vec3 sum = wo + wi;
    const float length = vec3_length(sum); /* twice the cosine at the facet: the same both ways */
    const vec3 h = sum / length;
    const float seen = wo[2] < wi[2] ? wo[2] : wi[2], g = 4 * h[2] * seen / length;
    return d_of(power_of(roughness), h) * (g < 1 ? g : 1) / (4 * wo[2]);
}

/* Of a facet and of the one across, what is seen of both. */
static float seen_of_both(vec3 wo, vec3 h)
{
    const float across = wo[2] * h[2] - (wo[0] * h[0] + wo[1] * h[1]), own = vec3_dot(wo, h);
    return own + (across > 0 ? across : 0);
}

float sheen_pdf_w(float roughness, vec3 wo, vec3 wi)
{
    const vec3 h = vec3_unit(wo + wi);
    return d_of(power_of(roughness), h) * h[2] * 0.5f / seen_of_both(wo, h);
}

bool sheen_sample(float roughness, vec3 wo, float side, struct square q, vec3 *wi)
{
    float s, c;
    fmath_sincos_turns(q.u, &s, &c);
    const float sine = fmath_pow(q.v, 1 / (power_of(roughness) + 2));
    const float z = __builtin_sqrtf(sine < 1 ? (1 - sine) * (1 + sine) : 0);
    vec3 h = vec3_make(sine * c, sine * s, z);
    const float own = vec3_dot(wo, h);
    const float across = wo[2] * z - (wo[0] * h[0] + wo[1] * h[1]);
    const float a = own > 0 ? own : 0, b = across > 0 ? across : 0;
    if (!(side * (a + b) < a))
        h = vec3_make(-h[0], -h[1], z);
    *wi = vec3_unit(2 * vec3_dot(wo, h) * h - wo);
    return (*wi)[2] > 0;
}
