/* curve.c on estimators that are known: their variance, what a sample costs, their bias (ACCURACY
 * 6). The lines are true, and the intervals hold the truth as often as they say.
 * SPDX-License-Identifier: MIT */
#include "common/curve.h"

#include <math.h>
#include <stdio.h>

#include "tests/dice.h"
#include "tests/stat/stat.h"
#include "tests/tap.h"

enum { PIXELS = 32, POINTS = 5, RUNS = 10 };

struct estimator {
    const char *name;
    double spread; /* standard deviation of a sample, in parts of the pixel's value */
    double bias;   /* likewise */
    double cost;   /* of a sample */
    double power;  /* variance of n samples: spread^2 n^-power */
};

static double samples_at(uint32_t point)
{
    return 4 << 2 * point;
}

/* Pixels of different values; the error of a mean is exponential's, as a long tail has it: of n
 * samples a gamma variable, here by the cube of a normal one (E. Wilson, M. Hilferty, PNAS 17,
 * 1931). */
static double draw(const struct estimator *e, double value, double n, struct dice *d)
{
    const double z = dice_normal(d), k = 1 / (9 * n);
    const double root = 1 - k + z * sqrt(k), gamma = root * root * root;
    const double scale = e->spread * pow(n, 0.5 - 0.5 * e->power);
    return value * (1 + e->bias + scale * (gamma - 1));
}

static void make_truth(double y[3 * PIXELS])
{
    for (size_t i = 0; i < 3 * PIXELS; i++)
        y[i] = 0.2 + (double)(i * 37 % 101) / 50;
}

/* What relMSE comes to: value^2 / (value^2 + e^2) of it. */
static double truth_of(const struct estimator *e, uint32_t point)
{
    double y[3 * PIXELS], mean = 0, sum = 0;
    make_truth(y);
    for (size_t i = 0; i < 3 * PIXELS; i++)
        mean += y[i] / (3 * PIXELS);
    for (size_t i = 0; i < 3 * PIXELS; i++)
        sum += y[i] * y[i] / (y[i] * y[i] + 1e-4 * mean * mean) / (3 * PIXELS);
    const double n = samples_at(point);
    return sum * (e->spread * e->spread * pow(n, -e->power) + e->bias * e->bias);
}

static void make_curve(const struct estimator *e, struct curve *c, struct dice *d)
{
    double y[3 * PIXELS], x[3 * PIXELS], scratch[PIXELS], trimmed;
    make_truth(y);
    c->points = POINTS;
    c->runs = RUNS;
    for (uint32_t p = 0; p < POINTS; p++) {
        c->work[p] = samples_at(p) * e->cost;
        for (uint32_t r = 0; r < RUNS; r++) {
            for (size_t i = 0; i < 3 * PIXELS; i++)
                x[i] = draw(e, y[i], samples_at(p), d);
            c->error[p][r] = curve_relmse(x, y, PIXELS, &trimmed, scratch);
        }
    }
}

struct count { /* of trials */
    double mean;
    int held, all;
};

static void add(struct count *n, struct curve_value v, double truth)
{
    if (isnan(v.at))
        return;
    n->mean += v.at;
    n->held += v.low <= truth && truth <= v.high;
    n->all++;
}

static void judge(const struct count *n, double truth, const char *what, const char *name)
{
    const double share = (double)n->held / n->all, mean = n->mean / n->all;
    ok(fabs(mean - truth) <= 0.03 * fabs(truth) && share >= 0.93 && share <= 0.97,
       "%s, %s: %.4g, in truth %.4g; bands hold it in %.1f %% of %d trials", name, what, mean,
       truth, 100 * share, n->all);
}

static const struct estimator base = {"base", 1, 0, 1, 1};

static void lines_are_true(const struct estimator *e)
{
    const int trials = (int)max_u32(stat_tries(1000, 4000), 1000);
    struct count at[POINTS] = {{0, 0, 0}}, slope = {0, 0, 0}, work = slope, gain = slope;
    struct dice d = dice_make((uint32_t)(1000 * e->spread + e->cost));
    const double target = truth_of(e, 2) * 1.3;
    static struct curve c, b;
    for (int i = 0; i < trials; i++) {
        make_curve(e, &c, &d);
        make_curve(&base, &b, &d);
        for (uint32_t p = 0; p < POINTS; p++)
            add(&at[p], curve_at(&c, p), truth_of(e, p));
        add(&slope, curve_slope(&c, 0, POINTS), -e->power);
        add(&work, curve_work_to(&c, target), 64 * e->cost * pow(1.3, -1 / e->power));
        add(&gain, curve_gain(&c, &b), 1 / (e->spread * e->spread * e->cost));
    }
    for (uint32_t p = 0; p < POINTS; p++) {
        char what[32];
        snprintf(what, sizeof what, "error after %.0f samples", samples_at(p));
        judge(&at[p], truth_of(e, p), what, e->name);
    }
    if (e->bias != 0)
        return;
    judge(&slope, -e->power, "slope", e->name);
    judge(&work, 64 * e->cost * pow(1.3, -1 / e->power), "work to an error", e->name);
    if (e->power == 1)
        judge(&gain, 1 / (e->spread * e->spread * e->cost), "gain over the base", e->name);
}

static void bias_is_told(double bias)
{
    const struct estimator e = {"biased", 1, bias, 1, 1};
    const int trials = (int)max_u32(stat_tries(1000, 4000), 1000);
    struct dice d = dice_make(7);
    static double image[RUNS][3 * PIXELS];
    double y[3 * PIXELS], *images[RUNS];
    const double truth = truth_of(&e, 2) - truth_of(&(struct estimator){"", 1, 0, 1, 1}, 2);
    struct count n = {0, 0, 0};
    make_truth(y);
    for (int t = 0; t < trials; t++) {
        for (uint32_t r = 0; r < RUNS; r++) {
            images[r] = image[r];
            for (size_t i = 0; i < 3 * PIXELS; i++)
                image[r][i] = draw(&e, y[i], samples_at(2), &d);
        }
        add(&n, curve_bias2(images, RUNS, y, PIXELS), truth);
    }
    const double share = (double)n.held / n.all, mean = n.mean / n.all;
    /* Where there is no bias a square is spread otherwise than a normal variable: more safely. */
    ok(fabs(mean - truth) < 0.03 * truth + 2e-5 && share >= 0.93 && (bias == 0 || share <= 0.97),
       "bias^2 of %.4g is %.4g on the average; intervals hold it in %.1f %%", truth, mean,
       100 * share);
}

static void what_is_not_there(void)
{
    static struct curve c = {.points = 3, .runs = 2, .work = {1, 10, 100}};
    for (uint32_t p = 0; p < 3; p++)
        c.error[p][0] = c.error[p][1] = pow(10, -(double)p);
    near(curve_work_to(&c, 0.0316227766).at, 31.6227766, 1e-6, "between points it is straight");
    near(curve_slope(&c, 0, 3).at, -1, 1e-12, "and falls as it falls");
    ok(isnan(curve_work_to(&c, 2).at) && isnan(curve_work_to(&c, 0.001).at),
       "an error before the first point and one after the last have no work");
    ok(isnan(curve_slope(&c, 1, 2).at), "one point has no slope");
    c.error[2][0] = c.error[2][1] = 0;
    near(curve_slope(&c, 0, 3).at, -1, 1e-12, "a point without error is none of the line's");
    static struct curve far = {.points = 2, .runs = 2, .work = {1e6, 1e7}};
    far.error[0][0] = far.error[0][1] = far.error[1][0] = far.error[1][1] = 1;
    ok(isnan(curve_gain(&c, &far).at), "curves that never meet in work are not compared");
}

static void errors_of_images(void)
{
    const double y[6] = {1, 1, 1, 3, 3, 3}, x[6] = {1.5, 1, 1, 3, 3, 0};
    double trimmed, scratch[1000];
    const double e = 1e-4 * 4; /* (0.01 x 2)^2 */
    near(curve_relmse(x, y, 2, &trimmed, scratch), (.25 / (1 + e) + 9 / (9 + e)) / 6, 1e-12,
         "relMSE as it is defined");
    static double many[3000], ones[3000];
    for (int i = 0; i < 3000; i++)
        many[i] = ones[i] = 1;
    many[300] = 100;
    ok(curve_relmse(many, ones, 1000, &trimmed, scratch) > 3 && trimmed == 0,
       "one pixel in a thousand is left out of the trimmed error");
    const double black[3] = {0, 0, 0};
    ok(curve_relmse(black, black, 1, &trimmed, scratch) == 0 && trimmed == 0,
       "a black image is not off from a black one");
    ok(isinf(curve_relmse(y, black, 1, &trimmed, scratch)), "any other is, without end");
}

static void equality_is_proven(void)
{
    ok(curve_unequal_p(0.001, 0.001, 14, 0.01) < 1e-5, "a small difference, well known, is one");
    ok(curve_unequal_p(0.001, 0.02, 14, 0.01) > 0.3, "one that is badly known proves nothing");
    ok(curve_unequal_p(0.02, 0.001, 14, 0.01) > 0.99, "a large one is not equal");
    ok(curve_unequal_p(0, 0, 14, 0.01) == 0 && curve_unequal_p(1, 0, 14, 0.01) == 1,
       "without noise it is plain");
}

int main(void)
{
    errors_of_images();
    what_is_not_there();
    equality_is_proven();
    lines_are_true(&base);
    lines_are_true(&(struct estimator){"noisy, cheap", 3, 0, .2, 1});
    lines_are_true(&(struct estimator){"quiet, dear", .2, 0, 6, 1});
    lines_are_true(&(struct estimator){"steep", 1, 0, 2, 1.5});
    lines_are_true(&(struct estimator){"biased", 1, .1, 1, 1});
    bias_is_told(0);
    bias_is_told(.1);
    return tap_done();
}
