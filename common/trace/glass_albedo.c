/* SPDX-License-Identifier: MIT */
#include "common/trace/glass_albedo.h"

#include "common/trace/knot.h"

#define R_LEAST 0.0476190476f /* (n - 1) / (n + 1) of 1.1 */
#define R_MOST  0.6f          /* of 4 */

static struct knot knot_of_width(float alpha)
{
    return knot_within(__builtin_sqrtf(alpha), GLASS_ALBEDO_WIDTHS);
}

static float plane(const uint16_t t[GLASS_ALBEDO_WIDTHS][GLASS_ALBEDO_HEIGHTS], struct knot width,
                   struct knot height)
{
    const uint16_t *a = t[width.i] + height.i, *b = t[width.i + 1] + height.i;
    return knot_blend(knot_blend(a[0], a[1], height.f), knot_blend(b[0], b[1], height.f), width.f);
}

float glass_albedo_missing_by(const struct glass_albedo_table *t, const struct glass_albedo *g,
                              bool below, float cos)
{
    const struct knot n = knot_of_root_r(g->ior, R_LEAST, R_MOST, GLASS_ALBEDO_IORS),
                      width = knot_of_width(g->alpha);
    const struct knot height =
        knot_within(cos * (1 + g->alpha) / (cos + g->alpha), GLASS_ALBEDO_HEIGHTS);
    return knot_blend(plane(t->missing[below][n.i], width, height),
                      plane(t->missing[below][n.i + 1], width, height), n.f) *
           (1.0f / 65535);
}

/* Towards an index of 1 refraction turns into passing straight on, which no facet blocks. */
static float known_share(float ior)
{
    return ior < 1.1f ? 10 * (ior - 1) : 1;
}

float glass_albedo_missing(const struct glass_albedo *g, bool below, float cos)
{
    return known_share(g->ior) * glass_albedo_missing_by(&glass_albedo_table, g, below, cos);
}

float glass_albedo_mean(const struct glass_albedo *g, bool below)
{
    const struct knot n = knot_of_root_r(g->ior, R_LEAST, R_MOST, GLASS_ALBEDO_IORS),
                      width = knot_of_width(g->alpha);
    const float *a = glass_albedo_table.mean[below][n.i] + width.i;
    const float *b = glass_albedo_table.mean[below][n.i + 1] + width.i;
    return known_share(g->ior) *
           knot_blend(knot_blend(a[0], a[1], width.f), knot_blend(b[0], b[1], width.f), n.f);
}
