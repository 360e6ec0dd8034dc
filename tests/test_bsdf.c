/* bsdf.h, fresnel.h, microfacet.h: known values, corners, and weights from any direction. That
 * samples follow their pdf, energy and reciprocity: test_materials.c.
 * SPDX-License-Identifier: MIT */
#include "common/trace/bsdf.h"

#include <math.h>

#include "common/trace/fresnel.h"
#include "common/trace/microfacet.h"
#include "common/trace/rng.h"
#include "tests/dice.h"
#include "tests/stat/stat.h"
#include "tests/tap.h"

static const double pi = 3.14159265358979323846;

static struct material diffuse(float albedo)
{
    return (struct material){.kind = MATERIAL_DIFFUSE, .diffuse = {rgb_gray(albedo)}};
}

static struct material glass(float ior)
{
    return (struct material){.kind = MATERIAL_DIELECTRIC, .dielectric = {.ior = ior}};
}

static struct material frosted(float ior, float alpha)
{
    return (struct material){.kind = MATERIAL_DIELECTRIC,
                             .dielectric = {.ior = ior, .alpha = alpha}};
}

static struct material metal(float eta, float k, float alpha)
{
    return (struct material){.kind = MATERIAL_CONDUCTOR,
                             .conductor = {rgb_gray(eta), rgb_gray(k), alpha}};
}

/* Reflects everything: Fresnel's F is 1 less 4e-10. */
static struct material silver(float alpha)
{
    return metal(1, 1e5f, alpha);
}

static vec3 direction(double z, double phi)
{
    const double r = sqrt(1 - z * z);
    return vec3_make((float)(r * cos(phi)), (float)(r * sin(phi)), (float)z);
}

/* --- weight is eval / pdf, and no more than 1 --- */

static void weights_agree(struct material m, double tolerance, const char *name)
{
    struct dice dice = dice_make(11);
    double off = 0, most = 0;
    for (int i = 0; i < 200000 / STAT_SLOW; i++) {
        const double z = dice_range(&dice, -1, 1), phi = dice_range(&dice, 0, 6);
        struct square q;
        q.u = dice_float(&dice);
        q.v = dice_float(&dice);
        const vec3 wo = direction(z, phi);
        struct bsdf_sample s;
        if (!bsdf_sample(&m, wo, 0, q, &s) || fabsf(s.wi[2]) < 1e-4f)
            continue;
        most = fmax(most, (double)rgb_max(s.weight));
        const rgb f = bsdf_eval(&m, wo, s.wi);
        off = fmax(off, fabs((double)f[1] / ((double)s.weight[1] * (double)s.pdf_w) - 1));
    }
    ok(off < tolerance, "%s: weight x pdf is eval (%.1e)", name, off);
    ok(most <= 1.000001, "%s: no weight above 1", name);
}

/* --- known values --- */

static void fresnel_values(void)
{
    float t;
    const double f45 = 0.5 * (.0920133630 * .0920133630 + .3033370453 * .3033370453);
    const double f10 = 0.5 * (.1904679720 * .1904679720 + .2094943196 * .2094943196);
    near((double)fresnel_dielectric((float)cos(pi / 4), 1.5f, &t), f45, 1e-7,
         "A-10: glass at 45 degrees");
    near((double)fresnel_dielectric((float)cos(pi / 18), 1 / 1.5f, &t), f10, 1e-7,
         "A-10: out of glass at 10 degrees");
    near((double)fresnel_dielectric(1, 1.5f, &t), 0.04, 1e-8, "glass from above");
    ok(fresnel_dielectric(0.7f, 1 / 1.5f, &t) == 1 && t == 0, "total reflection");
    ok(fresnel_dielectric(0, 1, &t) == 0 && fresnel_dielectric(1e-20f, 1, &t) == 0 && t == 1e-20f,
       "equal indices pass at any angle");

    double out = 0, in = 0;
    for (int i = 0; i < 100000; i++) { /* 2 cos d(cos) */
        const float c = ((float)i + 0.5f) / 100000;
        out += (double)(fresnel_dielectric(c, 1.5f, &t) * 2 * c) / 100000;
        in += (double)(fresnel_dielectric(c, 1 / 1.5f, &t) * 2 * c) / 100000;
    }
    near(out, .091777959, 1e-6, "A-10: average over the hemisphere is Duntley's");
    near(in, .596345760, 1e-5, "A-10: and inside 1 - (1 - F) / n^2");

    near((double)fresnel_conductor_channel(1, .2f, 3.9f), .951951952, 1e-6,
         "A-11: metal at 0 degrees");
    near((double)fresnel_conductor_channel(.5f, .2f, 3.9f), .945882382, 1e-6,
         "A-11: metal at 60 degrees");
    near((double)fresnel_conductor_channel((float)cos(89 * pi / 180), .2f, 3.9f), .992486811, 1e-6,
         "A-11: metal at 89 degrees");
    double off = 0;
    for (int i = 0; i <= 1000; i++) {
        const float c = (float)i / 1000;
        off = fmax(off, (double)fabsf(fresnel_conductor_channel(c, 1.5f, 0) -
                                      fresnel_dielectric(c, 1.5f, &t)));
    }
    ok(off < 1e-6, "A-11: a metal that does not absorb is a dielectric (%.1e)", off);
}

static double albedo(const struct material *m, double z)
{
    const uint32_t n = 1 << 14;
    double sum = 0;
    for (uint32_t i = 0; i < n; i++) {
        const struct rng r = rng_make(1, 0, 0, i * FILM_REPLICATES);
        struct bsdf_sample s;
        if (bsdf_sample(m, direction(z, 0.3), 0, rng_pair(&r, 0), &s))
            sum += (double)s.weight[0] / n;
    }
    return sum;
}

/* Single-scattering albedo of GGX with F = 1: rows alpha, columns cos; values by quadrature. */
static void ggx_albedos(void)
{
    static const double alpha[] = {.1, .25, .5, .75, 1}, z[] = {.1, .3, .5, .8, 1};
    static const double table[5][5] = {{.8835, .9363, .9692, .9846, .9883},
                                       {.8916, .8379, .8573, .8973, .9158},
                                       {.8601, .7453, .6983, .6821, .6879},
                                       {.8107, .6503, .5646, .4923, .4639},
                                       {.7602, .5601, .4507, .3513, .3069}};
    double off = 0;
    for (size_t i = 0; i < countof(z); i++)
        for (size_t j = 0; j < countof(alpha); j++) {
            const struct material m = silver((float)alpha[j]);
            off = fmax(off, fabs(albedo(&m, z[i]) - table[j][i]));
        }
    ok(off < 0.002, "A-14, F-23: GGX albedos are those of height-correlated masking (%.4f off)",
       off);
}

static void narrow_lobe_meets_mirror(void)
{
    double off = 0;
    for (int i = 1; i <= 20; i++) {
        const struct material lobe = metal(.2f, 3.9f, BSDF_LEAST_ALPHA);
        const struct material delta = metal(.2f, 3.9f, 0.99f * BSDF_LEAST_ALPHA);
        off = fmax(off, fabs(albedo(&lobe, i / 20.0) - albedo(&delta, i / 20.0)));
    }
    ok(off < 1e-3, "F-22: albedo is continuous where the lobe becomes a mirror (%.1e)", off);
    const struct material delta = metal(.2f, 3.9f, 0);
    ok(bsdf_is_delta(&delta) && !bsdf_is_delta(&(struct material){.kind = MATERIAL_DIFFUSE}),
       "only the mirror is delta");
}

/* --- corners: no NaN whatever the numbers --- */

static const float edge[] = {0, 0x1p-24f, 0.25f, 0.5f, 0.75f, 1 - 0x1p-23f, 1 - 0x1p-24f};

static bool sample_is_finite(const struct material *m, vec3 wo, float lobe, struct square q)
{
    struct bsdf_sample s;
    if (!bsdf_sample(m, wo, lobe, q, &s))
        return true;
    const rgb f = bsdf_eval(m, wo, s.wi);
    bool good = s.pdf_w >= 0 && isfinite(s.pdf_w) && isfinite(bsdf_pdf_w(m, wo, s.wi));
    for (int c = 0; c < 3; c++)
        good &= s.weight[c] >= 0 && isfinite(s.weight[c]) && f[c] >= 0 && isfinite(f[c]);
    return good && fabsf(vec3_length(s.wi) - 1) < 1e-5f;
}

static void corners_are_finite(void)
{
    const struct material some[] = {diffuse(1),
                                    glass(1),
                                    glass(1.5f),
                                    glass(4),
                                    frosted(1.5f, 1),
                                    frosted(1 + 0x1p-9f, .6f),
                                    frosted(1.5f, .05f),
                                    frosted(1.5f, 2 * BSDF_LEAST_ALPHA),
                                    frosted(4, BSDF_LEAST_ALPHA),
                                    silver(1),
                                    metal(1, 0, .3f),
                                    metal(.2f, 3.9f, BSDF_LEAST_ALPHA),
                                    metal(.2f, 3.9f, .05f),
                                    metal(.2f, 3.9f, 0)};
    static const double z[] = {1, 0.999999, 0.5, 1e-3, 1e-6, 1e-12, 1e-25, -1e-6, -0.3, -1, 0};
    int bad = 0;
    for (size_t m = 0; m < countof(some); m++)
        for (size_t d = 0; d < countof(z); d++)
            for (size_t n = 0; n < countof(edge) * countof(edge) * countof(edge); n++) {
                const struct square q = {edge[n % 7], edge[n / 7 % 7]};
                bad += !sample_is_finite(&some[m], direction(z[d], 0.1), edge[n / 49], q);
            }
    ok(bad == 0, "F-20: corners of the unit cube at all angles give finite samples (%d bad)", bad);
}

/* Below the least width, and where nothing is bent, rough glass is the smooth one to the bit. */
static void hardly_rough_is_smooth(void)
{
    const struct material some[][2] = {{glass(1.5f), frosted(1.5f, .99f * BSDF_LEAST_ALPHA)},
                                       {glass(4), frosted(4, .99f * BSDF_LEAST_ALPHA)},
                                       {glass(1), frosted(1, 1)},
                                       {glass(1 + 0x1p-12f), frosted(1 + 0x1p-12f, 1)}};
    struct dice dice = dice_make(3);
    bool same = true;
    for (int i = 0; i < 4000; i++) {
        const struct material *pair = some[i % 4];
        const vec3 wo = direction(dice_range(&dice, -1, 1), dice_range(&dice, 0, 6));
        const float lobe = dice_float(&dice);
        const struct square q = {lobe, lobe};
        struct bsdf_sample a, b;
        same &= bsdf_sample(&pair[0], wo, lobe, q, &a) && bsdf_sample(&pair[1], wo, lobe, q, &b);
        for (int c = 0; c < 3; c++)
            same &= a.wi[c] == b.wi[c] && a.weight[c] == b.weight[c];
        same &= a.scale == b.scale && a.pdf_w == 0 && b.pdf_w == 0;
        same &= bsdf_is_delta(&pair[1]) && bsdf_pdf_w(&pair[1], wo, b.wi) == 0;
    }
    ok(same, "glass too smooth for a lobe, or that bends nothing, is smooth glass");
    ok(!bsdf_is_delta(&(struct material){.kind = MATERIAL_DIELECTRIC,
                                         .dielectric = {.ior = 2, .alpha = .01f}}),
       "other glass is not");
}

static void straight_through(void)
{
    const struct material m = glass(1);
    bool same = true;
    for (int i = 0; i < 200; i++) {
        const vec3 wo = direction((i - 100.5) / 101, 1);
        struct bsdf_sample s;
        same &= bsdf_sample(&m, wo, 0, (struct square){0, 0}, &s);
        same &= s.wi[0] == -wo[0] && s.wi[1] == -wo[1] && s.wi[2] == -wo[2] && s.weight[0] == 1;
    }
    ok(same, "glass of index 1 is not there");
}

int main(void)
{
    weights_agree(diffuse(0.5f), 1e-5, "diffuse");
    weights_agree(silver(BSDF_LEAST_ALPHA), 1e-4, "GGX least");
    weights_agree(metal(.2f, 3.9f, .01f), 1e-4, "GGX .01");
    weights_agree(metal(1.5f, .5f, .3f), 1e-4, "GGX .3");
    fresnel_values();
    ggx_albedos();
    narrow_lobe_meets_mirror();
    corners_are_finite();
    hardly_rough_is_smooth();
    straight_through();
    return tap_done();
}
