/* SPDX-License-Identifier: MIT */
#include "tests/stat/ks.h"

#include <math.h>
#include <stdlib.h>

#include "common/special.h"
#include "tests/stat/stat.h"

static int order(const void *a, const void *b)
{
    const double d = *(const double *)a - *(const double *)b;
    return (d > 0) - (d < 0);
}

struct ks ks_test(double *u, size_t n)
{
    for (size_t i = 0; i < n; i++)
        if (!(u[i] >= 0 && u[i] <= 1))
            return (struct ks){1, 0};
    qsort(u, n, sizeof *u, order);
    double d = 0;
    for (size_t i = 0; i < n; i++)
        d = fmax(d, fmax((double)(i + 1) / (double)n - u[i], u[i] - (double)i / (double)n));
    return (struct ks){d, special_kolmogorov_tail(d, n)};
}

/* Where the functions are farthest apart the share of values below is binomial, with a standard
 * deviation of 1 / (2 sqrt n) at most: so much beyond the limit suffices. */
double ks_detects(size_t n, double level)
{
    return special_kolmogorov_limit(level, n) +
           special_normal_limit(1 - STAT_POWER) * 0.5 / sqrt((double)n);
}
