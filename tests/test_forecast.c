/* forecast.c against curves whose end is known. SPDX-License-Identifier: MIT */
#include "common/forecast.h"

#include <math.h>

#include "tests/dice.h"
#include "tests/tap.h"

enum { POINTS = 7, CURVES = 1000 };

/* error = N^-b from 8 samples on, doubling, each estimate off by 5 %. */
static void curve(struct dice *d, double b, struct forecast_point out[POINTS])
{
    for (int i = 0; i < POINTS; i++) {
        const double n = 8 << i;
        out[i] = (struct forecast_point){n, pow(n, -b) * exp(.05 * dice_normal(d))};
    }
}

static void one_point(void)
{
    const struct forecast_point p = {1000, .1};
    const struct forecast f = forecast_make(&p, 1, .05);
    near(f.samples, 4000, 1e-9,
         "with one point errors fall with the root: half the error, four times the samples");
    ok(f.low < 3300 && f.high > 4900, "and it is not sure of it: %g to %g", f.low, f.high);
    const struct forecast there = forecast_make(&p, 1, .2);
    ok(there.samples == 1000 && there.low == 1000 && there.high == 1000,
       "what is reached is reached");
}

static void many_points(void)
{
    static const double slopes[] = {.35, .5, .65, .75};
    struct dice d = dice_make(1);
    for (size_t s = 0; s < countof(slopes); s++) {
        int inside = 0, twice = 0;
        for (int i = 0; i < CURVES; i++) {
            struct forecast_point p[POINTS];
            curve(&d, slopes[s], p);
            const double all = 8 << (POINTS + 2), target = pow(all, -slopes[s]);
            const struct forecast f = forecast_make(p, POINTS, target);
            inside += f.low <= all && all <= f.high;
            twice += f.samples < 2 * all && f.samples > all / 2;
        }
        ok(inside > .9 * CURVES,
           "slope -%.2f, 8 times the samples ahead: the range holds the truth in %d of 1000",
           slopes[s], inside);
        ok(twice > .95 * CURVES, "and the forecast is within a factor of 2 in %d", twice);
    }
}

int main(void)
{
    one_point();
    many_points();
    return tap_done();
}
