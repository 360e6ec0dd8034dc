/* SPDX-License-Identifier: MIT */
#include "common/curve.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>

#include "common/special.h"

static bool is_none(double x)
{
    return isnan(x);
}

/* --- errors of images --- */

static double least_of(const double *y, size_t pixels)
{
    double sum = 0;
    for (size_t i = 0; i < 3 * pixels; i++)
        sum += y[i];
    return 0.01 * sum / (3 * (double)pixels);
}

static double share(double square, double y, double least)
{
    return square == 0 ? 0 : square / (y * y + least * least);
}

static int ascending(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

double curve_relmse(const double *x, const double *y, size_t pixels, double *trimmed,
                    double *scratch)
{
    const double least = least_of(y, pixels);
    double sum = 0;
    for (size_t i = 0; i < pixels; i++) {
        scratch[i] = 0;
        for (size_t c = 3 * i; c < 3 * i + 3; c++)
            scratch[i] += share((x[c] - y[c]) * (x[c] - y[c]), y[c], least);
        sum += scratch[i];
    }
    qsort(scratch, pixels, sizeof *scratch, ascending);
    const size_t kept = pixels - pixels / 1000;
    double rest = 0;
    for (size_t i = 0; i < kept; i++)
        rest += scratch[i];
    *trimmed = rest / (3 * (double)kept);
    return sum / (3 * (double)pixels);
}

/* --- intervals --- */

static double student(uint32_t n)
{
    return special_student_limit(0.025, n - 1);
}

struct curve_value curve_mean(const double values[], uint32_t n)
{
    double mean = 0, square = 0;
    for (uint32_t i = 0; i < n; i++)
        mean += values[i] / n;
    for (uint32_t i = 0; i < n; i++)
        square += (values[i] - mean) * (values[i] - mean);
    const double half = student(n) * sqrt(square / (n - 1) / n);
    return (struct curve_value){mean, mean - half, mean + half};
}

struct curve_value curve_at(const struct curve *c, uint32_t point)
{
    const struct curve_value m = curve_mean(c->error[point], c->runs);
    if (!(m.at > 0))
        return m;
    const double factor = exp((m.high - m.at) / m.at);
    return (struct curve_value){m.at, m.at / factor, m.at * factor};
}

double curve_unequal_p(double off, double error, double dof, double margin)
{
    if (error == 0)
        return fabs(off) < margin ? 0 : 1;
    return special_student_tail((margin - fabs(off)) / error, dof);
}

/* --- of a whole curve --- */

struct means { /* over runs, in logarithms */
    uint32_t points;
    double work[CURVE_MOST_POINTS], error[CURVE_MOST_POINTS];
};

/* All runs but one; `without` UINT32_MAX: all. Points without error end a curve. */
static struct means means_of(const struct curve *c, uint32_t without)
{
    struct means m = {0};
    for (uint32_t p = 0; p < c->points; p++) {
        double sum = 0;
        for (uint32_t r = 0; r < c->runs; r++)
            sum += r == without ? 0 : c->error[p][r];
        if (!(sum > 0))
            break;
        m.work[p] = log(c->work[p]);
        m.error[p] = log(sum / (c->runs - (without < c->runs)));
        m.points++;
    }
    return m;
}

struct question { /* of one curve's means, or of two curves' */
    double (*ask)(const struct means *, const struct means *base, const struct question *);
    const struct curve *curve, *base; /* base: or NULL */
    uint32_t begin, end;
    double error;
};

/* The jackknife's variance of the answer, one curve's runs left out in turn; NAN when some run
 * decides whether there is an answer. */
static double variance(const struct question *q, bool of_base)
{
    const struct curve *c = of_base ? q->base : q->curve;
    struct means curve = means_of(q->curve, UINT32_MAX), base = {0};
    double answer[CURVE_MOST_RUNS], mean = 0, square = 0;
    if (q->base)
        base = means_of(q->base, UINT32_MAX);
    for (uint32_t r = 0; r < c->runs; r++) {
        *(of_base ? &base : &curve) = means_of(c, r);
        answer[r] = q->ask(&curve, &base, q);
        mean += answer[r] / c->runs;
    }
    for (uint32_t r = 0; r < c->runs; r++)
        square += (answer[r] - mean) * (answer[r] - mean);
    return square * (c->runs - 1) / c->runs;
}

static struct curve_value answer(const struct question *q)
{
    const struct means curve = means_of(q->curve, UINT32_MAX);
    struct means base = {0};
    if (q->base)
        base = means_of(q->base, UINT32_MAX);
    const double at = q->ask(&curve, &base, q);
    if (is_none(at))
        return curve_none();
    const double a = variance(q, false), b = q->base ? variance(q, true) : 0;
    double dof = q->curve->runs - 1; /* Welch's, of two */
    if (b > 0)
        dof = (a + b) * (a + b) / (a * a / dof + b * b / (q->base->runs - 1));
    const double half = special_student_limit(0.025, dof) * sqrt(a + b);
    return (struct curve_value){at, at - half, at + half};
}

static struct curve_value exp_of(struct curve_value v)
{
    return (struct curve_value){exp(v.at), exp(v.low), exp(v.high)};
}

static double slope_of(const struct means *m, const struct means *base, const struct question *q)
{
    (void)base;
    const uint32_t end = q->end < m->points ? q->end : m->points;
    if (end < q->begin + 2)
        return (double)NAN;
    const double n = end - q->begin;
    double x = 0, y = 0, xx = 0, xy = 0;
    for (uint32_t p = q->begin; p < end; p++) {
        x += m->work[p] / n;
        y += m->error[p] / n;
    }
    for (uint32_t p = q->begin; p < end; p++) {
        xx += (m->work[p] - x) * (m->work[p] - x);
        xy += (m->work[p] - x) * (m->error[p] - y);
    }
    return xy / xx;
}

struct curve_value curve_slope(const struct curve *c, uint32_t begin, uint32_t end)
{
    const struct question q = {slope_of, c, NULL, begin, end, 0};
    return answer(&q);
}

static double work_of(const struct means *m, const struct means *base, const struct question *q)
{
    (void)base;
    for (uint32_t p = 1; p < m->points; p++)
        if (m->error[p - 1] >= q->error && m->error[p] <= q->error) {
            const double fall = m->error[p - 1] - m->error[p];
            const double part = fall > 0 ? (m->error[p - 1] - q->error) / fall : 0;
            return m->work[p - 1] + part * (m->work[p] - m->work[p - 1]);
        }
    return (double)NAN;
}

struct curve_value curve_work_to(const struct curve *c, double error)
{
    const struct question q = {work_of, c, NULL, 0, 0, log(error)};
    return exp_of(answer(&q));
}

static double error_at(const struct means *m, double work)
{
    uint32_t p = 1;
    while (p + 1 < m->points && m->work[p] < work)
        p++;
    const double part = (work - m->work[p - 1]) / (m->work[p] - m->work[p - 1]);
    return m->error[p - 1] + part * (m->error[p] - m->error[p - 1]);
}

/* The mean distance of two curves over their common range, at as many places as one has points. */
static double gain_of(const struct means *m, const struct means *base, const struct question *q)
{
    (void)q;
    if (m->points < 2 || base->points < 2)
        return (double)NAN;
    const double begin = fmax(m->work[0], base->work[0]);
    const double end = fmin(m->work[m->points - 1], base->work[base->points - 1]);
    if (!(begin < end))
        return (double)NAN;
    double sum = 0;
    const uint32_t steps = m->points;
    for (uint32_t i = 0; i < steps; i++) {
        const double work = begin + (end - begin) * i / (steps - 1);
        sum += error_at(base, work) - error_at(m, work);
    }
    return sum / steps;
}

struct curve_value curve_gain(const struct curve *c, const struct curve *base)
{
    const struct question q = {gain_of, c, base, 0, 0, 0};
    return exp_of(answer(&q));
}

/* --- bias --- */

static double bias2_without(double *const images[], uint32_t runs, uint32_t without,
                            const double *y, size_t pixels)
{
    const double least = least_of(y, pixels), n = runs - (without < runs);
    double sum = 0;
    for (size_t i = 0; i < 3 * pixels; i++) {
        double mean = 0, square = 0;
        for (uint32_t r = 0; r < runs; r++)
            mean += r == without ? 0 : images[r][i] / n;
        for (uint32_t r = 0; r < runs; r++)
            square += r == without ? 0 : (images[r][i] - mean) * (images[r][i] - mean);
        const double off = (mean - y[i]) * (mean - y[i]) - square / (n - 1) / n;
        sum += share(off, y[i], least);
    }
    return sum / (3 * (double)pixels);
}

struct curve_value curve_bias2(double *const images[], uint32_t runs, const double *y,
                               size_t pixels)
{
    double left[CURVE_MOST_RUNS], mean = 0, square = 0;
    assert(runs > 2 && runs <= CURVE_MOST_RUNS);
    const double at = bias2_without(images, runs, UINT32_MAX, y, pixels);
    for (uint32_t r = 0; r < runs; r++) {
        left[r] = bias2_without(images, runs, r, y, pixels);
        mean += left[r] / runs;
    }
    for (uint32_t r = 0; r < runs; r++)
        square += (left[r] - mean) * (left[r] - mean);
    const double half = student(runs) * sqrt(square * (runs - 1) / runs);
    return (struct curve_value){at, at - half, at + half};
}
