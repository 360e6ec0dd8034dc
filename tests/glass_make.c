/* SPDX-License-Identifier: MIT */
#include "tests/glass_make.h"

#include <math.h>

static const double pi = 3.14159265358979323846;

/* By so much what is stored is short of what is missing (glass_albedo.h). */
static const double short_by = 0.005;

/* Smith's S of microfacet.h. */
static double s_of(double z, double alpha)
{
    return sqrt(alpha * alpha + (1 - alpha * alpha) * z * z);
}

/* Of light that meets a facet at the cosine c, whose normal is hz high. */
static double facet(double z, double alpha, double eta, double c, double hz)
{
    const double tt = eta * eta - 1 + c * c, g = sqrt(fmax(0, tt)); /* g: eta times cos_t */
    const double s = (c - g) / (c + g), p = (eta * eta * c - g) / (eta * eta * c + g);
    const double f = tt > 0 ? 0.5 * (s * s + p * p) : 1, up = 2 * c * hz - z;
    const double down = (g - c) / eta * hz + z / eta; /* of the refracted, below */
    double out = 0;
    if (up > 0)
        out += f * up * (z + s_of(z, alpha)) / (z * s_of(up, alpha) + up * s_of(z, alpha));
    if (f < 1 && down > 0)
        out += (1 - f) * 2 * down / (down + s_of(down, alpha));
    return out;
}

/* The caps of microfacet_visible, in even steps; one half of each turn. */
double glass_make_once(double cos_o, double alpha, double eta, int n)
{
    const double x = sqrt(1 - cos_o * cos_o), wx = x * alpha, length = hypot(wx, cos_o);
    const double cap = 1 + cos_o / length;
    double sum = 0;
    for (int j = 0; j < n * n; j++) {
        const double v = (j / n + 0.5) / n, phi = pi * (j % n + 0.5) / n;
        const double r = sqrt(v * cap * (2 - v * cap)), hz = cap * (1 - v);
        const double hx = (wx / length + r * cos(phi)) * alpha, hy = r * sin(phi) * alpha;
        const double size = sqrt(hx * hx + hy * hy + hz * hz);
        sum += facet(cos_o, alpha, eta, (x * hx + cos_o * hz) / size, hz / size);
    }
    return sum / n / n;
}

static double ior_at(int i)
{
    const double least = 0.1 / 2.1, t = (double)i / (GLASS_ALBEDO_IORS - 1);
    const double r = least + (0.6 - least) * t * t;
    return (1 + r) / (1 - r);
}

static double alpha_at(int i)
{
    const double root = fmax(0x1p-5, (double)i / (GLASS_ALBEDO_WIDTHS - 1));
    return root * root;
}

uint16_t glass_make_missing(bool below, int ior, int width, int height)
{
    enum { POINTS = 128 };
    const double n = ior_at(ior), alpha = alpha_at(width);
    const double h = (double)height / (GLASS_ALBEDO_HEIGHTS - 1);
    const double z = fmin(1, fmax(1e-4, h * alpha / (1 + alpha - h)));
    const double missing = 1 - glass_make_once(z, alpha, below ? 1 / n : n, POINTS);
    return (uint16_t)(65535 * fmax(0, missing - short_by));
}

float glass_make_mean(const struct glass_albedo_table *t, bool below, int ior, int width)
{
    enum { STEPS = 4096 };
    const struct glass_albedo g = {(float)ior_at(ior), (float)alpha_at(width)};
    double sum = 0;
    for (int i = 0; i < STEPS; i++) { /* even in sqrt(z): it is steep where z is small */
        const double root = (i + 0.5) / STEPS, z = root * root;
        sum += (double)glass_albedo_missing_by(t, &g, below, (float)z) * 4 * z * root / STEPS;
    }
    return (float)sum;
}
