/* against.h - how far an image really is from its limit: held against a reference that was made
 * with other random numbers, less what the reference's own noise makes of it (its standard errors,
 * common/estimate.h). So the reference needs no more samples than the image. Pure.
 * SPDX-License-Identifier: MIT */
#ifndef BENCH_AGAINST_H
#define BENCH_AGAINST_H

#include "common/film.h"

/* Mean over the rectangle's px, ch of ((x - y)^2 - s^2) / (y^2 + e^2), y and s of the reference, e
 * of the reference's estimate_least. May come out below 0. */
double against_error2(const struct film *, const struct film *reference, struct tile_rect,
                      double least);

/* Mean of x over mean of y, over all pixels and channels, less 1. */
double against_energy(const struct film *, const struct film *reference);

#endif
