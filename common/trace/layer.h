/* layer.h - what a sample adds to the layers of its pixel (common/layers.h).
 *
 * They are made beside the image from the same paths: asking for them draws no random number and
 * changes no bit of the image.
 * SPDX-License-Identifier: MIT */
#ifndef COMMON_TRACE_LAYER_H
#define COMMON_TRACE_LAYER_H

#include "common/layers.h"
#include "common/trace/wave.h"

/* The first surface's, of the start that sample has the number of, modulo 8. Albedo is estimated by
 * the first scattering that the path itself draws: its weight, without the change of radiance that
 * refraction makes. */
void layer_surface(const struct stage *, uint32_t layers, const struct wave_starts *,
                   const struct rng *, uint32_t sample, double channels[]);

/* The terms of path i, which ended with `radiance`. They are differences of floats and exact in
 * double, so that they add up to it. */
void layer_bounces(uint32_t layers, const struct wave_terms *, uint32_t i, rgb radiance,
                   double channels[]);

#endif
