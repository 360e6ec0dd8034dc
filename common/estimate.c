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

struct ends { /* of the interval: over pixels, of sums over channels */
    double low, crossed, crossed2;
};

/* Adds to without[r] the squared standard error of all eight, from all but replicate r, times
 * scale; to the ninth that from all, and returns it. */
static double add_jackknife(double without[FILM_REPLICATES + 1], const double m[FILM_REPLICATES],
                            double scale)
{
    enum { R = FILM_REPLICATES };
    double center = 0, square = 0;
    for (int r = 0; r < R; r++)
        center += m[r] / R;
    for (int r = 0; r < R; r++)
        square += (m[r] - center) * (m[r] - center);
    for (int r = 0; r < R; r++) { /* the sum of squares, with one value less */
        const double off = m[r] - center, left = square - off * off * R / (R - 1);
        without[r] += scale * (left > 0 ? left : 0) / ((R - 2) * R);
    }
    const double all = scale * square / ((R - 1) * R);
    without[R] += all;
    return all;
}

/* The squared error of two replicates relative to the mean of the six others, in all eight ways. */
static double crossed(const double m[FILM_REPLICATES], double least)
{
    enum { R = FILM_REPLICATES };
    double total = 0, sum = 0;
    for (int r = 0; r < R; r++)
        total += m[r];
    for (int r = 0; r < R; r++) {
        const double a = m[r], b = m[(r + 1) % R], y = (total - a - b) / (R - 2);
        const double y2 = y * y + least * least;
        if (y2 > 0)
            sum += (a - b) * (a - b) / y2;
    }
    return sum / (2 * R * R);
}

/* ends: NULL when they are not asked for. */
static void add_pixel(const struct film *f, size_t pixel, double least,
                      double without[FILM_REPLICATES + 1], struct ends *ends)
{
    const float *sums = f->replicate + pixel * FILM_CHANNELS;
    double mean[3], m[FILM_REPLICATES], both = 0;
    film_mean(f, pixel, mean);
    for (uint32_t c = 0; c < 3; c++) {
        const double y2 = mean[c] * mean[c] + least * least;
        if (!(y2 > 0))
            continue;
        for (uint32_t r = 0; r < FILM_REPLICATES; r++)
            m[r] = (double)sums[3 * r + c] / film_replicate_spp(f->spp[pixel], r);
        const double square = add_jackknife(without, m, 1 / y2);
        if (!ends || square == 0)
            continue;
        ends->low += square / (1 + 3 * square);
        both += crossed(m, least);
    }
    if (!ends)
        return;
    ends->crossed += both;
    ends->crossed2 += both * both;
}

/* U of the header and how far it may be off by chance. */
struct square {
    double at, wide;
};

static struct square square_of(const struct film *f, struct tile_rect part, double least,
                               struct ends *ends)
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
            add_pixel(f, i, least, without, ends);
        }
    for (int r = 0; r < R; r++) {
        pseudo[r] = R * without[R] - (R - 1) * without[r];
        center += pseudo[r] / R;
    }
    for (int r = 0; r < R; r++)
        spread += (pseudo[r] - center) * (pseudo[r] - center);
    return (struct square){without[R], 2.365 * sqrt(spread / (R * (R - 1)))};
}

struct estimate_part estimate_part(const struct film *f, struct tile_rect part, double least)
{
    const struct square u = square_of(f, part, least, NULL);
    const double n = 3.0 * (double)tile_rect_pixels(part);
    return (struct estimate_part){u.at / n, (u.at + u.wide) / n};
}

struct estimate_interval estimate_interval(const struct film *f)
{
    struct ends e = {0};
    const struct square u = square_of(f, f->window, estimate_least(f), &e);
    const double n = 3.0 * (double)tile_rect_pixels(f->window), low = e.low - u.wide;
    if (isinf(u.at))
        return (struct estimate_interval){0, (double)INFINITY};
    const double high = max_f64(u.at + u.wide, e.crossed + 2 * sqrt(e.crossed2));
    return (struct estimate_interval){low > 0 ? sqrt(low / n) : 0, sqrt(high / n)};
}
