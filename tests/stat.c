/* SPDX-License-Identifier: MIT */
#include "tests/stat.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "common/arena.h"

bool stat_is_long(void)
{
    const char *set = getenv("TEST_LONG");
    return set && *set && strcmp(set, "0") != 0;
}

uint32_t stat_tries(uint32_t quick, uint32_t whole)
{
    return (stat_is_long() ? whole : quick) / STAT_SLOW;
}

void stat_add(struct stat_mean *s, double x)
{
    s->n += 1;
    const double off = x - s->mean;
    s->mean += off / s->n;
    s->square += off * (x - s->mean);
}

double stat_variance(const struct stat_mean *s)
{
    return s->square / (s->n - 1);
}

double stat_error(const struct stat_mean *s)
{
    return sqrt(stat_variance(s) / s->n);
}

double stat_sidak(double alpha, double n)
{
    return -expm1(log1p(-alpha) / n);
}

double stat_z_limit(double alpha)
{
    double lo = 0, hi = 40;
    for (int i = 0; i < 200; i++) {
        const double z = 0.5 * (lo + hi);
        if (erfc(z / sqrt(2)) > alpha)
            lo = z;
        else
            hi = z;
    }
    return hi;
}

/* The regularised incomplete gamma function Q(a, x): its series below a + 1, its continued fraction
 * (Lentz) above. NIST Digital Library of Mathematical Functions, 8.11.4 and 8.9.2. */
static double gamma_tail(double a, double x)
{
    const double front = exp(a * log(x) - x - lgamma(a));
    if (x < a + 1) {
        double term = 1 / a, sum = term;
        for (double n = a + 1; term > 1e-17 * sum; n++)
            sum += term *= x / n;
        return 1 - front * sum;
    }
    double b = x + 1 - a, c = 1e300, d = 1 / b, h = d;
    for (int i = 1; i < 100000; i++) {
        const double an = -i * (i - a);
        b += 2;
        d = 1 / (an * d + b);
        c = b + an / c;
        h *= c * d;
        if (fabs(c * d - 1) < 1e-15)
            break;
    }
    return front * h;
}

double stat_chi2_tail(double x, double dof)
{
    return x <= 0 ? 1 : gamma_tail(0.5 * dof, 0.5 * x);
}

struct cell {
    double expected, observed;
};

static int cell_order(const void *a, const void *b)
{
    const double d = ((const struct cell *)a)->expected - ((const struct cell *)b)->expected;
    return (d > 0) - (d < 0);
}

double stat_chi2_test(const double *expected, const uint32_t *observed, size_t cells)
{
    struct arena arena = {0};
    struct cell *c = arena_new(&arena, struct cell, cells);
    double all = 0, impossible = 0;
    for (size_t i = 0; i < cells; i++) {
        c[i] = (struct cell){expected[i], observed[i]};
        all += observed[i];
        impossible += expected[i] < 1e-9 ? observed[i] : 0;
    }
    qsort(c, cells, sizeof *c, cell_order);
    struct cell pool = {0, 0};
    double x = 0, pools = 0, left = 0;
    for (size_t i = 0; i < cells; i++)
        left += c[i].expected;
    for (size_t i = 0; i < cells; i++) {
        pool.expected += c[i].expected;
        pool.observed += c[i].observed;
        left -= c[i].expected;
        if (pool.expected < 5 || (left < 5 && i + 1 < cells))
            continue;
        x += (pool.observed - pool.expected) * (pool.observed - pool.expected) / pool.expected;
        pools++;
        pool = (struct cell){0, 0};
    }
    arena_release(&arena);
    if (impossible > 1e-5 * all || pools < 2)
        return 0;
    return stat_chi2_tail(x, pools - 1);
}
