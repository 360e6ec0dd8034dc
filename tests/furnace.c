/* SPDX-License-Identifier: MIT */
#include "tests/furnace.h"

#include <math.h>

#include "common/trace/bsdf.h"

static float fraction(double x)
{
    const float f = (float)(x - floor(x));
    return f < 1 ? f : 0;
}

/* A Kronecker sequence, its steps the powers of 1 / g, g^4 = g + 1. */
static double lattice(const struct material *m, vec3 wo, uint32_t count)
{
    const double g = 1.2207440846057596;
    double sum = 0;
    for (uint32_t i = 1; i <= count; i++) {
        struct bsdf_sample s = {.scale = 1};
        struct square q;
        q.u = fraction(i / g);
        q.v = fraction(i / (g * g));
        if (bsdf_sample(m, wo, fraction(i / (g * g * g)), q, &s))
            sum += (double)(s.weight[0] / s.scale);
    }
    return sum / count;
}

/* What the short lattice cannot decide is looked at again. */
double furnace_returned(const struct material *m, vec3 wo)
{
    const double roughly = lattice(m, wo, 1 << 14);
    return roughly > .982 && roughly < .999 ? roughly : lattice(m, wo, 1 << 16);
}

void furnace_add(struct furnace *f, double returned)
{
    f->least = fmin(f->least, returned);
    f->most = fmax(f->most, returned);
}

bool furnace_is_white(const struct furnace *f)
{
    return f->least > .98 && f->most < 1.001;
}

float furnace_parameter(struct dice *d, double least)
{
    const double x = dice_range(d, -0.3, 1.3);
    return (float)fmin(1, fmax(least, x));
}
