/* SPDX-License-Identifier: MIT */
#include "tests/stat/chi2.h"

#include <math.h>
#include <stdlib.h>

#include "common/arena.h"
#include "common/special.h"
#include "tests/stat/stat.h"

struct cell {
    double expected, observed;
};

static int cell_order(const void *a, const void *b)
{
    const double d = ((const struct cell *)a)->expected - ((const struct cell *)b)->expected;
    return (d > 0) - (d < 0);
}

/* Pearson's statistic over pools of sorted cells. A pool is closed only if what is left
 * can fill another. */
static double pooled(const struct cell *c, size_t cells, double *pools)
{
    struct cell pool = {0, 0};
    double x = 0, left = 0;
    for (size_t i = 0; i < cells; i++)
        left += c[i].expected;
    for (size_t i = 0; i < cells; i++) {
        pool.expected += c[i].expected;
        pool.observed += c[i].observed;
        left -= c[i].expected;
        if (pool.expected < 5 || (left < 5 && i + 1 < cells))
            continue;
        x += (pool.observed - pool.expected) * (pool.observed - pool.expected) / pool.expected;
        *pools += 1;
        pool = (struct cell){0, 0};
    }
    return x;
}

struct chi2 chi2_test(const double *expected, const uint32_t *observed, size_t cells)
{
    struct arena arena = {0};
    struct cell *c = arena_new(&arena, struct cell, cells);
    double all = 0, impossible = 0, pools = 0;
    for (size_t i = 0; i < cells; i++) {
        c[i] = (struct cell){expected[i], observed[i]};
        all += observed[i];
        impossible += expected[i] < 1e-9 ? observed[i] : 0;
    }
    qsort(c, cells, sizeof *c, cell_order);
    const double x = pooled(c, cells, &pools);
    arena_release(&arena);
    struct chi2 r = {0, pools - 1};
    if (!(impossible > 1e-5 * all) && r.dof >= 1)
        r.p = special_chi2_tail(x, r.dof);
    return r;
}

struct limit {
    double x, dof;
};

static double power(const void *what, double shift)
{
    const struct limit *limit = what;
    return special_chi2_shifted_tail(limit->x, limit->dof, shift);
}

double chi2_detects(const struct chi2 *r, double counts, double level)
{
    if (r->dof < 1)
        return (double)INFINITY;
    const struct limit limit = {special_chi2_limit(level, r->dof), r->dof};
    return sqrt(stat_detected(power, &limit) / counts);
}
