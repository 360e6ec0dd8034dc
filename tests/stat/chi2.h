/* chi2.h - Pearson's test: do counts follow their expectation?
 * SPDX-License-Identifier: MIT */
#ifndef TESTS_STAT_CHI2_H
#define TESTS_STAT_CHI2_H

#include "common/base.h"

struct chi2 {
    double p;   /* how probable counts as far off are. 0 when anything was seen where nothing can be
                 * (more than 1e-5 of all in cells with an expectation of less than 1e-9) */
    double dof; /* pools less one; less than 1: too few counts to judge, p is 0 */
};

/* Neighbours in order of expectation are pooled until at least 5 are expected. The expectations
 * should sum to the counts; what they lack stays unseen here and is judged apart (sphere_chi2.h).
 */
struct chi2 chi2_test(const double *expected, const uint32_t *observed, size_t cells);

/* The smallest bias that is detected at the level: the root mean square, under the expected
 * distribution, of the pools' relative error. */
double chi2_detects(const struct chi2 *, double counts, double level);

#endif
