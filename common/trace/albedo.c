/* SPDX-License-Identifier: MIT */
#include "common/trace/albedo.h"

#include "common/trace/albedo_table.h"
#include "common/trace/knot.h"

/* The coordinates, each from 0 to 1, in which E is smoothest:
 *
 *     width   sqrt(alpha), of the larger width
 *     ratio   sqrt(smaller / larger width)
 *     turn    sqrt((s - smaller) / (larger - smaller)), s the width as seen from w's azimuth
 *     height  w.z (1 + s) / (w.z + s): what happens, happens where w.z is about s
 */

static inline float between(const uint16_t *row, struct knot k)
{
    return knot_blend((float)row[k.i], (float)row[k.i + 1], k.f);
}

static inline float height_of(float cos, float s)
{
    return cos * (1 + s) / (cos + s);
}

static float one_missing(const struct albedo_table *t, float cos, float alpha)
{
    const struct knot width = knot_within(__builtin_sqrtf(alpha), ALBEDO_WIDTHS);
    const struct knot height = knot_within(height_of(cos, alpha), ALBEDO_HEIGHTS);
    const float sum = knot_blend(between(t->one + width.i * ALBEDO_HEIGHTS, height),
                                 between(t->one + (width.i + 1) * ALBEDO_HEIGHTS, height), width.f);
    return sum * (1.0f / 65535);
}

static float two_missing(const struct albedo_table *t, vec3 w, struct facet a)
{
    const float larger = a.x > a.y ? a.x : a.y, smaller = a.x > a.y ? a.y : a.x;
    const vec3 flat = facet_stretch(vec3_make(w[0], w[1], 0), a);
    const float ss = w[0] * w[0] + w[1] * w[1];
    const float seen = ss > 0 ? vec3_length(flat) / __builtin_sqrtf(ss) : larger;
    const float above = seen > smaller ? (seen - smaller) / (larger - smaller) : 0;
    const struct knot width = knot_within(__builtin_sqrtf(larger), ALBEDO_WIDER);
    const struct knot ratio = knot_within(__builtin_sqrtf(smaller / larger), ALBEDO_RATIOS);
    const struct knot turn = knot_within(__builtin_sqrtf(above), ALBEDO_TURNS);
    const struct knot height = knot_within(height_of(w[2], seen), ALBEDO_FEWER_HEIGHTS);
    float planes[2];
    for (uint32_t i = 0; i < 2; i++) {
        float lines[2];
        for (uint32_t k = 0; k < 2; k++) {
            const uint32_t pair = (width.i + i) * ALBEDO_RATIOS + ratio.i + k;
            const uint16_t *row = t->two + (pair * ALBEDO_TURNS + turn.i) * ALBEDO_FEWER_HEIGHTS;
            lines[k] = knot_blend(between(row, height), between(row + ALBEDO_FEWER_HEIGHTS, height),
                                  turn.f);
        }
        planes[i] = knot_blend(lines[0], lines[1], ratio.f);
    }
    return knot_blend(planes[0], planes[1], width.f) * (1.0f / 65535);
}

float albedo_missing_by(const struct albedo_table *t, vec3 w, struct facet a)
{
    return a.x == a.y ? one_missing(t, w[2], a.x) : two_missing(t, w, a);
}

float albedo_missing(vec3 w, struct facet a)
{
    return albedo_missing_by(&albedo_table, w, a);
}

float albedo_missing_mean(struct facet a)
{
    const float larger = a.x > a.y ? a.x : a.y, smaller = a.x > a.y ? a.y : a.x;
    float mean;
    if (a.x == a.y) {
        const struct knot width = knot_within(__builtin_sqrtf(larger), ALBEDO_MEAN_WIDTHS);
        const float *row = albedo_table.mean_one;
        mean = knot_blend(row[width.i], row[width.i + 1], width.f);
    } else {
        const struct knot width = knot_within(__builtin_sqrtf(larger), ALBEDO_MEAN_WIDER);
        const struct knot ratio =
            knot_within(__builtin_sqrtf(smaller / larger), ALBEDO_MEAN_RATIOS);
        const float *low = albedo_table.mean_two + width.i * ALBEDO_MEAN_RATIOS + ratio.i;
        const float *high = low + ALBEDO_MEAN_RATIOS;
        mean = knot_blend(knot_blend(low[0], low[1], ratio.f),
                          knot_blend(high[0], high[1], ratio.f), width.f);
    }
    return mean > 0x1p-20f ? mean : 0x1p-20f; /* where nothing is missing, 0 is divided by it */
}
