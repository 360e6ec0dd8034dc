/* SPDX-License-Identifier: MIT */
#include "tests/stat/means.h"

#include <math.h>

#include "common/special.h"

struct means means_from_truth(const struct stat_mean *m, double truth)
{
    return (struct means){m->mean - truth, stat_error(m), m->n - 1};
}

/* B. Welch, "The Generalization of Student's Problem when Several Different Population Variances
 * are Involved", Biometrika 34, 1947. */
struct means means_between(const struct stat_mean *a, const struct stat_mean *b)
{
    const double va = stat_variance(a) / a->n, vb = stat_variance(b) / b->n;
    const double both = va + vb;
    return (struct means){
        .off = a->mean - b->mean,
        .error = sqrt(both),
        .dof = both > 0 ? both * both / (va * va / (a->n - 1) + vb * vb / (b->n - 1))
                        : (double)INFINITY,
    };
}

static double in_errors(double x, double error)
{
    return x == 0 ? 0 : x / error;
}

double means_t(const struct means *m)
{
    return in_errors(m->off, m->error);
}

double means_p(const struct means *m)
{
    const double t = fabs(means_t(m));
    return isfinite(t) ? fmin(1, 2 * special_student_tail(t, m->dof)) : 0;
}

struct limit {
    double t, dof;
};

static double power(const void *what, double shift)
{
    const struct limit *limit = what;
    return special_student_shifted_tail(limit->t, limit->dof, shift);
}

double means_detects(const struct means *m, double level)
{
    const struct limit limit = {special_student_limit(0.5 * level, m->dof), m->dof};
    return stat_detected(power, &limit) * m->error;
}

/* The greater of the two one-sided tests: "it is above -margin", "it is below margin". */
double means_unequal_p(const struct means *m, double margin)
{
    const double t = in_errors(margin - fabs(m->off), m->error);
    return isnan(t) ? 1 : (isinf(t) ? t < 0 : special_student_tail(t, m->dof));
}

/* Both |t| < c and c = margin / error - limit: the central t stays inside with STAT_POWER. */
double means_provable(const struct means *m, double level)
{
    return m->error * (special_student_limit(level, m->dof) +
                       special_student_limit(0.5 * (1 - STAT_POWER), m->dof));
}
