/* Mirrors, metals and glass, over their range of roughness: the laws of scattering (stat/laws.h).
 * What is diffuse, and layers: test_coats.c.
 * SPDX-License-Identifier: MIT */
#include "common/trace/bsdf.h"

#include <math.h>

#include "tests/stat/laws.h"
#include "tests/stat/scatter.h"
#include "tests/stat/stat.h"
#include "tests/tap.h"

/* --- single directions: no statistics, the law itself --- */

/* R of unpolarised light by the angles, Snell's law and Fresnel's sine and tangent laws. */
static double fresnel_by_angles(double cos_i, double eta)
{
    const double i = acos(cos_i), sin_t = sin(i) / eta;
    if (sin_t >= 1)
        return 1;
    const double t = asin(sin_t);
    if (i + t < 1e-6)
        return (eta - 1) * (eta - 1) / ((eta + 1) * (eta + 1));
    const double s = sin(i - t) / sin(i + t), p = tan(i - t) / tan(i + t);
    return 0.5 * (s * s + p * p);
}

struct off {
    double law, way; /* share and direction */
    double back;     /* of the way back, times cos / n^2 */
};

/* Refracted: there and back is the same way, with the same share, once radiance's n^2 is taken out.
 */
static double way_back(const struct scatter *s, vec3 wo, const struct scatter_choice *there)
{
    struct scatter_choice c[2];
    const int n = scatter_choices(s, there->sample.wi, c);
    double off = 1;
    for (int i = 0; i < n; i++) {
        const double share =
            there->chance * (double)(there->sample.weight[0] / there->sample.scale);
        const double again = c[i].chance * (double)(c[i].sample.weight[0] / c[i].sample.scale);
        off = fmin(off, (double)vec3_length(c[i].sample.wi - wo) + fabs(share - again));
    }
    return off;
}

static void judge_glass(double ior, const struct laws_view *d, struct off *off)
{
    const struct material m = {.kind = MATERIAL_DIELECTRIC, .dielectric = {.ior = (float)ior}};
    const struct scatter s = scatter_of(&m);
    const vec3 wo = laws_direction(d);
    const double eta = d->cos > 0 ? ior : 1 / ior, f = fresnel_by_angles(fabs((double)wo[2]), eta);
    struct scatter_choice c[2];
    const int n = scatter_choices(&s, wo, c);
    double all = 0, reflected = 0;
    for (int i = 0; i < n; i++) {
        const vec3 wi = c[i].sample.wi;
        const bool through = wi[2] * wo[2] < 0;
        const double share = c[i].chance * (double)(c[i].sample.weight[1] / c[i].sample.scale);
        all += share;
        reflected += through ? 0 : share;
        const double k = through ? 1 / eta : 1; /* Snell: what lies in the surface is scaled */
        off->way = fmax(
            off->way, hypot((double)wi[0] + k * (double)wo[0], (double)wi[1] + k * (double)wo[1]));
        off->way = fmax(off->way, fabs((double)vec3_length(wi) - 1));
        off->way = fmax(off->way, fabs((double)c[i].sample.scale - (through ? 1 / eta / eta : 1)));
        /* Grazing, the smallest change of the far direction changes the near cosine by more. */
        off->back = fmax(off->back, way_back(&s, wo, &c[i]) * fabs(d->cos) / fmax(1, ior * ior));
    }
    off->law = fmax(off->law, fmax(fabs(all - 1), fabs(reflected - f)));
}

static void glass_obeys(void)
{
    static const double ior[] = {1, 1.1, 1.33, 1.5, 2.4, 4};
    struct off off = {0, 0, 0};
    for (size_t i = 0; i < countof(ior); i++)
        for (size_t k = 0; k < LAWS_VIEWS; k++)
            judge_glass(ior[i], &laws_views[k], &off);
    ok(off.law < 2e-6, "glass reflects what Fresnel says and refracts the rest, 6 indices (%.1e)",
       off.law);
    ok(off.way < 1e-5, "along Snell's law, radiance times n^2 (%.1e)", off.way);
    ok(off.back < 0x1p-21, "and the way back is the same to 2^-21 n^2 / cos (%.1e)", off.back);
}

static void mirrors_obey(void)
{
    const struct material some[] = {
        {.kind = MATERIAL_MIRROR, .mirror = {{.9f, .5f, 1, 0}}},
        {.kind = MATERIAL_CONDUCTOR, .conductor = {rgb_gray(.2f), rgb_gray(3.9f), 0}}};
    double off = 0;
    bool single = true;
    for (size_t i = 0; i < countof(some); i++)
        for (size_t k = 0; k < LAWS_VIEWS; k++) {
            const struct scatter s = scatter_of(&some[i]);
            const vec3 wo = laws_direction(&laws_views[k]);
            struct scatter_choice c[2];
            single &= scatter_choices(&s, wo, c) == 1;
            const vec3 wi = c[0].sample.wi;
            single &= wi[0] == -wo[0] && wi[1] == -wo[1] && wi[2] == wo[2];
            off = fmax(off, way_back(&s, wo, &c[0]));
            off = fmax(off, (double)rgb_max(c[0].sample.weight) - 1);
        }
    ok(single && off == 0, "mirrors reflect into one direction, there and back, 1 at most");
}

/* Glass has two sides. */
enum { MATERIALS = 13, GLASSES = 8 };

static void obeys(struct material m, const char *name)
{
    laws_obeyed(&m, name);
}

/* F to and fro: R = F + (1 - F)^2 F (1 + F^2 + F^4 + ...). */
static void panes_obey(void)
{
    static const double ior[] = {1, 1.1, 1.5, 2.4, 4};
    double law = 0, back = 0;
    bool straight = true;
    for (size_t i = 0; i < countof(ior); i++)
        for (size_t k = 0; k < LAWS_VIEWS; k++) {
            const struct material m = {.kind = MATERIAL_PANE, .pane = {(float)ior[i]}};
            const struct scatter s = scatter_of(&m);
            const vec3 wo = laws_direction(&laws_views[k]);
            const double f = fresnel_by_angles(fabs((double)wo[2]), ior[i]);
            struct scatter_choice c[2];
            const int n = scatter_choices(&s, wo, c);
            double all = 0, reflected = f, round = (1 - f) * (1 - f) * f;
            for (int bounce = 0; bounce < 100000 && round > 1e-9; bounce++, round *= f * f)
                reflected += round;
            for (int j = 0; j < n; j++) {
                const vec3 wi = c[j].sample.wi;
                const bool through = wi[2] * wo[2] < 0;
                const float sign = through ? -1 : 1;
                const double share = c[j].chance * (double)c[j].sample.weight[1];
                straight &= wi[0] == -wo[0] && wi[1] == -wo[1] && wi[2] == sign * wo[2];
                straight &= c[j].sample.scale == 1;
                all += share;
                law = fmax(law, fabs(share - (through ? 1 - reflected : reflected)));
                back = fmax(back, way_back(&s, wo, &c[j]));
            }
            law = fmax(law, fabs(all - 1));
        }
    ok(law < 1e-5, "a pane reflects what all reflections inside it add up to (%.1e)", law);
    ok(straight && back < 1e-6, "and lets the rest straight through, there and back (%.1e)", back);
}

static void rough_glass_obeys(void)
{
    static const struct {
        float ior, alpha;
        const char *name;
    } glass[GLASSES] = {{1.5f, 2 * BSDF_LEAST_ALPHA, "glass 2^-9"},
                        {1.5f, .01f, "glass .01"},
                        {1.5f, .05f, "glass .05"},
                        {1.5f, .1f, "glass .1"},
                        {1.5f, .3f, "glass .3"},
                        {1.5f, 1, "glass 1"},
                        {1.1f, .5f, "ior 1.1, .5"},
                        {2.4f, .2f, "ior 2.4, .2"}};
    for (size_t i = 0; i < GLASSES; i++)
        obeys((struct material){.kind = MATERIAL_DIELECTRIC,
                                .dielectric = {.ior = glass[i].ior, .alpha = glass[i].alpha}},
              glass[i].name);
}

int main(void)
{
    laws_begin(MATERIALS + 2 * GLASSES);
    const rgb eta = {.2f, .9f, 1.1f, 0}, k = {3.9f, 2.4f, 2.2f, 0};
    static const float alpha[] = {
        BSDF_LEAST_ALPHA, .003f, .01f, .03f, .07f, .1f, .2f, .3f, .5f, .7f, 1};
    obeys((struct material){.kind = MATERIAL_DIFFUSE, .diffuse = {{.5f, 1, .2f, 0}}}, "diffuse");
    for (size_t i = 0; i < countof(alpha); i++) {
        const char *names[] = {"GGX 2^-10", "GGX .003", "GGX .01", "GGX .03", "GGX .07", "GGX .1",
                               "GGX .2",    "GGX .3",   "GGX .5",  "GGX .7",  "GGX 1"};
        /* Reflects everything: Fresnel's F is 1 less 4e-10. */
        obeys((struct material){.kind = MATERIAL_CONDUCTOR,
                                .conductor = {rgb_gray(1), rgb_gray(1e5f), alpha[i]}},
              names[i]);
    }
    obeys((struct material){.kind = MATERIAL_CONDUCTOR, .conductor = {eta, k, .15f}}, "metal .15");
    rough_glass_obeys();
    glass_obeys();
    mirrors_obey();
    panes_obey();
    return tap_done();
}
