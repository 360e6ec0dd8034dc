/* filter.h - pixel filters, by sampling them.
 *
 * A sample belongs to the pixel it was made for and no other: the filter's absolute value is the
 * density of its offset from the pixel's centre (M. Ernst, M. Stamminger, G. Greiner, "Filter
 * Importance Sampling", IEEE RT 2006). Hence tiles need no borders and never overlap. All filters
 * are products of an even function of x and the same of y, and the way from a random number to an
 * offset rises: points that are spread evenly stay so.
 *
 * Box and tent are inverted in closed form, the others by a table of FILTER_PIECES straight pieces
 * (prep_filter.c): what is sampled is off the function by some 1e-5 of it.
 *
 * A filter with negative lobes gives its samples weights: +gain^2 or -gain^2, by the signs of its
 * two factors, where gain is the mass of the absolute value over that of the filter. Their mean is
 * 1. A radiance is judged before it is weighed: what is negative there is an error, and a sum that
 * is negative need not be.
 * SPDX-License-Identifier: MIT */
#ifndef COMMON_TRACE_FILTER_H
#define COMMON_TRACE_FILTER_H

#include "common/trace/simd.h"
#include "common/trace/stage.h"

enum { FILTER_PIECES = 512 };

/* Offsets from the pixel's centre along an axis, in pixels. */
f32x8 filter_offset(const struct stage *, f32x8 u);

static inline bool filter_is_signed(const struct stage *s)
{
    return s->filter.gain != 1;
}

/* What samples at these offsets weigh, when the filter is signed; at most 16/9 either way. */
f32x8 filter_weight(const struct stage *, f32x8 dx_px, f32x8 dy_px);

#endif
