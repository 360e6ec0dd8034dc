/* SPDX-License-Identifier: MIT */
#include "bench/against.h"

#include "common/estimate.h"

double against_error2(const struct film *f, const struct film *reference, struct tile_rect part,
                      double least)
{
    const struct tile_rect w = f->window;
    const size_t width = w.x_end - w.x_begin;
    double sum = 0;
    for (uint32_t y = part.y_begin; y < part.y_end; y++)
        for (uint32_t x = part.x_begin; x < part.x_end; x++) {
            const size_t i = (y - w.y_begin) * width + (x - w.x_begin);
            double is[3], truth[3], s[3];
            film_mean(f, i, is);
            film_mean(reference, i, truth);
            estimate_pixel(reference, i, s);
            for (int c = 0; c < 3; c++) {
                const double off = is[c] - truth[c], y2 = truth[c] * truth[c] + least * least;
                sum += y2 > 0 ? (off * off - s[c] * s[c]) / y2 : 0;
            }
        }
    return sum / (3.0 * tile_rect_pixels(part));
}

double against_energy(const struct film *f, const struct film *reference)
{
    double is = 0, truth = 0;
    for (size_t i = 0; i < tile_rect_pixels(f->window); i++) {
        double a[3], b[3];
        film_mean(f, i, a);
        film_mean(reference, i, b);
        is += a[0] + a[1] + a[2];
        truth += b[0] + b[1] + b[2];
    }
    return is / truth - 1;
}
