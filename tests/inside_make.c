/* SPDX-License-Identifier: MIT */
#include "tests/inside_make.h"

#include <math.h>

#include "common/trace/glass_albedo.h"
#include "common/trace/several.h"

static const double pi = 3.14159265358979323846;

/* Smith's S of microfacet.h. */
static double s_of(double z, double alpha)
{
    return sqrt(alpha * alpha + (1 - alpha * alpha) * z * z);
}

/* A weight at the cosine z, to the ends of its cell. */
static void share_out(double z, double weight, double cells[INSIDE_CELLS])
{
    const double x = sqrt(fmin(1, z)) * STACK_CELLS;
    const int i = x < STACK_CELLS - 1 ? (int)x : STACK_CELLS - 1;
    cells[i] += weight * (1 - (x - i));
    cells[i + 1] += weight * (x - i);
}

struct light { /* along the cosine z, below */
    double z, eta, alpha;
};

/* Of a facet at the cosine c, whose normal is hz high. */
static void facet(const struct light *l, double c, double hz, double weight, double *parts)
{
    const double eta = l->eta, tt = eta * eta - 1 + c * c;
    if (!(tt > 0))
        return;
    const double g = sqrt(tt), s = (c - g) / (c + g); /* g: eta times cos_t */
    const double p = (eta * eta * c - g) / (eta * eta * c + g), f = 0.5 * (s * s + p * p);
    const double out = (g - c) / eta * hz + l->z / eta, back = 2 * c * hz - l->z;
    if (out > 0)
        share_out(out, weight * (1 - f) * 2 * out / (out + s_of(out, l->alpha)), parts);
    if (!(back > 0))
        return;
    const double sz = s_of(l->z, l->alpha), sb = s_of(back, l->alpha);
    const double mirrored = weight * (1 - f) * back * (l->z + sz) / (l->z * sb + back * sz);
    parts[INSIDE_CELLS] += mirrored;
    parts[INSIDE_CELLS + 1] += mirrored * pow(1 - fmin(1, g / eta + l->alpha), 6);
}

/* The caps of microfacet_visible, in even steps; one half of each turn. */
void inside_make_parts(double z, double ior, double alpha, int n, double parts[INSIDE_PARTS])
{
    const double x = sqrt(fmax(0, 1 - z * z)), wx = x * alpha, length = hypot(wx, z);
    const struct light light = {z, 1 / ior, alpha};
    const double cap = 1 + z / length;
    for (int k = 0; k < INSIDE_PARTS; k++)
        parts[k] = 0;
    for (int j = 0; j < n * n; j++) {
        const double v = (j / n + 0.5) / n, phi = pi * (j % n + 0.5) / n;
        const double r = sqrt(v * cap * (2 - v * cap)), hz = cap * (1 - v);
        const double hx = (wx / length + r * cos(phi)) * alpha, hy = r * sin(phi) * alpha;
        const double size = sqrt(hx * hx + hy * hy + hz * hz);
        facet(&light, fmin(1, (x * hx + z * hz) / size), hz / size, 1.0 / n / n, parts);
    }
}

static double ior_at(int i)
{
    const double least = 0.1 / 2.1, t = (double)i / (INSIDE_IORS - 1);
    const double r = least + (0.5 - least) * t * t;
    return (1 + r) / (1 - r);
}

static double alpha_at(int i)
{
    const double root = 0x1p-5 + (1 - 0x1p-5) * i / (INSIDE_WIDTHS - 1);
    return root * root;
}

/* The cosine of a knot: inside_height turned round. */
static double cosine_at(double ior, double alpha, int height)
{
    const double nn = ior * ior, critical = sqrt(1 - 1 / nn), width = alpha / critical;
    const double u = (double)(height - INSIDE_BEYOND) / INSIDE_WITHIN;
    if (u >= 0)
        return sqrt((u * u * u * u + nn - 1) / nn);
    const double h = (double)(INSIDE_BEYOND - height) / INSIDE_BEYOND;
    return fmax(1e-4, critical * (1 - h * width / (1 + width - h)));
}

void inside_make_row(int ior, int width, int height, uint16_t row[INSIDE_PARTS])
{
    double parts[INSIDE_PARTS];
    const double n = ior_at(ior), alpha = alpha_at(width);
    inside_make_parts(cosine_at(n, alpha, height), n, alpha, 128, parts);
    for (int k = 0; k < INSIDE_PARTS; k++)
        row[k] = (uint16_t)lround(65535 * fmin(1, parts[k]));
}

void inside_make_mean(const struct inside_table *t, int ior, int width, float mean[INSIDE_PARTS])
{
    enum { STEPS = 4096 };
    const struct inside_glass in = {.ior = (float)ior_at(ior), .alpha = (float)alpha_at(width)};
    double sum[INSIDE_PARTS] = {0};
    for (int i = 0; i < STEPS; i++) {
        const double z = (i + 0.5) / STEPS;
        float parts[INSIDE_PARTS];
        inside_parts(t, &in, (float)z, parts);
        for (int k = 0; k < INSIDE_PARTS; k++)
            sum[k] += (double)parts[k] * 2 * z / STEPS;
    }
    for (int k = 0; k < INSIDE_PARTS; k++)
        mean[k] = (float)sum[k];
}

/* Of light that met several facets: glass_albedo.h. */
void inside_make_several(int ior, int width, float several[INSIDE_CELLS])
{
    enum { STEPS = 1024 };
    const struct glass_albedo g = {(float)ior_at(ior), (float)alpha_at(width)};
    const double nn = (double)g.ior * (double)g.ior;
    const double all =
        (double)glass_albedo_mean(&g, false) + nn * (double)glass_albedo_mean(&g, true);
    double cells[INSIDE_CELLS] = {0};
    for (int i = 0; all > (double)SEVERAL_LEAST && i < STEPS; i++) {
        const double root = (i + 0.5) / STEPS, z = root * root;
        share_out(z,
                  (double)glass_albedo_missing(&g, false, (float)z) * 4 * z * root / (all * STEPS),
                  cells);
    }
    for (int k = 0; k < INSIDE_CELLS; k++)
        several[k] = (float)cells[k];
}
