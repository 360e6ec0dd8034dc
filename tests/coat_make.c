/* SPDX-License-Identifier: MIT */
#include "tests/coat_make.h"

#include <math.h>

static const double pi = 3.14159265358979323846;

static double fresnel(double c, double n)
{
    const double g = sqrt(n * n - 1 + c * c);
    const double s = (c - g) / (c + g), p = (n * n * c - g) / (n * n * c + g);
    return 0.5 * (s * s + p * p);
}

/* Smith's S of microfacet.h. */
static double s_of(double z, double alpha)
{
    return sqrt(alpha * alpha + (1 - alpha * alpha) * z * z);
}

/* Of the facets that are seen, one half of each turn: the two halves are alike. n 0: facets that
 * reflect everything. The caps of microfacet_visible, in even steps. */
static double albedo(double z, double alpha, double n)
{
    enum { STEPS = 128 };
    const double x = sqrt(1 - z * z), wx = x * alpha, length = hypot(wx, z);
    const double cap = 1 + z / length, s = s_of(z, alpha);
    double sum = 0;
    for (int j = 0; j < STEPS * STEPS; j++) {
        const double v = (j / STEPS + 0.5) / STEPS, phi = pi * (j % STEPS + 0.5) / STEPS;
        const double r = sqrt(v * cap * (2 - v * cap)), hz = cap * (1 - v);
        const double hx = (wx / length + r * cos(phi)) * alpha, hy = r * sin(phi) * alpha;
        const double size = sqrt(hx * hx + hy * hy + hz * hz);
        const double c = (x * hx + z * hz) / size, i = 2 * c * hz / size - z;
        if (i > 0)
            sum += (n > 0 ? fresnel(c, n) : 1) * i * (z + s) / (z * s_of(i, alpha) + i * s);
    }
    return sum / (STEPS * STEPS);
}

double coat_make_albedo(double cos, double alpha, double ior)
{
    return albedo(cos, alpha, ior);
}

static double ior_at(int i)
{
    const double least = 0.1 / 2.1, r = least + (0.5 - least) * i / (COAT_IORS - 1);
    return (1 + r) / (1 - r);
}

static double alpha_at(int i)
{
    const double root = fmax(0x1p-5, (double)i / (COAT_WIDTHS - 1));
    return root * root;
}

uint16_t coat_make_ratio(int ior, int width, int slope)
{
    const double n = ior_at(ior), alpha = alpha_at(width);
    const double root = (double)slope / (COAT_SLOPES - 1), y = fmin(root * root, 0.9999);
    const double tan = 2 * y / (1 - y * y) / alpha, z = 1 / sqrt(1 + tan * tan);
    const double m = 0.5 * (z + s_of(z, alpha));
    const double ratio = (1 - albedo(z, alpha, n) / albedo(z, alpha, 0)) / (1 - fresnel(m, n));
    return (uint16_t)floor(fmin(65535, ratio * COAT_RATIO_ONE));
}

float coat_make_mean(const struct coat_table *t, int ior, int width)
{
    enum { STEPS = 4096 };
    double sum = 0;
    for (int i = 0; i < STEPS; i++) { /* 2 z dz, even in sqrt(z): T is steep where z is small */
        const double root = (i + 0.5) / STEPS, z = root * root;
        sum += (double)coat_table_passes(t, (float)ior_at(ior), (float)alpha_at(width), (float)z) *
               2 * z * 2 * root / STEPS;
    }
    return (float)sum;
}
