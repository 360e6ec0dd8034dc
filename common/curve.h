/* curve.h - error against work: what some independent runs at several amounts of work say, with 95
 * % intervals.
 *
 * The error of a run is its relMSE against a reference (docs/accuracy.md). It is a mean over many
 * pixels, so its mean over runs has a t interval; that is taken in the logarithm (mean times and
 * over exp(t s / mean)), as errors are drawn and multiplied. What is derived from a whole curve
 * (slope, work to an error, gain) gets its interval by the jackknife over runs: each run is left
 * out at all amounts of work at once, the runs of two curves independently. (B. Efron, C. Stein,
 * "The Jackknife Estimate of Variance", Annals of Statistics 9(3), 1981.)
 *
 * Between points a curve is straight in log-log; there is no extrapolation.
 * Pure functions. SPDX-License-Identifier: MIT */
#ifndef COMMON_CURVE_H
#define COMMON_CURVE_H

#include "common/base.h"

enum { CURVE_MOST_POINTS = 24, CURVE_MOST_RUNS = 64 };

struct curve {
    uint32_t points, runs;                            /* runs: at least 2 */
    double work[CURVE_MOST_POINTS];                   /* of a run, on the average; ascending */
    double error[CURVE_MOST_POINTS][CURVE_MOST_RUNS]; /* relMSE, at least 0 */
};

struct curve_value {
    double at, low, high; /* low and high end the 95 % interval; all NAN: there is none */
};

static inline struct curve_value curve_none(void)
{
    const double nan = (double)__builtin_nanf("");
    return (struct curve_value){nan, nan, nan};
}

/* x the image, y the reference, pixels of three channels, e = 0.01 mean(y): the mean of (x - y)^2 /
 * (y^2 + e^2). trimmed: the same without the one in a thousand pixels that are furthest off. A
 * black reference: 0 for a black image, else infinite. scratch: room for `pixels`. */
double curve_relmse(const double *x, const double *y, size_t pixels, double *trimmed,
                    double *scratch);

/* The mean of runs at a point. */
struct curve_value curve_at(const struct curve *, uint32_t point);
/* d log error / d log work, straight through points [begin, end) of positive error: at least 2. */
struct curve_value curve_slope(const struct curve *, uint32_t begin, uint32_t end);
/* The work at which the error is first met. None: it is before the first point or after the last
 * one. */
struct curve_value curve_work_to(const struct curve *, double error);
/* How many times as large the base's error is at the same work, geometric mean over the range that
 * both have: 1 / (variance x work) over the base's, where slopes are -1. */
struct curve_value curve_gain(const struct curve *, const struct curve *base);

/* The part of a relMSE that does not go with more runs: that of the runs' mean, less what its own
 * noise makes of it. images: [run], each as x above. May come out below 0. */
struct curve_value curve_bias2(double *const images[], uint32_t runs, const double *y,
                               size_t pixels);

/* The mean of n values, with its t interval. */
struct curve_value curve_mean(const double values[], uint32_t n);

/* Two means are equal: how probable it is to see a difference as small as `off` when in truth it is
 * the margin or more, error being off's standard error (two one-sided tests). */
double curve_unequal_p(double off, double error, double dof, double margin);

#endif
