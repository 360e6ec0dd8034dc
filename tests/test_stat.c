/* stat.c: the tests' own tools tell truth from error at the rates they state.
 * SPDX-License-Identifier: MIT */
#include "tests/stat.h"

#include <math.h>

#include "tests/dice.h"
#include "tests/tap.h"

enum { SETS = 1000, CELLS = 20, DRAWS = 2000 };

/* Share of data sets rejected at level 0.01 when cell 0 has (1 + bias) times its due. */
static double chi2_rejects(double bias)
{
    struct dice dice = dice_make(1);
    int rejected = 0;
    for (int set = 0; set < SETS; set++) {
        uint32_t seen[CELLS] = {0};
        double due[CELLS];
        for (int i = 0; i < CELLS; i++)
            due[i] = (double)DRAWS / CELLS;
        for (int i = 0; i < DRAWS; i++) {
            const double u = dice_unit(&dice) * (CELLS + bias) - bias;
            seen[u < 0 ? 0 : (int)u]++;
        }
        rejected += stat_chi2_test(due, seen, CELLS) < 0.01;
    }
    return (double)rejected / SETS;
}

static double z_rejects(double truth)
{
    struct dice dice = dice_make(2);
    const double limit = stat_z_limit(0.01);
    int rejected = 0;
    for (int set = 0; set < SETS; set++) {
        struct stat_mean m = {0};
        for (int i = 0; i < DRAWS; i++)
            stat_add(&m, dice_unit(&dice));
        rejected += fabs(m.mean - truth) > limit * stat_error(&m);
    }
    return (double)rejected / SETS;
}

int main(void)
{
    near(stat_z_limit(stat_sidak(0.01, 1)), 2.58, 0.005, "z limit of one test");
    near(stat_z_limit(stat_sidak(0.01, 100)), 3.89, 0.005, "z limit of 100 tests");
    near(stat_z_limit(stat_sidak(0.01, 1e6)), 5.73, 0.005, "z limit of a million tests");
    near(stat_chi2_tail(3.841459, 1), 0.05, 1e-6, "chi-square tail, 1 degree of freedom");
    near(stat_chi2_tail(18.307038, 10), 0.05, 1e-6, "chi-square tail, 10 degrees of freedom");
    near(stat_chi2_tail(82.358, 100), 0.9, 1e-4, "chi-square tail, the other side");
    near(stat_chi2_tail(1e4, 1), 0, 1e-300, "chi-square tail far out");

    near(chi2_rejects(0), 0.01, 0.009, "chi-square test rejects the truth in 1 %% of 1000 sets");
    ok(chi2_rejects(1) > 0.99, "chi-square test rejects a cell that is twice as probable");
    near(z_rejects(0.5), 0.01, 0.009, "z test rejects the truth in 1 %% of 1000 sets");
    ok(z_rejects(0.5 + 0.033) > 0.99, "z test rejects what lies five standard errors off");

    const double none[] = {100, 0, 100};
    const uint32_t some[] = {100, 1, 100};
    ok(stat_chi2_test(none, some, 3) == 0, "chi-square test rejects the impossible");
    return tap_done();
}
