/* SPDX-License-Identifier: MIT */
#include "common/trace/inside.h"

#include "common/trace/knot.h"
#include "common/trace/simd.h"

#define R_LEAST 0.0476190476f /* (n - 1) / (n + 1) of 1.1 */
#define R_MOST  0.5f          /* of 3 */

static struct knot knot_of_width(float alpha)
{
    return knot_within((__builtin_sqrtf(alpha) - 0x1p-5f) / (1 - 0x1p-5f), INSIDE_WIDTHS);
}

/* Within the critical angle even in the root of the refracted light's cosine; beyond it, the
 * knots lie as dense as the facets' width asks (the height of albedo.c). */
float inside_height(float ior, float alpha, float cos)
{
    const float nn = ior * ior, uu = nn * cos * cos - (nn - 1);
    if (uu >= 0)
        return INSIDE_BEYOND + INSIDE_WITHIN * __builtin_sqrtf(__builtin_sqrtf(uu < 1 ? uu : 1));
    const float critical = __builtin_sqrtf(1 - 1 / nn), width = alpha / critical;
    const float beyond = (critical - cos) / critical, b = beyond > 0 ? beyond : 0;
    return INSIDE_BEYOND * (1 - b * (1 + width) / (b + width));
}

static float side(struct knot k, int far)
{
    return far ? k.f : 1 - k.f;
}

void inside_parts(const struct inside_table *t, const struct inside_glass *in, float cos,
                  float parts[INSIDE_PARTS])
{
    const struct knot n = knot_of_root_r(in->ior, R_LEAST, R_MOST, INSIDE_IORS),
                      w = knot_of_width(in->alpha);
    const struct knot h =
        knot_of(inside_height(in->ior, in->alpha, cos) / (INSIDE_HEIGHTS - 1), INSIDE_HEIGHTS);
    for (int k = 0; k < INSIDE_PARTS; k++)
        parts[k] = 0;
    for (int c = 0; c < 8; c++) {
        const int i = c & 1, j = c >> 1 & 1, l = c >> 2;
        const float share = side(n, i) * side(w, j) * side(h, l) * (1.0f / 65535);
        const uint16_t *row = t->part[n.i + i][w.i + j][h.i + l];
        for (int k = 0; k < INSIDE_PARTS; k++)
            parts[k] += share * row[k];
    }
}

/* Of n values of one index and width. */
static void blend(const float *first, const struct inside_glass *in, int n, float *out)
{
    const struct knot a = knot_of_root_r(in->ior, R_LEAST, R_MOST, INSIDE_IORS),
                      w = knot_of_width(in->alpha);
    for (int k = 0; k < n; k++) {
        const float *at = first + (a.i * INSIDE_WIDTHS + w.i) * n + k;
        out[k] =
            knot_blend(knot_blend(at[0], at[n], w.f),
                       knot_blend(at[INSIDE_WIDTHS * n], at[(INSIDE_WIDTHS + 1) * n], w.f), a.f);
    }
}

static rgb kept(const struct inside_glass *in, const float factors[INSIDE_CELLS])
{
    rgb sum = {0, 0, 0, 0};
    for (int k = 0; k < INSIDE_CELLS; k++)
        sum += in->kept[k] * factors[k];
    return sum;
}

static rgb less_mirrored(const struct inside_glass *in, const float parts[INSIDE_PARTS],
                         float missing)
{
    float several[INSIDE_CELLS];
    blend(inside_table.several[0][0], in, INSIDE_CELLS, several);
    return kept(in, parts) + kept(in, several) * missing -
           (in->straight * parts[INSIDE_CELLS] + in->steep * parts[INSIDE_CELLS + 1]);
}

/* A little less of everything: between knots it may be too much, by up to 0.003. */
#define SHARE 0.995f
#define SLACK 0.002f

float inside_mirrors(const struct inside_glass *in, float cos)
{
    const float up = cos + in->alpha, c = up < 1 ? 1 - up : 0, ccc = c * c * c;
    return (in->straight + in->steep * (ccc * ccc)) * SHARE;
}

rgb inside_left(const struct inside_glass *in, float cos, float missing)
{
    float parts[INSIDE_PARTS];
    inside_parts(&inside_table, in, cos, parts);
    const rgb found = less_mirrored(in, parts, missing), none = {0, 0, 0, 0};
    const rgb left = vec3_choose(found > none, found, none) * SHARE;
    return left * left / (left + SLACK);
}

rgb inside_mean(const struct inside_glass *in, float missing_mean)
{
    float parts[INSIDE_PARTS];
    blend(inside_table.mean[0][0], in, INSIDE_PARTS, parts);
    return less_mirrored(in, parts, missing_mean);
}
