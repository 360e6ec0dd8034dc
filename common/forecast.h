/* forecast.h - how many samples until the error is what was asked for.
 *
 * Errors fall as a power of the work: ln e = a - b ln N. Before anything is known b is 1/2, the law
 * of independent samples, give or take 0.1, and a is anything; every point of the job's curve is
 * evidence about both, each error estimate being good to some 5 %. What then is known is a line
 * with a normal error (Bayesian linear regression), and where it meets the target, give or take 2
 * standard deviations, is the forecast. Points should be recent ones: a curve may bend. A job stops
 * at the first of its fixed places that lies beyond.
 * Pure functions. SPDX-License-Identifier: MIT */
#ifndef COMMON_FORECAST_H
#define COMMON_FORECAST_H

#include "common/base.h"

struct forecast_point {
    double samples; /* > 0, ascending */
    double error;   /* > 0 */
};

struct forecast {
    double slope;              /* -b */
    double samples, low, high; /* in all, when the error is there; low <= samples <= high */
};

/* Of count >= 1 points; target > 0. An error that is reached gives its samples thrice. */
struct forecast forecast_make(const struct forecast_point *, size_t count, double target);

#endif
