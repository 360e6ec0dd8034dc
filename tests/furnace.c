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

/* What a lattice cannot decide is looked at again by a longer one. */
double furnace_returned(const struct material *m, vec3 wo)
{
    double returned = lattice(m, wo, 1 << 14);
    bool sure = returned > .982 && returned < .999;
    for (int log = 17; !sure && log <= 20; log += 3) {
        returned = lattice(m, wo, 1u << log);
        sure = returned > .98 && returned < 1.001;
    }
    return returned;
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
