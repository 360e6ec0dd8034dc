/* means.h - is a mean what it should be? The t and z tests, and the proof of equality.
 *
 * "No difference found" is no proof that there is none. Two estimators are shown to be equal by
 * means_unequal_p: small, when the difference is surely inside a stated margin (two one-sided
 * tests, TOST). SPDX-License-Identifier: MIT */
#ifndef TESTS_STAT_MEANS_H
#define TESTS_STAT_MEANS_H

#include "tests/stat/stat.h"

struct means {
    double off;   /* the difference */
    double error; /* its standard error */
    double dof; /* degrees of freedom of that; INFINITY: the error is known, the test is a z test */
};

struct means means_from_truth(const struct stat_mean *, double truth);
struct means means_between(const struct stat_mean *, const struct stat_mean *); /* Welch's */

/* In standard errors. 0 for nothing off by nothing; infinite for something off by an error of 0. */
double means_t(const struct means *);
double means_p(const struct means *); /* two-sided: how probable it is to be off as far */
/* The smallest bias that means_p < level detects. */
double means_detects(const struct means *, double level);

/* How probable a difference found so small is, or smaller, when in truth it is the margin or more.
 * Below a level it proves equality, and a bias of the margin passes with no more than that chance.
 */
double means_unequal_p(const struct means *, double margin);
/* The smallest margin in which this standard error lets equality be proven, with STAT_POWER, when
 * it holds. */
double means_provable(const struct means *, double level);

#endif
