/* ks.h - the Kolmogorov-Smirnov test: do values come from a distribution?
 * SPDX-License-Identifier: MIT */
#ifndef TESTS_STAT_KS_H
#define TESTS_STAT_KS_H

#include "common/base.h"

struct ks {
    double d; /* largest distance of the two distribution functions; 1 if any value is a NaN */
    double p; /* how probable one as large is */
};

/* u: the values' places in their supposed distribution, F(x), uniform on [0, 1] if it is true.
 * Sorts them. n >= 20. */
struct ks ks_test(double *u, size_t n);

/* The smallest distance of distribution functions that is detected at the level. */
double ks_detects(size_t n, double level);

#endif
