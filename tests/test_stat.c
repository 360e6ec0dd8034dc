/* stat/{stat,means,chi2,ks}.h: the tests' own tools tell truth from error at the rates they state.
 * Each is given 1000 data sets in which the truth holds, and 1000 with the smallest bias that it
 * says it detects. SPDX-License-Identifier: MIT */
#include "tests/stat/stat.h"

#include <math.h>

#include "tests/dice.h"
#include "tests/stat/chi2.h"
#include "tests/stat/ks.h"
#include "tests/stat/means.h"
#include "tests/tap.h"

enum { SETS = 1000 };
static const double level = 0.01;

/* One data set with a bias: is it rejected? */
typedef bool rejects(struct dice *, double bias);

static double rate(rejects *test, double bias)
{
    struct dice dice = dice_make(1);
    int rejected = 0;
    for (int set = 0; set < SETS; set++)
        rejected += test(&dice, bias);
    return (double)rejected / SETS;
}

/* 0.009: 2.9 standard deviations of 1000 trials with a chance of 1 or 99 %. */
static void both_sides(rejects *test, double bias, const char *name)
{
    near(rate(test, 0), level, 0.009, "%s rejects the truth in 1 %% of 1000 sets", name);
    near(rate(test, bias), STAT_POWER, 0.009, "and finds its smallest bias, %.4g, in 99 %%", bias);
}

/* --- counts --- */

enum { CELLS = 20, DRAWS = 2000 };

static bool chi2_rejects(struct dice *dice, double bias)
{
    uint32_t seen[CELLS] = {0};
    double due[CELLS];
    for (int i = 0; i < CELLS; i++)
        due[i] = (double)DRAWS / CELLS;
    for (int i = 0; i < DRAWS;
         i++) { /* even cells have 1 + bias times their due, odd ones 1 - bias */
        const int pair = (int)(dice_unit(dice) * CELLS / 2);
        seen[2 * pair + (dice_unit(dice) * 2 > 1 + bias)]++;
    }
    return chi2_test(due, seen, CELLS).p < level;
}

static void counts(void)
{
    const struct chi2 plain = {.dof = CELLS - 1};
    both_sides(chi2_rejects, chi2_detects(&plain, DRAWS, level), "chi-square test of 2000 counts");
    const double none[] = {100, 0, 100};
    const uint32_t some[] = {100, 1, 100}, few[] = {1, 1, 1};
    ok(chi2_test(none, some, 3).p == 0, "chi-square test rejects the impossible");
    ok(chi2_test((double[]){1, 1, 1}, few, 3).p == 0, "and counts too few to judge");
    /* Pools of 1 + 4, 5, 6 by order of expectation; the last 2 cells would not fill another. */
    const double due[] = {4, 1, 6, 5};
    ok(chi2_test(due, (uint32_t[]){1, 4, 6, 5}, 4).p == 1, "small cells are pooled");
    near(chi2_test(due, (uint32_t[]){4, 1, 6, 5}, 4).dof, 2, 0, "into as many as can be filled");
}

/* --- means --- */

static struct stat_mean normals(struct dice *dice, int n, double at)
{
    struct stat_mean m = {0};
    for (int i = 0; i < n; i++)
        stat_add(&m, at + dice_normal(dice));
    return m;
}

enum { FEW = 8, MANY = 300 };

static bool t_rejects(struct dice *dice, double bias)
{
    const struct stat_mean m = normals(dice, FEW, 3 + bias);
    const struct means d = means_from_truth(&m, 3);
    return means_p(&d) < level;
}

static bool z_rejects(struct dice *dice, double bias)
{
    const struct stat_mean m = normals(dice, FEW, 3 + bias);
    const struct means d = {m.mean - 3, 1 / sqrt(FEW), (double)INFINITY};
    return means_p(&d) < level;
}

static bool uniform_rejects(struct dice *dice, double bias)
{
    struct stat_mean m = {0};
    for (int i = 0; i < MANY; i++)
        stat_add(&m, bias + dice_unit(dice));
    const struct means d = means_from_truth(&m, 0.5);
    return means_p(&d) < level;
}

static bool welch_rejects(struct dice *dice, double bias)
{
    const struct stat_mean a = normals(dice, MANY, bias), b = normals(dice, 2 * MANY, 0);
    const struct means d = means_between(&a, &b);
    return means_p(&d) < level;
}

static const struct means one = {0, 1, FEW - 1};

static void means(void)
{
    const double few = 1 / sqrt(FEW), many = 1 / sqrt(MANY);
    const struct means t = {0, few, FEW - 1}, z = {0, few, (double)INFINITY};
    const struct means u = {0, many / sqrt(12), MANY - 1}, w = {0, many * sqrt(1.5), 2 * MANY};
    both_sides(t_rejects, means_detects(&t, level), "t test of 8 normal values");
    both_sides(z_rejects, means_detects(&z, level), "z test of 8 normal values");
    both_sides(uniform_rejects, means_detects(&u, level), "t test of 300 uniform values");
    both_sides(welch_rejects, means_detects(&w, level), "t test between 300 values and 600");
    const struct means same = {0, 0, 7}, other = {1e-9, 0, 7}, lost = {(double)NAN, 1, 7};
    ok(means_p(&same) == 1 && means_p(&other) == 0, "without noise only equals are equal");
    ok(!(means_p(&lost) >= level), "a mean that is no number is rejected");
    near(means_detects(&one, 0.05) / means_detects(&(struct means){0, 1, 1e6}, 0.05), 1.2, 0.1,
         "few replicates cost power");
}

/* --- equality --- */

static double margin;

static bool equality_rejects(struct dice *dice, double bias)
{
    const struct stat_mean m = normals(dice, MANY, bias);
    const struct means d = means_from_truth(&m, 0);
    return !(means_unequal_p(&d, margin) < level);
}

static void equality(void)
{
    const struct means d = {0, 1 / sqrt(MANY), MANY - 1};
    margin = means_provable(&d, level);
    near(rate(equality_rejects, 0), 1 - STAT_POWER, 0.009,
         "equality within %.4g is proven in 99 %% of 1000 sets where it holds", margin);
    near(rate(equality_rejects, margin), 1 - level, 0.009, "and in 1 %% where that is the bias");
    near(rate(equality_rejects, -margin), 1 - level, 0.009, "to either side");
    margin *= 0.25;
    ok(rate(equality_rejects, 0) > 0.99, "too few values prove nothing: equality is not assumed");
    const struct means lost = {(double)NAN, 1, 7}, same = {0, 0, 7};
    ok(means_unequal_p(&lost, 1) == 1, "nor for what is no number");
    ok(means_unequal_p(&same, 1e-9) == 0, "but without noise equals are equal");
}

/* --- distributions --- */

static bool ks_rejects(struct dice *dice, double bias)
{
    double u[MANY];
    for (int i = 0; i < MANY; i++) { /* the lower half has 1/2 + bias of all */
        const bool low = dice_unit(dice) < 0.5 + bias;
        u[i] = 0.5 * dice_unit(dice) + (low ? 0 : 0.5);
    }
    return ks_test(u, MANY).p < level;
}

static void distributions(void)
{
    const double bias = ks_detects(MANY, level);
    near(rate(ks_rejects, 0), level, 0.009,
         "Kolmogorov-Smirnov test rejects the truth in 1 %% of 1000 sets");
    ok(rate(ks_rejects, bias) >= 0.981, "and finds its smallest bias, %.4g, in at least 99 %%",
       bias);
    double values[20] = {0.5, (double)NAN};
    ok(ks_test(values, 20).p == 0, "it rejects what is no number");
}

static void levels(void)
{
    near(stat_z_limit(stat_sidak(0.01, 1)), 2.58, 0.005, "z limit of one test");
    near(stat_z_limit(stat_sidak(0.01, 100)), 3.89, 0.005, "z limit of 100 tests");
    near(stat_z_limit(stat_sidak(0.01, 1e6)), 5.73, 0.005, "z limit of a million tests");
    struct dice dice = dice_make(4);
    int rejected = 0;
    for (int suite = 0; suite < SETS; suite++) {
        bool any = false;
        for (int i = 0; i < 100; i++) {
            const struct means z = {dice_normal(&dice), 1, (double)INFINITY};
            any |= means_p(&z) < stat_sidak(level, 100);
        }
        rejected += any;
    }
    near((double)rejected / SETS, level, 0.009, "1 %% of true suites of 100 tests are rejected");
}

int main(void)
{
    levels();
    counts();
    means();
    equality();
    distributions();
    return tap_done();
}
