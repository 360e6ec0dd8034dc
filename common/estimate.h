/* estimate.h - film -> standard errors.
 *
 * With replicate means m_r of n_r samples (r = 0 .. 7, n_r > 0), the standard error of a
 * pixel's mean is s = sd(m_r) / sqrt(8), sd with 7 degrees of freedom; the 95 % interval is
 * mean +- 2.365 s (Student t, 7 degrees of freedom). Before every replicate has a
 * sample (spp < 8) the error is unknown: +infinity.
 *
 * The job's error is the root of the expected relMSE over pixels and channels,
 *
 *     error = sqrt( mean over px, ch of s^2 / (y^2 + e^2) ),  e = 0.01 mean(y),
 *
 * y the pixel's mean: the same form as the relMSE of `smalti diff`, so an error of 0.02
 * reads "the image is 2 % RMS away from its limit". Sums run in pixel order in double, so the
 * number is the same on every machine.
 *
 * How well the error itself is known. By chance: the sum U of s^2 / (y^2 + e^2) is computed from
 * all replicates and from each seven of them (the jackknife; y and e stay those of all samples).
 * With U_r without replicate r, 8 U - 7 U_r are eight values whose spread is that of U, and U
 * +- 2.365 times their standard error, 7 degrees of freedom, is where its mean lies. But that mean
 * is not the error's square:
 * - What few samples bring makes s and y large together, and both are small where it has not come
 *   yet: U is too small. With s of two replicates next to each other and y of the six others, in
 *   all eight ways, the two are independent, and since 1 / y^2 is convex the sum is too large. A
 *   pixel's square is at least the variance of what it adds, so that the root of the sum of those
 *   squares, twice, covers its chance. The interval ends there, or at U's end if that is farther.
 * - What is noisy in itself makes U too large, by 3 s^2 / y^2 to the second order. So the interval
 *   begins with the sum of s^2 / (y^2 + 3 s^2 + e^2), less what U may be off by chance.
 * It is far wider than chance alone where light is rare: that is what is not known. What no sample
 * has shown yet it cannot know: evidence.h says where that may be much; tests/test_coverage.c holds
 * it against true errors. Of a part of the image U is the same sum over that part (adaptive.h), and
 * its end that by chance alone. Pure functions.
 * SPDX-License-Identifier: MIT */
#ifndef COMMON_ESTIMATE_H
#define COMMON_ESTIMATE_H

#include "common/film.h"

void estimate_pixel(const struct film *, size_t pixel, double standard_error[3]);
struct estimate_interval {
    double low, high;
};

/* e: what keeps dark pixels from counting without bound. */
double estimate_least(const struct film *);

struct estimate_part { /* mean over px, ch of s^2 / (y^2 + e^2), and its upper end, by chance */
    double error2, high;
};

/* Of the rectangle, inside the film's window; both +infinity while a pixel's error is unknown. */
struct estimate_part estimate_part(const struct film *, struct tile_rect, double least);

/* 95 %, of the job's true error; [0, +infinity] while estimate_error is unknown. */
struct estimate_interval estimate_interval(const struct film *);

double estimate_error(const struct film *); /* +infinity while any pixel's is unknown;
                                             * 0 for an image that is black everywhere */

#endif
