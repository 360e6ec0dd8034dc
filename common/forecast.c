/* SPDX-License-Identifier: MIT */
#include "common/forecast.h"

#include <math.h>

static const double prior = .5, prior_sd = .1; /* of b */
static const double error_sd = .05;            /* of an error estimate, relative */
static const double least_slope = .2, most_slope = 1;

struct forecast forecast_make(const struct forecast_point *p, size_t count, double target)
{
    const struct forecast_point last = p[count - 1];
    const double n = (double)count;
    double x = 0, y = 0, xx = 0, xy = 0; /* of ln samples and -ln error */
    for (size_t i = 0; i < count; i++) {
        x += log(p[i].samples) / n;
        y -= log(p[i].error) / n;
    }
    for (size_t i = 0; i < count; i++) {
        const double dx = log(p[i].samples) - x, dy = -log(p[i].error) - y;
        xx += dx * dx;
        xy += dx * dy;
    }
    const double noise = error_sd * error_sd, known = prior_sd * prior_sd;
    const double weight = 1 / known + xx / noise;
    const double b = fmin(fmax((prior / known + xy / noise) / weight, least_slope), most_slope);
    if (last.error <= target)
        return (struct forecast){-b, last.samples, last.samples, last.samples};
    const double way = (-log(target) - y) / b, middle = fmax(x + way, log(last.samples));
    const double wide = 2 * sqrt(way * way / (weight * b * b) + noise / (n * b * b));
    return (struct forecast){
        .slope = -b,
        .samples = exp(middle),
        .low = exp(fmax(middle - wide, log(last.samples))),
        .high = exp(middle + wide),
    };
}
