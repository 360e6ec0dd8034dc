/* SPDX-License-Identifier: MIT */
#include "tests/sheen_make.h"

#include <math.h>

static const double pi = 3.14159265358979323846;

/* What a facet turned by phi, or the one across, returns of what it is seen of. */
static double returned(double x, double z, double hx, double hz)
{
    const double c = x * hx + z * hz, i = 2 * c * hz - z;
    if (!(c > 0 && i > 0))
        return 0;
    return c * fmin(1, 2 * hz * fmin(z, i) / c) / fmin(1, 2 * hz * z / c);
}

double sheen_make_albedo(double roughness, double z)
{
    enum { STEPS = 400 };
    const double x = sqrt(1 - z * z), k = 1 / (roughness * roughness);
    double sum = 0;
    for (int a = 0; a < STEPS; a++) {
        const double sine = pow((a + 0.5) / STEPS, 1 / (k + 2)), hz = sqrt(1 - sine * sine);
        for (int b = 0; b < STEPS; b++) {
            const double hx = sine * cos(pi * (b + 0.5) / STEPS);
            const double both = fmax(0, x * hx + z * hz) + fmax(0, z * hz - x * hx);
            sum += (returned(x, z, hx, hz) + returned(x, z, -hx, hz)) / both;
        }
    }
    return sum / STEPS / STEPS;
}

static double width_at(int i)
{
    return 0.1 + 0.9 * i / (SHEEN_WIDTHS - 1);
}

float sheen_make_entry(int width, int cosine)
{
    const double root = fmax(1e-3, (double)cosine / (SHEEN_COSINES - 1));
    return (float)sheen_make_albedo(width_at(width), root * root);
}

float sheen_make_mean(const struct sheen_table *t, int width)
{
    enum { STEPS = 4096 };
    double sum = 0;
    for (int i = 0; i < STEPS; i++) { /* 2 z dz, even in sqrt(z), as the table is */
        const double root = (i + 0.5) / STEPS, z = root * root;
        sum +=
            (double)sheen_table_albedo(t, (float)width_at(width), (float)z) * 4 * z * root / STEPS;
    }
    return (float)sum;
}
