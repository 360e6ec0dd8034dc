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

double estimate_error(const struct film *f)
{
    const size_t pixels = tile_rect_pixels(f->window);
    double total = 0;
    for (size_t i = 0; i < pixels; i++) {
        double mean[3];
        film_mean(f, i, mean);
        total += mean[0] + mean[1] + mean[2];
    }
    const double least = 0.01 * total / (3.0 * (double)pixels);
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
