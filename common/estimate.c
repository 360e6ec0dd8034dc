/* SPDX-License-Identifier: MIT */
#include "common/estimate.h"

#include <math.h>

void estimate_pixel(const struct film *f, size_t pixel, double standard_error[3])
{
    const uint32_t spp = f->spp[pixel];
    const float *sums = f->replicate + pixel * FILM_CHANNELS;
    for (int c = 0; c < 3; c++) {
        if (spp < FILM_REPLICATES) {
            standard_error[c] = (double)INFINITY;
            continue;
        }
        double mean[FILM_REPLICATES], center = 0, square = 0;
        for (uint32_t r = 0; r < FILM_REPLICATES; r++) {
            mean[r] = (double)sums[3 * r + (uint32_t)c] / film_replicate_spp(spp, r);
            center += mean[r] / FILM_REPLICATES;
        }
        for (int r = 0; r < FILM_REPLICATES; r++)
            square += (mean[r] - center) * (mean[r] - center);
        standard_error[c] = sqrt(square / ((FILM_REPLICATES - 1) * FILM_REPLICATES));
    }
}

double estimate_least(const struct film *f)
{
    const size_t pixels = tile_rect_pixels(f->window);
    double total = 0;
    for (size_t i = 0; i < pixels; i++) {
        double mean[3];
        film_mean(f, i, mean);
        total += mean[0] + mean[1] + mean[2];
    }
    return 0.01 * total / (3.0 * (double)pixels);
}

double estimate_error(const struct film *f)
{
    const size_t pixels = tile_rect_pixels(f->window);
    const double least = estimate_least(f);
    double sum = 0;
    for (size_t i = 0; i < pixels; i++) {
        double mean[3], s[3];
        film_mean(f, i, mean);
        estimate_pixel(f, i, s);
        for (int c = 0; c < 3; c++)
            if (s[c] != 0) /* a black image has least 0 and s 0 */
                sum += s[c] * s[c] / (mean[c] * mean[c] + least * least);
    }
    return sqrt(sum / (3.0 * (double)pixels));
}

/* Adds to without[r] the squared standard error of all eight, from all but replicate r, times
 * scale; to the ninth that from all. */
static void add_jackknife(double without[FILM_REPLICATES + 1], const double m[FILM_REPLICATES],
                          double scale)
{
    enum { R = FILM_REPLICATES };
    double center = 0, square = 0;
    for (int r = 0; r < R; r++)
        center += m[r] / R;
    for (int r = 0; r < R; r++)
        square += (m[r] - center) * (m[r] - center);
    without[R] += scale * square / ((R - 1) * R);
    for (int r = 0; r < R; r++) { /* the sum of squares, with one value less */
        const double off = m[r] - center, left = square - off * off * R / (R - 1);
        without[r] += scale * (left > 0 ? left : 0) / ((R - 2) * R);
    }
}

static void jackknife_pixel(const struct film *f, size_t pixel, double least,
                            double without[FILM_REPLICATES + 1])
{
    const float *sums = f->replicate + pixel * FILM_CHANNELS;
    double mean[3], m[FILM_REPLICATES];
    film_mean(f, pixel, mean);
    for (uint32_t c = 0; c < 3; c++) {
        const double y2 = mean[c] * mean[c] + least * least;
        if (!(y2 > 0))
            continue;
        for (uint32_t r = 0; r < FILM_REPLICATES; r++)
            m[r] = (double)sums[3 * r + c] / film_replicate_spp(f->spp[pixel], r);
        add_jackknife(without, m, 1 / y2);
    }
}

/* U of the header and how far its interval reaches to either side. */
struct square {
    double at, wide;
};

static struct square square_of(const struct film *f, struct tile_rect part, double least)
{
    enum { R = FILM_REPLICATES };
    const struct tile_rect w = f->window;
    const size_t width = w.x_end - w.x_begin;
    double without[R + 1] = {0}, pseudo[R], center = 0, spread = 0;
    for (uint32_t y = part.y_begin; y < part.y_end; y++)
        for (uint32_t x = part.x_begin; x < part.x_end; x++) {
            const size_t i = (y - w.y_begin) * width + (x - w.x_begin);
            if (f->spp[i] < R)
                return (struct square){(double)INFINITY, 0};
            jackknife_pixel(f, i, least, without);
        }
    for (int r = 0; r < R; r++) {
        pseudo[r] = R * without[R] - (R - 1) * without[r];
        center += pseudo[r] / R;
    }
    for (int r = 0; r < R; r++)
        spread += (pseudo[r] - center) * (pseudo[r] - center);
    return (struct square){without[R], 2.365 * sqrt(spread / (R * (R - 1)))};
}

struct estimate_interval estimate_interval(const struct film *f)
{
    const struct square u = square_of(f, f->window, estimate_least(f));
    if (isinf(u.at))
        return (struct estimate_interval){0, (double)INFINITY};
    const double low = u.at - u.wide, high = u.at + u.wide;
    const double n = 3.0 * (double)tile_rect_pixels(f->window);
    return (struct estimate_interval){low > 0 ? sqrt(low / n) : 0, sqrt(high / n)};
}

struct estimate_part estimate_part(const struct film *f, struct tile_rect part, double least)
{
    const struct square u = square_of(f, part, least);
    const double n = 3.0 * (double)tile_rect_pixels(part);
    return (struct estimate_part){u.at / n, (u.at + u.wide) / n};
}
