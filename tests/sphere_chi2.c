/* SPDX-License-Identifier: MIT */
#include "tests/sphere_chi2.h"

#include <math.h>
#include <stdlib.h>

#include "common/arena.h"
#include "tests/dice.h"
#include "tests/stat.h"

enum { ROWS = 51, COLUMNS = 102, CELLS = ROWS * COLUMNS };
enum { MAX_DEPTH = STAT_SLOW == 1 ? 6 : 4 }; /* fewer samples need no finer expectation */

static const double pi = 3.14159265358979323846;

static double pdf_at(const struct sphere_chi2 *t, double z, double phi)
{
    const double r = sqrt(fmax(0, 1 - z * z));
    const vec3 w = vec3_make((float)(r * cos(phi)), (float)(r * sin(phi)), (float)z);
    return (double)t->pdf_w(t->what, w);
}

/* 3 x 3 Gauss-Legendre points. */
static double gauss(const struct sphere_chi2 *t, double z, double dz, double phi, double dphi)
{
    static const double x[3] = {0.1127016653792583, 0.5, 0.8872983346207417};
    static const double w[3] = {5. / 18, 8. / 18, 5. / 18};
    double sum = 0;
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            sum += w[i] * w[j] * pdf_at(t, z + x[i] * dz, phi + x[j] * dphi);
    return sum * dz * dphi;
}

static double integrate(const struct sphere_chi2 *t, double z, double dz, double phi, double dphi,
                        double whole, int depth)
{
    const double hz = dz / 2, hp = dphi / 2;
    double part[4], sum = 0;
    for (int i = 0; i < 4; i++)
        sum += part[i] = gauss(t, z + (i & 1 ? hz : 0), hz, phi + (i & 2 ? hp : 0), hp);
    if (depth == MAX_DEPTH || (depth >= t->min_depth && fabs(sum - whole) < 1e-8 + 1e-6 * sum))
        return sum;
    sum = 0;
    for (int i = 0; i < 4; i++)
        sum +=
            integrate(t, z + (i & 1 ? hz : 0), hz, phi + (i & 2 ? hp : 0), hp, part[i], depth + 1);
    return sum;
}

static size_t cell_of(vec3 w)
{
    const double z = fmin(fmax(((double)w[2] + 1) / 2, 0), 1);
    const double phi = atan2((double)w[1], (double)w[0]) / (2 * pi);
    const int row = (int)fmin(z * ROWS, ROWS - 1);
    const int column = (int)fmin((phi < 0 ? phi + 1 : phi) * COLUMNS, COLUMNS - 1);
    return (size_t)(row * COLUMNS + column);
}

struct sphere_chi2_result sphere_chi2_run(const struct sphere_chi2 *t, uint32_t samples,
                                          uint64_t seed)
{
    struct arena arena = {0};
    double *expected = arena_new(&arena, double, CELLS);
    uint32_t *observed = arena_new(&arena, uint32_t, CELLS);
    struct sphere_chi2_result r = {0};
    struct dice dice = dice_make(seed);
    uint32_t away = 0;
    for (uint32_t i = 0; i < samples; i++) {
        struct square q;
        q.u = dice_float(&dice);
        q.v = dice_float(&dice);
        vec3 w;
        float pdf_w;
        if (!t->sample(t->what, q, &w, &pdf_w)) {
            away++;
            continue;
        }
        observed[cell_of(w)]++;
        if (t->pdf_most > 0 && pdf_w > t->pdf_most)
            continue;
        const double asked = (double)t->pdf_w(t->what, w);
        r.pdf_off = fmax(r.pdf_off, fabs((double)pdf_w / asked - 1));
    }
    double mass = 0;
    for (int i = 0; i < CELLS; i++) {
        const double z = -1 + 2.0 * (i / COLUMNS) / ROWS, dz = 2.0 / ROWS;
        const double phi = 2 * pi * (i % COLUMNS) / COLUMNS, dphi = 2 * pi / COLUMNS;
        const double whole = gauss(t, z, dz, phi, dphi);
        if (whole == 0 && observed[i] == 0)
            continue;
        const double in_cell = integrate(t, z, dz, phi, dphi, whole, 0);
        mass += in_cell;
        expected[i] = in_cell * samples;
    }
    r.p = stat_chi2_test(expected, observed, CELLS);
    const double share = (double)away / samples;
    r.mass_off = mass - 1 + share;
    r.mass_sd = sqrt(share * (1 - share) / samples);
    arena_release(&arena);
    return r;
}
