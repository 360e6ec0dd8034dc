/* noise.h - smooth random heights in space, for meshes with detail at every scale.
 * SPDX-License-Identifier: MIT */
#ifndef BENCH_NOISE_H
#define BENCH_NOISE_H

#include "common/base.h"

/* Fractional Brownian motion: octaves of value noise (random numbers at the points of a lattice,
 * smoothly interpolated), each of twice the frequency and half the height of the one before.
 * The sum lies in (-2, 2), most of it in (-1, 1). |p| < 2^20. */
double noise_fbm(const double p[3], int octaves);

#endif
