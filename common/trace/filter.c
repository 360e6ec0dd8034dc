/* SPDX-License-Identifier: MIT */
#include "common/trace/filter.h"

/* Where the mass on one side of the middle reaches t in [0, 1]. Pieces without mass are passed
 * over: some part of t is left for the one that is chosen. */
static float side_at(const struct stage_knot *knots, float t)
{
    const struct stage_knot *k = knots;
    for (uint32_t step = FILTER_PIECES / 2; step; step /= 2)
        k += k[step].cdf < t ? step : 0;
    /* density s + (change of density per pixel) s^2 / 2 = rest */
    const float rest = t - k[0].cdf, width = k[1].x_px - k[0].x_px, density = k[0].density;
    const float square = density * density + 2 * rest * (k[1].density - density) / width;
    const float s = 2 * rest / (density + __builtin_sqrtf(square > 0 ? square : 0));
    return k[0].x_px + (s < width ? s : width);
}

static f32x8 by_knots(const struct stage *s, f32x8 u)
{
    const struct stage_knot *knots = stage_at(s, s->knots);
    f32x8 x;
    for (int i = 0; i < 8; i++) {
        const float t = 2 * u[i] - 1; /* exact */
        x[i] = t < 0 ? -side_at(knots, -t) : side_at(knots, t);
    }
    return x;
}

f32x8 filter_offset(const struct stage *s, f32x8 u)
{
    const float radius = s->film.filter_radius_px;
    switch (s->film.filter) {
    case FILTER_BOX:
        return (2 * u - 1) * radius;
    case FILTER_TENT: { /* the inverse of the integral of 1 - |x|, one side at a time */
        const f32x8 left = f32x8_sqrt(2 * u) - 1, right = 1 - f32x8_sqrt(2 - 2 * u);
        return f32x8_choose(u < 0.5f, left, right) * radius;
    }
    case FILTER_GAUSSIAN:
    case FILTER_BLACKMAN_HARRIS:
    case FILTER_MITCHELL:
        return by_knots(s, u);
    }
    __builtin_unreachable();
}

f32x8 filter_weight(const struct stage *s, f32x8 dx_px, f32x8 dy_px)
{
    const float zero = s->filter.zero_px, weight = s->filter.gain * s->filter.gain;
    const i32x8 x_negative = f32x8_abs(dx_px) > zero, y_negative = f32x8_abs(dy_px) > zero;
    return f32x8_choose(x_negative ^ y_negative, f32x8_splat(-weight), f32x8_splat(weight));
}
