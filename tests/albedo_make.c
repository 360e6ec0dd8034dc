/* SPDX-License-Identifier: MIT */
#include "tests/albedo_make.h"

#include <math.h>

#include "tests/ggx_albedo.h"

/* By so much what is stored is short of what is missing: more than interpolation errs (albedo.h).
 */
static const double short_one = 0.001, short_two = 0.0098;

enum { POINTS = 256, FEWER_POINTS = 128 }; /* of the quadrature, squared: errors below 1e-5 */

/* The inverses of the coordinates of albedo.c. */
static double square(double coordinate)
{
    return coordinate * coordinate;
}

static double cos_of_height(double height, double seen)
{
    return fmax(1e-4, height * seen / (1 + seen - height));
}

static double knot_at(uint32_t i, uint32_t knots)
{
    return (double)i / (knots - 1);
}

static const double least = 1e-3; /* width: nothing is missing there */

static uint16_t share(double missing)
{
    return (uint16_t)(65535 * fmax(0, missing));
}

uint16_t albedo_make_one(uint32_t index)
{
    const double alpha = fmax(least, square(knot_at(index / ALBEDO_HEIGHTS, ALBEDO_WIDTHS)));
    const double height = knot_at(index % ALBEDO_HEIGHTS, ALBEDO_HEIGHTS);
    const struct ggx_albedo a = {alpha, alpha, cos_of_height(height, alpha), 0};
    return share(1 - ggx_albedo(&a, POINTS) - short_one);
}

uint16_t albedo_make_two(uint32_t index)
{
    const double height = knot_at(index % ALBEDO_FEWER_HEIGHTS, ALBEDO_FEWER_HEIGHTS);
    index /= ALBEDO_FEWER_HEIGHTS;
    const double turn = knot_at(index % ALBEDO_TURNS, ALBEDO_TURNS);
    index /= ALBEDO_TURNS;
    const double ratio = fmax(least, square(knot_at(index % ALBEDO_RATIOS, ALBEDO_RATIOS)));
    const double larger = fmax(least, square(knot_at(index / ALBEDO_RATIOS, ALBEDO_WIDER)));
    const double seen = ratio + (1 - ratio) * square(turn); /* over the larger */
    const double cc = ratio < 1 ? (seen * seen - ratio * ratio) / (1 - ratio * ratio) : 1;
    const struct ggx_albedo a = {larger, larger * ratio, cos_of_height(height, larger * seen),
                                 acos(sqrt(fmin(1, cc)))};
    return share(1 - ggx_albedo(&a, FEWER_POINTS) - short_two);
}

static vec3 direction(double cos_theta, double phi)
{
    const double sine = sqrt(1 - cos_theta * cos_theta);
    return vec3_make((float)(sine * cos(phi)), (float)(sine * sin(phi)), (float)cos_theta);
}

/* Over an eighth of the sphere: the others are its mirror images. Even in cos^2. */
static float mean(const struct albedo_table *t, struct facet a, uint32_t turns)
{
    enum { HEIGHTS = 1024 };
    double sum = 0;
    for (uint32_t i = 0; i < HEIGHTS; i++)
        for (uint32_t k = 0; k < turns; k++) {
            const double phi = (k + .5) / turns * 1.5707963267948966;
            sum += (double)albedo_missing_by(t, direction(sqrt((i + .5) / HEIGHTS), phi), a);
        }
    return (float)(sum / HEIGHTS / turns);
}

float albedo_make_mean_one(const struct albedo_table *t, uint32_t index)
{
    const float alpha = (float)fmax(least, square(knot_at(index, ALBEDO_MEAN_WIDTHS)));
    return mean(t, (struct facet){alpha, alpha}, 1);
}

float albedo_make_mean_two(const struct albedo_table *t, uint32_t index)
{
    const double ratio =
        fmin(0.9999, fmax(least, square(knot_at(index % ALBEDO_MEAN_RATIOS, ALBEDO_MEAN_RATIOS))));
    const double larger =
        fmax(least, square(knot_at(index / ALBEDO_MEAN_RATIOS, ALBEDO_MEAN_WIDER)));
    return mean(t, (struct facet){(float)larger, (float)(larger * ratio)}, 32);
}
