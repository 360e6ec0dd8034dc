/* Pixel filters as tables (filter.h). In double, by series of our own: the knots decide pixels.
 * SPDX-License-Identifier: MIT */
#include "common/trace/filter.h"
#include "common/trace/prep_plan.h"

#define PI 3.14159265358979323846

/* e^-y, y in [0, 40], as the 256th power of a number near 1. */
static double exp_minus(double y)
{
    const double z = -y / 256;
    double sum = 1, term = 1;
    for (int i = 1; i < 12; i++)
        sum += term *= z / i;
    for (int i = 0; i < 8; i++)
        sum *= sum;
    return sum;
}

/* cos a, a in [0, pi], by twice doubling a quarter of it. */
static double cosine(double a)
{
    const double zz = a * a / 16;
    double sum = 1, term = 1;
    for (int i = 1; i < 10; i++)
        sum += term *= -zz / ((2 * i - 1) * (2 * i));
    for (int i = 0; i < 2; i++)
        sum = 2 * sum * sum - 1;
    return sum;
}

/* The four-term window of F. Harris, "On the Use of Windows for Harmonic Analysis with the Discrete
 * Fourier Transform", Proc. IEEE 66(1), 1978; x is the distance from its middle, its end at 1. */
static double blackman_harris(double x)
{
    const double c = cosine(PI * x);
    return 0.35875 + 0.48829 * c + 0.14128 * (2 * c * c - 1) + 0.01168 * (4 * c * c * c - 3 * c);
}

/* D. Mitchell, A. Netravali, "Reconstruction Filters in Computer Graphics", SIGGRAPH 1988, eq. 8,
 * but for its factor 1/6; x in [0, 2]. Beyond 1 it is (2 - x)^2 (2 b + 6 c - (b + 6 c) x). */
static double mitchell(double b, double c, double x)
{
    if (x < 1)
        return (12 - 9 * b - 6 * c) * x * x * x + (-18 + 12 * b + 6 * c) * x * x + (6 - 2 * b);
    return (2 - x) * (2 - x) * (2 * b + 6 * c - (b + 6 * c) * x);
}

static double filter_at(const struct scene_film *film, double x_px)
{
    const double radius = (double)film->filter_radius_px, sigma = (double)film->filter_sigma_px;
    switch (film->filter) {
    case FILTER_GAUSSIAN:
        return exp_minus(x_px * x_px / (2 * sigma * sigma));
    case FILTER_BLACKMAN_HARRIS:
        return blackman_harris(x_px / radius);
    case FILTER_MITCHELL:
        return mitchell((double)film->filter_b, (double)film->filter_c, 2 * x_px / radius);
    case FILTER_BOX:
    case FILTER_TENT:
        break;
    }
    return 0;
}

/* Where it ends, or what lies beyond would not be met once in 2^24 samples. */
static double reach(const struct scene_film *film)
{
    const double radius = (double)film->filter_radius_px, sigma = (double)film->filter_sigma_px;
    return film->filter == FILTER_GAUSSIAN && radius > 8 * sigma ? 8 * sigma : radius;
}

/* Where it crosses zero, if it does before its end. */
static double zero_of(const struct scene_film *film)
{
    const double b = (double)film->filter_b, c = (double)film->filter_c;
    if (film->filter != FILTER_MITCHELL)
        return reach(film);
    return reach(film) / 2 * (b + c > 0 ? (2 * b + 6 * c) / (b + 6 * c) : 1);
}

void prep_filter(struct prep_plan *p, struct arena *scratch)
{
    enum { HALF = FILTER_PIECES / 2 };
    const struct scene_film *film = &p->scene->film;
    const double end = reach(film), zero = zero_of(film);
    p->head.filter = (struct stage_filter){1, film->filter_radius_px};
    if (film->filter == FILTER_BOX || film->filter == FILTER_TENT)
        return;

    /* A half of the pieces on either side of the zero; or, if there is none, of the middle. */
    const double middle = zero < end ? zero : end / 2;
    double f[FILTER_PIECES + 1], x[FILTER_PIECES + 1], mass[FILTER_PIECES + 1] = {0}, inner = 0;
    for (int i = 0; i <= FILTER_PIECES; i++) {
        x[i] = i <= HALF ? middle * i / HALF : middle + (end - middle) * (i - HALF) / HALF;
        const double value = filter_at(film, x[i]);
        f[i] = value < 0 ? -value : value;
        if (i > 0)
            mass[i] = mass[i - 1] + (f[i - 1] + f[i]) / 2 * (x[i] - x[i - 1]);
        inner = i == HALF ? mass[i] : inner;
    }
    const double all = mass[FILTER_PIECES];
    p->knots = arena_new(scratch, struct stage_knot, FILTER_PIECES + 1);
    for (int i = 0; i <= FILTER_PIECES; i++)
        p->knots[i] = (struct stage_knot){(float)x[i], (float)(f[i] / all), (float)(mass[i] / all)};
    p->head.knots.count = FILTER_PIECES + 1;
    if (zero < end && inner < all) {
        p->head.filter.gain = (float)(all / (2 * inner - all));
        p->head.filter.zero_px = (float)zero;
    }
}
