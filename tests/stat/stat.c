/* SPDX-License-Identifier: MIT */
#include "tests/stat/stat.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "common/special.h"

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
    return special_normal_limit(0.5 * alpha);
}

double stat_detected(double (*power)(const void *what, double shift), const void *what)
{
    double lo = 0, hi = 1;
    while (power(what, hi) < STAT_POWER) {
        lo = hi;
        hi *= 2;
    }
    for (int i = 0; i < 24; i++) {
        const double shift = 0.5 * (lo + hi);
        if (power(what, shift) < STAT_POWER)
            lo = shift;
        else
            hi = shift;
    }
    return hi;
}
