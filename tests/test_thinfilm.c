/* thinfilm.h: a film on metal against the transfer matrices of layered media in double, its weights
 * against the colour matching functions they are made of, and where it ends; as a material it obeys
 * the laws of scattering.
 * SPDX-License-Identifier: MIT */
#include "common/trace/thinfilm.h"

#include <complex.h>
#include <math.h>

#include "common/trace/fresnel.h"
#include "tests/dice.h"
#include "tests/stat/laws.h"
#include "tests/tap.h"

static const double pi = 3.14159265358979323846;

/* --- the weights --- */

static double lobe(double l, double height, double middle, double below, double above)
{
    const double t = (l - middle) / (l < middle ? below : above);
    return height * exp(-t * t / 2);
}

static double wavelength(int i)
{
    return 1 / (1 / 700.0 + (1 / 400.0 - 1 / 700.0) * (i + .5) / THINFILM_WAVELENGTHS);
}

static void weights_are_made(void)
{
    static const double rgb_of[3][3] = {{3.2404542, -1.5371385, -.4985314},
                                        {-.9692660, 1.8760108, .0415560},
                                        {.0556434, -.2040259, 1.0572252}};
    double made[3][THINFILM_WAVELENGTHS], sum[3] = {0, 0, 0}, off = 0, whole = 0;
    for (int i = 0; i < THINFILM_WAVELENGTHS; i++) {
        const double l = wavelength(i);
        const double xyz[3] = {lobe(l, 1.056, 599.8, 37.9, 31.0) + lobe(l, .362, 442, 16, 26.7) +
                                   lobe(l, -.065, 501.1, 20.4, 26.2),
                               lobe(l, .821, 568.8, 46.9, 40.5) + lobe(l, .286, 530.9, 16.3, 31.1),
                               lobe(l, 1.217, 437, 11.8, 36) + lobe(l, .681, 459, 26, 13.8)};
        for (int c = 0; c < 3; c++) {
            made[c][i] = l * l * /* nm for each step of 1 / nm */
                         (rgb_of[c][0] * xyz[0] + rgb_of[c][1] * xyz[1] + rgb_of[c][2] * xyz[2]);
            sum[c] += made[c][i];
        }
    }
    for (int c = 0; c < 3; c++) {
        double all = 0;
        for (int i = 0; i < THINFILM_WAVELENGTHS; i++) {
            off = fmax(off, fabs((double)thinfilm_weight[c][i] - made[c][i] / sum[c]));
            all += (double)thinfilm_weight[c][i];
        }
        whole = fmax(whole, fabs(all - 1));
    }
    ok(off < 1e-6 && whole < 1e-6, "weights are the matching functions' through Rec. 709 (%.1e)",
       off);
}

/* --- the law --- */

/* R of a layer of index n2 and thickness d on a metal of index n3, by its characteristic matrix
 * (Born and Wolf, section 1.6). */
static double layered(double cos1, double n2, double d, double complex n3, double l, bool p)
{
    const double ss = 1 - cos1 * cos1;
    const double complex k2 = csqrt(n2 * n2 - ss), k3 = csqrt(n3 * n3 - ss);
    const double complex y1 = p ? 1 / cos1 : cos1, y2 = p ? n2 * n2 / k2 : k2;
    const double complex y3 = p ? n3 * n3 / k3 : k3, beta = 2 * pi * d * k2 / l;
    const double complex b = ccos(beta) - (double complex)I * csin(beta) * y3 / y2;
    const double complex c = ccos(beta) * y3 - (double complex)I * csin(beta) * y2;
    const double complex r = (y1 * b - c) / (y1 * b + c);
    return creal(r * conj(r));
}

static double channel(int c, double cos1, const struct thin_film *f, double complex n3)
{
    double sum = 0;
    for (int i = 0; i < THINFILM_WAVELENGTHS; i++)
        for (int p = 0; p < 2; p++)
            sum += (double)thinfilm_weight[c][i] / 2 *
                   layered(cos1, (double)f->ior, (double)f->thickness_nm, n3, wavelength(i), p);
    return fmin(1, fmax(0, sum));
}

static const rgb eta = {.2f, .9f, 1.1f, 0}, k = {3.9f, 2.4f, 2.2f, 0};

static void airy_is_layered(void)
{
    struct dice dice = dice_make(1);
    double off = 0;
    for (int i = 0; i < 3000; i++) {
        const struct thin_film f = {(float)dice_range(&dice, 0, 2000),
                                    (float)dice_range(&dice, 1.01, 4)};
        const double cos1 = dice_range(&dice, .001, 1);
        const rgb r = thinfilm_metal((float)cos1, eta, k, &f);
        for (int c = 0; c < 3; c++)
            off = fmax(off, fabs((double)r[c] -
                                 channel(c, (double)(float)cos1, &f,
                                         (double)eta[c] + (double complex)I * (double)k[c])));
    }
    ok(off < 1e-4, "reflectances are those of layered media, 3000 films (%.1e)", off);
}

static void ends(void)
{
    struct dice dice = dice_make(2);
    double off = 0;
    bool good = true;
    for (int i = 0; i < 20000; i++) {
        const struct thin_film none = {0, (float)dice_range(&dice, 1.001, 4)};
        const struct thin_film some = {(float)dice_range(&dice, 0, 2000), none.ior};
        const float cos = i % 100 ? dice_float(&dice) : (float)(i / 100 % 2);
        const rgb bare = fresnel_conductor(cos, eta, k), r = thinfilm_metal(cos, eta, k, &none);
        const rgb thick = thinfilm_metal(cos, rgb_gray(dice_float(&dice) + .001f),
                                         rgb_gray(100 * dice_float(&dice)), &some);
        for (int c = 0; c < 3; c++) {
            off = fmax(off, fabs((double)(r[c] - bare[c])));
            good &= thick[c] >= 0 && thick[c] <= 1;
        }
    }
    ok(off < 1e-5, "a film without thickness is the bare metal (%.1e)", off);
    ok(good, "any film on any metal reflects from 0 to 1, straight on and grazing, too");
    const struct thin_film f = {350, 1.5f};
    const rgb above = thinfilm_metal(1, eta, k, &f), aside = thinfilm_metal(.4f, eta, k, &f);
    ok(above[0] / above[2] > 1.5f * aside[0] / aside[2] ||
           aside[0] / aside[2] > 1.5f * above[0] / above[2],
       "the colour shifts: red over blue %.2f straight on, %.2f from 66 degrees",
       (double)(above[0] / above[2]), (double)(aside[0] / aside[2]));
}

static void laws(void)
{
    struct material m = {.kind = MATERIAL_METAL,
                         .metal = {.eta = eta,
                                   .k = k,
                                   .alpha_x = .3f,
                                   .alpha_y = .3f,
                                   .turn_cos = 1,
                                   .film = {350, 1.5f}}};
    laws_begin(2);
    laws_obeyed(&m, "lacquer .3");
    m.metal.alpha_y = .1f;
    m.metal.multiscatter = true;
    m.metal.film.thickness_nm = 2000;
    laws_obeyed(&m, "whole lacquer .3 x .1");
}

int main(void)
{
    weights_are_made();
    airy_is_layered();
    ends();
    laws();
    return tap_done();
}
