/* SPDX-License-Identifier: MIT */
#include "tests/stack_make.h"

#include <math.h>
#include <string.h>

static const double pi = 3.14159265358979323846;

enum { STEPS = 128 };

struct view { /* of a lobe from the direction (x, 0, z) */
    double width, x, z;
    bool grazing;
    double *cells;
};

/* Light of a weight goes to the cosine i: the part of each cell between i and z. */
static void cover(const struct view *v, double i, double weight)
{
    const double low = sqrt(i) * STACK_CELLS, high = sqrt(v->z) * STACK_CELLS;
    if (i > 0 && i < v->z)
        for (int j = (int)low; j < STACK_CELLS && j < high; j++)
            v->cells[j] += weight * (fmin(high, j + 1) - fmax(low, j));
}

static double s_of(double z, double alpha)
{
    return sqrt(alpha * alpha + (1 - alpha * alpha) * z * z);
}

/* One half of each turn, the caps of microfacet_visible. */
static void facets(const struct view *v)
{
    const double alpha = v->width, wx = v->x * alpha, length = hypot(wx, v->z);
    const double cap = 1 + v->z / length, s = s_of(v->z, alpha);
    for (int k = 0; k < STEPS * STEPS; k++) {
        const double t = (k / STEPS + 0.5) / STEPS, phi = pi * (k % STEPS + 0.5) / STEPS;
        const double r = sqrt(t * cap * (2 - t * cap)), hz = cap * (1 - t);
        const double hx = (wx / length + r * cos(phi)) * alpha, hy = r * sin(phi) * alpha;
        const double size = sqrt(hx * hx + hy * hy + hz * hz);
        const double c = fmin(1, (v->x * hx + v->z * hz) / size), i = 2 * c * hz / size - v->z;
        if (i > 0)
            cover(v, i,
                  (v->grazing ? pow(1 - c, 5) : 1) * i * (v->z + s) /
                      (v->z * s_of(i, alpha) + i * s) / (STEPS * STEPS));
    }
}

/* What a fibre, or the one across, returns of what it is seen of. */
static void fibre(const struct view *v, double hx, double hz, double share)
{
    const double c = v->x * hx + v->z * hz, i = 2 * c * hz - v->z;
    if (c > 0 && i > 0)
        cover(v, i, share * c * fmin(1, 2 * hz * fmin(v->z, i) / c) / fmin(1, 2 * hz * v->z / c));
}

static void fibres(const struct view *v)
{
    const double k = 1 / (v->width * v->width);
    for (int a = 0; a < STEPS; a++) {
        const double sine = pow((a + 0.5) / STEPS, 1 / (k + 2)), hz = sqrt(1 - sine * sine);
        for (int b = 0; b < STEPS; b++) {
            const double hx = sine * cos(pi * (b + 0.5) / STEPS);
            const double both = fmax(0, v->x * hx + v->z * hz) + fmax(0, v->z * hz - v->x * hx);
            fibre(v, hx, hz, 1 / (both * STEPS * STEPS));
            fibre(v, -hx, hz, 1 / (both * STEPS * STEPS));
        }
    }
}

void stack_make_row(enum stack_lobe lobe, int width, int cosine, uint16_t row[STACK_CELLS])
{
    double cells[STACK_CELLS] = {0};
    const double w = (double)width / (STACK_WIDTHS - 1);
    const double root = fmax(1e-3, (double)cosine / (STACK_COSINES - 1)), z = root * root;
    const struct view v = {lobe == STACK_FIBRES ? 0.1 + 0.9 * w : w * w, sqrt(1 - z * z), z,
                           lobe == STACK_GRAZING, cells};
    if (lobe == STACK_FIBRES)
        fibres(&v);
    else if (width > 0)
        facets(&v);
    for (int j = 0; j < STACK_CELLS; j++)
        row[j] = (uint16_t)lround(65535 * fmin(1, cells[j]));
}
