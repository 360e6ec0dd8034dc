/* The rows of docs/accuracy.md about scattering that scatter.h's laws do not say: widths down to 0,
 * angles down to grazing, albedos by quadrature over facets, nothing that is no number.
 * SPDX-License-Identifier: MIT */
#include <math.h>

#include "common/trace/bsdf.h"
#include "common/trace/microfacet.h"
#include "common/trace/rng.h"
#include "tests/dice.h"
#include "tests/stat/sphere_chart.h"
#include "tests/stat/stat.h"
#include "tests/tap.h"

static const double pi = 3.14159265358979323846;

static struct material diffuse(float albedo)
{
    return (struct material){.kind = MATERIAL_DIFFUSE, .diffuse = {rgb_gray(albedo)}};
}

static struct material mirror(float reflectance)
{
    return (struct material){.kind = MATERIAL_MIRROR, .mirror = {rgb_gray(reflectance)}};
}

static struct material glass(float ior, float alpha)
{
    return (struct material){.kind = MATERIAL_DIELECTRIC,
                             .dielectric = {.ior = ior, .alpha = alpha}};
}

static struct material metal(float eta, float k, float alpha)
{
    return (struct material){.kind = MATERIAL_CONDUCTOR,
                             .conductor = {rgb_gray(eta), rgb_gray(k), alpha}};
}

static vec3 direction(double z)
{
    return vec3_make((float)sqrt(1 - z * z), 0, (float)z);
}

/* --- what is sampled from one direction, in points of the sampler --- */

struct drawn {
    double back, through; /* shares of light: sums of weight / scale */
    double mean[3];       /* of wi, weighted so */
    double most;          /* largest weight / scale */
    uint32_t invalid;     /* values that are negative or no finite numbers */
};

static bool is_valid(const struct material *m, vec3 wo, const struct bsdf_sample *s)
{
    const rgb f = bsdf_eval(m, wo, s->wi);
    const float pdf_w = bsdf_pdf_w(m, wo, s->wi);
    bool good = s->pdf_w >= 0 && isfinite(s->pdf_w) && pdf_w >= 0 && isfinite(pdf_w);
    for (int c = 0; c < 3; c++)
        good &= s->weight[c] >= 0 && isfinite(s->weight[c]) && f[c] >= 0 && isfinite(f[c]);
    return good && fabsf(vec3_length(s->wi) - 1) < 1e-5f;
}

static struct drawn draw(const struct material *m, double z, uint32_t count)
{
    struct drawn d = {0};
    const vec3 wo = direction(z);
    for (uint32_t i = 0; i < count; i++) {
        const struct rng r = rng_make(4, 0, 0, i * FILM_REPLICATES);
        struct bsdf_sample s;
        if (!bsdf_sample(m, wo, rng_single(&r, 1), rng_pair(&r, 0), &s))
            continue;
        const double weight = (double)(s.weight[0] / s.scale);
        d.invalid += !is_valid(m, wo, &s);
        d.most = fmax(d.most, weight);
        *(s.wi[2] * wo[2] > 0 ? &d.back : &d.through) += weight / count;
        for (int k = 0; k < 3; k++)
            d.mean[k] += weight * (double)s.wi[k] / count;
    }
    return d;
}

/* --- F-24: visible facets fill what is seen of the surface --- */

struct seen {
    vec3 o;
    float alpha;
};

/* Facets that reflect downwards count, too; i along -o has none. */
static double visible(const void *what, vec3 i)
{
    const struct seen *s = what;
    const vec3 sum = s->o + i, h = sum / vec3_length(sum);
    return h[2] > 0 ? (double)microfacet_reflect_pdf_w(s->o, h, s->alpha) : 0;
}

static void weak_white_furnace(void)
{
    static const float alpha[] = {.05f, .1f, .25f, .5f, 1};
    static const double z[] = {.05, .1, .3, .6, 1};
    enum { SIDE = 16 };
    double off = 0;
    for (size_t i = 0; i < countof(alpha); i++)
        for (size_t j = 0; j < countof(z); j++) {
            const struct seen seen = {direction(z[j]), alpha[i]};
            const vec3 axis = vec3_make(-seen.o[0], 0, seen.o[2]);
            const struct sphere_chart chart =
                sphere_chart_make(axis, (double)(alpha[i] * alpha[i]));
            const struct sphere_integrand f = {
                .f = visible, .what = &seen, .min_depth = 1, .max_depth = 6, .tolerance = 1e-5};
            double sum = 0;
            for (int k = 0; k < SIDE * SIDE; k++) {
                const double row = k / SIDE, turn = k % SIDE;
                sum += sphere_chart_integral(
                    &chart, &f, (struct sphere_place){row / SIDE, turn / SIDE},
                    (struct sphere_place){(row + 1) / SIDE, (turn + 1) / SIDE});
            }
            off = fmax(off, fabs(sum - 1));
        }
    ok(off < 1e-3, "F-24: GGX's visible facets fill the view, 5 widths, 5 angles (%.1e off)", off);
}

/* --- F-26: rough glass, its albedos by quadrature over facets, in double --- */

struct share {
    double back, through;
};

static double fresnel(double cos, double eta)
{
    const double tt = 1 - (1 - cos * cos) / (eta * eta);
    if (tt <= 0)
        return 1;
    const double t = sqrt(tt), s = (cos - eta * t) / (cos + eta * t),
                 p = (eta * cos - t) / (eta * cos + t);
    return 0.5 * (s * s + p * p);
}

/* Smith's Lambda for GGX. */
static double lambda(double z, double alpha)
{
    return (sqrt(1 + alpha * alpha * (1 / (z * z) - 1)) - 1) / 2;
}

/* What the facet at (s, phi) adds: tan^2 = alpha^2 u / (1 - u) has D(h) h.z even in (u, phi), and
 * u = 1 - s^2 takes away the infinity of 1 / h.z. */
static struct share facet(double o_z, double eta, double alpha, double s, double phi)
{
    const double tan = alpha * sqrt(1 - s * s) / s, h_z = 1 / sqrt(1 + tan * tan);
    const double h_x = tan * h_z * cos(phi), oh = sqrt(1 - o_z * o_z) * h_x + o_z * h_z;
    if (oh <= 0)
        return (struct share){0, 0};
    const double f = fresnel(oh, eta), seen = oh / (o_z * h_z) * 2 * s;
    const double back = 2 * oh * h_z - o_z;
    const double through =
        (oh / eta - sqrt(fmax(0, 1 - (1 - oh * oh) / (eta * eta)))) * h_z - o_z / eta;
    struct share sum = {0, 0};
    if (back > 0)
        sum.back = f * seen / (1 + lambda(o_z, alpha) + lambda(back, alpha));
    if (through < 0)
        sum.through = (1 - f) * seen / ((1 + lambda(o_z, alpha)) * (1 + lambda(-through, alpha)));
    return sum;
}

static struct share by_quadrature(double o_z, double eta, double alpha)
{
    enum { N = 400 };
    struct share sum = {0, 0};
    for (int i = 0; i < N * N; i++) {
        const struct share a = facet(o_z, eta, alpha, (i / N + .5) / N, pi * (i % N + .5) / N);
        sum.back += a.back / (N * N);
        sum.through += a.through / (N * N);
    }
    return sum;
}

static void rough_glass_albedos(void)
{
    static const double z[] = {1, .7, .4, .15}, ior[] = {1.5, 1.15, 2.4}, alpha[] = {.1, .3, 1};
    const uint32_t all = countof(ior) * countof(alpha) * countof(z) * 2;
    const uint32_t step = stat_is_long() ? 1 : 5, count = (1u << 18) / STAT_SLOW;
    double off = 0;
    for (uint32_t i = 0; i < all; i += step) {
        const double n = ior[i / 2 % 3], a = alpha[i / 6 % 3], o_z = z[i / 18];
        const bool inside = i % 2;
        const struct material m = glass((float)n, (float)a);
        const struct share want = by_quadrature(o_z, inside ? 1 / n : n, a);
        const struct drawn got = draw(&m, inside ? -o_z : o_z, count);
        off = fmax(off, fmax(fabs(got.back - want.back), fabs(got.through - want.through)));
    }
    ok(off < (STAT_SLOW == 1 ? 0.002 : 0.02),
       "F-26: rough glass reflects and lets through what quadrature says, %u cases (%.1e off)",
       (all - 1) / step + 1, off);
}

/* --- F-22: a lobe that narrows until it is a mirror --- */

static void narrowing(void)
{
    static const float alpha[] = {1e-1f, 3e-2f, 1e-2f, 3e-3f, BSDF_LEAST_ALPHA,
                                  5e-4f, 1e-4f, 1e-5f};
    const uint32_t count = (1 << 14) / STAT_SLOW;
    double step = 0;
    uint32_t invalid = 0;
    for (int kind = 0; kind < 2; kind++)
        for (int i = 1; i <= 10; i++) {
            const struct material limit = kind ? glass(2, 0) : metal(.2f, 3.9f, 0);
            const struct drawn end = draw(&limit, .1 * i, count);
            for (size_t k = 0; k < countof(alpha); k++) {
                const struct material m = kind ? glass(2, alpha[k]) : metal(.2f, 3.9f, alpha[k]);
                const struct drawn d = draw(&m, .1 * i, count);
                double way = 0;
                for (int c = 0; c < 3; c++)
                    way = hypot(way, d.mean[c] - end.mean[c]);
                if (alpha[k] <= BSDF_LEAST_ALPHA) {
                    step = fmax(step, fmax(fabs(d.back - end.back), fabs(d.through - end.through)));
                    step = fmax(step, way);
                }
                invalid += d.invalid;
            }
        }
    ok(step < (STAT_SLOW == 1 ? 1e-3 : 1e-2),
       "F-22: albedo and mean direction go over into those of alpha 0 (by %.1e)", step);
    ok(invalid == 0, "F-22: alpha 1e-1 to 1e-5 and 0: %u invalid samples", invalid);
}

/* --- F-29: what takes nothing loses and makes nothing --- */

static void lossless(void)
{
    const struct material some[] = {diffuse(1),  mirror(1),   glass(1.5f, 0),
                                    glass(1, 0), glass(4, 0), metal(1, 1e5f, 0)};
    const struct material lossy[] = {metal(1, 1e5f, .1f), metal(1, 1e5f, 1), glass(1.5f, .1f),
                                     glass(1.5f, 1), glass(4, .5f)};
    double least = 1, most = 0, most_lossy = 0, weight = 0;
    for (int i = 1; i <= 64; i++)
        for (size_t k = 0; k < countof(some) + countof(lossy); k++) {
            const bool loses = k >= countof(some);
            const struct material *m = loses ? &lossy[k - countof(some)] : &some[k];
            for (int side = -1; side <= 1; side += 2) {
                const struct drawn d = draw(m, side * i / 64.0, (1 << 12) / STAT_SLOW);
                const double all = d.back + d.through;
                weight = fmax(weight, d.most);
                if (loses) {
                    most_lossy = fmax(most_lossy, all);
                    continue;
                }
                least = fmin(least, all);
                most = fmax(most, all);
            }
        }
    ok(least >= .999 && most <= 1.001,
       "F-29: what takes nothing gives back all, 64 angles (%.6f to %.6f)", least, most);
    ok(most_lossy <= 1.001 && weight <= 1.00001, "F-29: what scatters once gives no more (%.6f)",
       most_lossy);
}

/* --- F-40: grazing --- */

static void grazing(void)
{
    static const float alpha[] = {0, BSDF_LEAST_ALPHA, .01f, .1f, .5f, 1};
    double most = 0;
    uint32_t invalid = 0;
    for (int e = 1; e <= 6; e++)
        for (size_t k = 0; k < countof(alpha); k++) {
            const struct material some[] = {metal(.2f, 3.9f, alpha[k]), metal(1, 1e5f, alpha[k]),
                                            glass(1.5f, alpha[k]), diffuse(1)};
            for (size_t m = 0; m < 2 * countof(some); m++) {
                const double z = (m % 2 ? -1 : 1) * pow(10, -e);
                const struct drawn d = draw(&some[m / 2], z, stat_tries(1 << 12, 1 << 18));
                most = fmax(most, d.most);
                invalid += d.invalid;
            }
        }
    ok(invalid == 0, "F-40: seen at cosines 1e-1 to 1e-6: %u invalid samples", invalid);
    ok(most <= 1.00001, "F-40: all weights in [0, 1] (%.7f at most)", most);
}

/* --- F-20: no random number makes what is no number --- */

static void random_numbers(void)
{
    const struct material some[] = {diffuse(1),
                                    mirror(1),
                                    glass(1.5f, 0),
                                    glass(1.5f, 1),
                                    glass(4, .05f),
                                    glass(1 + 0x1p-9f, .6f),
                                    metal(1, 0, .3f),
                                    metal(.2f, 3.9f, 0),
                                    metal(.2f, 3.9f, .05f),
                                    metal(1, 1e5f, 1),
                                    metal(.2f, 3.9f, BSDF_LEAST_ALPHA)};
    const uint32_t count = stat_tries(4000000, 1000000000);
    struct dice dice = dice_make(20);
    uint32_t bad = 0;
    for (uint32_t i = 0; i < count; i++) {
        const struct material *m = &some[i % countof(some)];
        const double z =
            dice_bits(&dice) % 4 ? dice_range(&dice, -1, 1) : pow(10, -6 * dice_unit(&dice));
        struct square q;
        q.u = dice_float(&dice);
        q.v = dice_float(&dice);
        struct bsdf_sample s;
        if (bsdf_sample(m, direction(z), dice_float(&dice), q, &s))
            bad += !is_valid(m, direction(z), &s);
    }
    ok(bad == 0, "F-20: of %u random samples of %zu materials %u are invalid", count, countof(some),
       bad);
}

int main(void)
{
    weak_white_furnace();
    rough_glass_albedos();
    narrowing();
    lossless();
    grazing();
    random_numbers();
    return tap_done();
}
