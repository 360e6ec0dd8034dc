/* SPDX-License-Identifier: MIT */
#include "tests/ggx_albedo.h"

#include <math.h>

static const double pi = 3.14159265358979323846;

struct dir {
    double x, y, z;
};

static double dot(struct dir a, struct dir b)
{
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

static struct dir unit(double x, double y, double z)
{
    const double l = sqrt(x * x + y * y + z * z);
    return (struct dir){x / l, y / l, z / l};
}

/* Smith's Lambda, E. Heitz 2014, eq. 72 with the width along w's azimuth (section 5.4). */
static double lambda(const struct ggx_albedo *a, struct dir w)
{
    const double tangent = (a->x * a->x * w.x * w.x + a->y * a->y * w.y * w.y) / (w.z * w.z);
    return (sqrt(1 + tangent) - 1) / 2;
}

static struct dir from(const struct ggx_albedo *a)
{
    const double sine = sqrt(fmax(0, 1 - a->cos * a->cos));
    return (struct dir){sine * cos(a->phi), sine * sin(a->phi), a->cos};
}

/* The facet that place (u, 1 - v) of the square stands for (J. Dupuy, A. Benyoub 2023). */
static struct dir visible(const struct ggx_albedo *a, struct dir o, double u, double v)
{
    const struct dir s = unit(a->x * o.x, a->y * o.y, o.z);
    const double z = v * (1 + s.z) - s.z, sine = sqrt(fmax(0, 1 - z * z));
    return unit(a->x * (sine * cos(2 * pi * u) + s.x), a->y * (sine * sin(2 * pi * u) + s.y),
                z + s.z);
}

double ggx_albedo(const struct ggx_albedo *a, uint32_t n)
{
    const struct dir o = from(a);
    const double lo = lambda(a, o);
    double sum = 0;
    for (uint32_t i = 0; i < n; i++)
        for (uint32_t k = 0; k < n; k++) {
            const double t = (k + .5) / n, tt = t * t; /* v = 1 - t^4: few facets are steep */
            const struct dir m = visible(a, o, (i + .5) / n, tt * tt);
            const double d = 2 * dot(o, m);
            const struct dir r = {d * m.x - o.x, d * m.y - o.y, d * m.z - o.z};
            if (r.z > 0)
                sum += 4 * tt * t * (1 + lo) / (1 + lo + lambda(a, r));
        }
    return sum / n / n;
}

double ggx_albedo_weak(const struct ggx_albedo *a, uint32_t n)
{
    const struct dir o = from(a);
    const double g1 = 1 / (1 + lambda(a, o));
    /* dw_i = 4 (o.m) dw_m: over the normals m, in the slopes' polar coordinates tan = r / (1 - r)
     */
    double sum = 0;
    for (uint32_t i = 0; i < n; i++)
        for (uint32_t k = 0; k < n; k++) {
            const double r = (i + .5) / n, phi = 2 * pi * (k + .5) / n, slope = r / (1 - r);
            const struct dir m = unit(-a->x * slope * cos(phi), -a->y * slope * sin(phi), 1);
            /* D dw_m, projected: P(slopes) d slopes, P = 1 / (pi ax ay (1 + slope^2)^2) */
            const double weight = slope / ((1 - r) * (1 - r)) * 2 / pow(1 + slope * slope, 2);
            const double visible_area = fmax(0, dot(o, m)) / m.z;
            sum += weight * visible_area * g1 / o.z / n / n;
        }
    return sum;
}
