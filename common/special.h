/* special.h - the distributions that statistics need, in double.
 *
 * Every distribution is given by its upper tail, "the probability to exceed x", which keeps its
 * digits where decisions are made, and by its limit, "what is exceeded with that probability". A
 * dof of INFINITY makes Student's t normal. SPDX-License-Identifier: MIT */
#ifndef COMMON_SPECIAL_H
#define COMMON_SPECIAL_H

#include "common/base.h"

/* Regularised incomplete gamma function Q(a, x) and beta function I_x(a, b); a, b > 0. */
double special_gamma_q(double a, double x);
double special_beta_i(double x, double a, double b);

double special_normal_tail(double z);
double special_normal_limit(double tail);

double special_student_tail(double t, double dof);
double special_student_limit(double tail, double dof);
/* Of (Z + shift) / sqrt(chi2 / dof): what a t test sees when the mean is off by `shift` standard
 * errors. To about 1e-9. */
double special_student_shifted_tail(double t, double dof, double shift);

double special_chi2_tail(double x, double dof);
double special_chi2_limit(double tail, double dof);
/* Of the noncentral distribution: what a chi-square test sees when the counts are off by `shift` =
 * sum of (expected - true)^2 / expected. */
double special_chi2_shifted_tail(double x, double dof, double shift);

/* Of Kolmogorov's statistic sup |F_n - F| of n >= 20 values: to 1e-6 where the tail is below 0.05,
 * to 1e-3 elsewhere. */
double special_kolmogorov_tail(double d, size_t n);
double special_kolmogorov_limit(double tail, size_t n);

#endif
