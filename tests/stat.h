/* stat.h - the statistics that tests decide by.
 *
 * Seeds are fixed, so a test that passes passes for ever; the levels say how probable it was that a
 * right program fails with some seed. Tests of one suite share a level of 0.01 by Sidak's
 * correction.
 * SPDX-License-Identifier: MIT */
#ifndef TESTS_STAT_H
#define TESTS_STAT_H

#include "common/base.h"

/* Builds that are slowed by checkers or by -O0 take a fraction of the samples and judge by their
 * own, wider standard errors. */
#ifdef SMALTI_SLOW_CHECKS
enum { STAT_SLOW = 32 };
#else
enum { STAT_SLOW = 1 };
#endif

/* How many of something a test tries: the quick number, or with TEST_LONG=1 in the environment (make
 * check-long) the whole one; of either the fraction that STAT_SLOW leaves. Tests say it. */
uint32_t stat_tries(uint32_t quick, uint32_t whole);
bool stat_is_long(void);

struct stat_mean {          /* zero-initialised: no values yet */
    double n, mean, square; /* square: sum of squared differences from the mean */
};

void stat_add(struct stat_mean *, double x); /* Welford's update */
double stat_variance(const struct stat_mean *);
double stat_error(const struct stat_mean *); /* standard error of the mean */

/* Level of each of n tests so that all together have level alpha. */
double stat_sidak(double alpha, double n);
/* |z| of a standard normal variable exceeds it with probability alpha. */
double stat_z_limit(double alpha);
/* Probability that chi-square with dof degrees of freedom exceeds x. */
double stat_chi2_tail(double x, double dof);

/* Pearson's test of counts against expected counts; neighbours in order of expectation are pooled
 * until at least 5 are expected. The p value; 0 when anything was seen where nothing can
 * be (more than 1e-5 of all in cells with an expectation of less than 1e-9). */
double stat_chi2_test(const double *expected, const uint32_t *observed, size_t cells);

#endif
