/* stat.h - the statistics that tests decide by.
 *
 * Seeds are fixed, so a test that passes passes for ever; the levels say how probable it was that a
 * right program fails with some seed. Tests of one suite share a level of 0.01 by Sidak's
 * correction. A test says the smallest bias it detects beside what it found (docs/accuracy.md).
 *
 * This file has what all need. Beside it: means.h (t, z, equivalence), chi2.h (counts),
 * sphere_chi2.h (directions against their pdf), ks.h (values against a distribution), zmap.h (an
 * image against truth), scatter.h (the laws of a BSDF), special.h (the distributions).
 * SPDX-License-Identifier: MIT */
#ifndef TESTS_STAT_STAT_H
#define TESTS_STAT_STAT_H

#include "common/base.h"

/* Builds that are slowed by checkers or by -O0 take a fraction of the samples and judge by their
 * own, wider standard errors. */
#ifdef SMALTI_SLOW_CHECKS
enum { STAT_SLOW = 32 };
#else
enum { STAT_SLOW = 1 };
#endif

/* How many of something a test tries: the quick number, or with TEST_LONG=1 in the environment
 * (make check-long) the whole one; of either the fraction that STAT_SLOW leaves. Tests say it. */
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

/* "The smallest bias a test detects" is the one that it finds with this probability. */
#define STAT_POWER 0.99
/* The shift, from 0 on, at which a power that grows with it reaches STAT_POWER. */
double stat_detected(double (*power)(const void *what, double shift), const void *what);

#endif
