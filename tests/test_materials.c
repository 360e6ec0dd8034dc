/* Every material, from 20 directions, over its range of roughness: samples follow the pdf, masses
 * add up to 1, weights are eval / pdf, no light is made, and it goes back the way it came
 * (stat/scatter.h). The quick tier takes 3 of the 20 directions for each, others for each.
 * SPDX-License-Identifier: MIT */
#include "common/trace/bsdf.h"

#include <math.h>

#include "tests/stat/means.h"
#include "tests/stat/scatter.h"
#include "tests/tap.h"

enum { DIRECTIONS = 20 };

struct seen_from {
    double cos, phi;
};

/* From straight above, from below, along the seam of phi, at 89.9 degrees on both sides. */
static const struct seen_from from[DIRECTIONS] = {
    {1, 0},    {.99, 0},    {.95, 3.1415926}, {.9, 1},     {.8, 2},
    {.7, 3},   {.6, 4},     {.5, 5},          {.4, 6},     {.3, 6.2831853},
    {.2, 0.5}, {.1, 1.5},   {.05, 2.5},       {.02, 3.5},  {.0017453284, 4.5},
    {-1, 0},   {-.75, 1.2}, {-.35, 2.2},      {-.04, 3.2}, {-.0017453284, 0},
};

static vec3 direction(const struct seen_from *d)
{
    const double r = sqrt(1 - d->cos * d->cos);
    return vec3_make((float)(r * cos(d->phi)), (float)(r * sin(d->phi)), (float)d->cos);
}

/* What one material showed, the worst of its directions. */
struct worst {
    uint32_t views;       /* directions whose density was judged */
    double p, rms;        /* of chi-square; the smallest bias it detects */
    double mass, pdf_off; /* of what is allowed; relative */
    double weight_off, most;
    uint32_t beyond, invalid;
    double made;    /* integral of eval, most */
    double unequal; /* p that sampled albedo and integral differ by the margin */
    double margin;  /* what the test of it could have proven */
};

/* Tests in a suite: all that share the level of 0.01. Glass has two sides. */
enum { MATERIALS = 13, GLASSES = 8 };
static double level(void)
{
    return stat_sidak(0.01, (MATERIALS + 2 * GLASSES) * DIRECTIONS);
}

/* From 89.9 degrees a narrow lobe is pressed against the horizon, thinner than the quadrature
 * resolves: its integrals are off by up to 0.003. There its weights are judged, not its density.
 * Glass has fewer samples on each side, and one where the quadrature sees nothing is one too many.
 */
static bool resolved(const struct scatter *s, const struct seen_from *d)
{
    return s->alpha > (s->ior != 1 ? .25f : .05f) || fabs(d->cos) > .01;
}

static const double margins[2] = {0.025, 0.005}; /* of equality; quick and long tier */

static void judge_density(const struct scatter *s, vec3 wo, uint64_t seed, struct worst *w)
{
    const uint32_t samples = stat_tries(100000, 1000000);
    const struct sphere_chi2_result r = scatter_follows(s, wo, samples, seed);
    /* Beyond the critical angle a narrow lobe lets through what cannot fill two pools. */
    if (s->side != SCATTER_THROUGH || r.chi2.dof >= 1) {
        w->views++;
        w->p = fmin(w->p, r.chi2.p);
        w->rms = fmax(w->rms, chi2_detects(&r.chi2, samples, level()));
    }
    w->mass = fmax(w->mass, fabs(r.mass_off) / fmax(1e-3, 4 * r.mass_sd));
    w->pdf_off = fmax(w->pdf_off, r.pdf_off);
    w->invalid += r.invalid;
}

static void judge_energy(const struct scatter *s, vec3 wo, const struct scatter_draw *d,
                         struct worst *w)
{
    for (int c = 0; c < (stat_is_long() ? 3 : 1); c++) {
        const double albedo = scatter_albedo(s, wo, c);
        const struct means m = means_from_truth(&d->albedo[c], albedo);
        w->made = fmax(w->made, albedo);
        w->unequal = fmax(w->unequal, means_unequal_p(&m, margins[stat_is_long()]));
        w->margin = fmax(w->margin, means_provable(&m, level()));
    }
}

static void view(const struct material *m, enum scatter_side side, size_t i, uint64_t seed,
                 struct worst *w)
{
    struct scatter s = scatter_of(m);
    s.side = side;
    const vec3 wo = direction(&from[i]);
    const struct scatter_draw d = scatter_draw(&s, wo, stat_tries(30000, 1000000), seed);
    w->weight_off = fmax(w->weight_off, d.off);
    w->most = fmax(w->most, d.most);
    w->beyond += d.beyond;
    w->invalid += d.invalid;
    if (!resolved(&s, &from[i]))
        return;
    judge_density(&s, wo, seed + 100, w);
    judge_energy(&s, wo, &d, w);
}

static void report(const char *name, const struct worst *w)
{
    ok(w->p > level(), "F-03: %s: samples follow the pdf from %u directions (p %.4f, detects %.3f rms)",
       name, w->views, w->p, w->rms);
    ok(w->mass < 1, "F-03: %s: pdf and rejections add up to 1 (%.2f of the 0.001 allowed)", name,
       w->mass);
    ok(w->pdf_off < 1e-4 && w->weight_off < 1e-4 && w->beyond == 0 && w->invalid == 0,
       "F-03: %s: pdf sampled is pdf asked (%.1e), weights are eval / pdf (%.1e), none is out of reach",
       name, w->pdf_off, w->weight_off);
    ok(w->made < 1.001 && w->most < 1.00001, "F-29: %s: no light is made (%.4f of it leaves at most)",
       name, w->made);
    const double margin = margins[stat_is_long()];
    if (STAT_SLOW == 1)
        ok(w->unequal < level() && w->margin < margin,
           "%s: sampled albedo is the integral of eval within %.3f (could prove %.4f)", name,
           margin, w->margin);
}

static void obeys(struct material m, const char *name)
{
    static uint64_t order;
    const uint64_t k = order++;
    const uint32_t views = STAT_SLOW > 1 ? 1 : stat_tries(3, DIRECTIONS);
    struct worst w = {.p = 1};
    for (uint32_t i = 0; i < views; i++) { /* 3 and 7 have no divisor in common with 20 */
        const size_t d = (3 * k + 7 * i) % DIRECTIONS;
        if (m.kind != MATERIAL_DIELECTRIC) {
            view(&m, SCATTER_ALL, d, 1000 * k + i, &w);
            continue;
        }
        view(&m, SCATTER_BACK, d, 1000 * k + i, &w);
        view(&m, SCATTER_THROUGH, d, 1000 * k + i, &w);
    }
    report(name, &w);
    const struct scatter s = scatter_of(&m);
    const uint32_t pairs = stat_tries(30000, 1000000);
    const struct scatter_reciprocal r = scatter_reciprocal(&s, pairs, k);
    ok(r.worst < 1 && r.invalid == 0 && r.alive > pairs / 4,
       "%s: reciprocal to 1e-5 (%.2f of it, %u pairs)", name, r.worst, r.alive);
}

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

static void judge_glass(double ior, const struct seen_from *d, struct off *off)
{
    const struct material m = {.kind = MATERIAL_DIELECTRIC, .dielectric = {(float)ior, 0}};
    const struct scatter s = scatter_of(&m);
    const vec3 wo = direction(d);
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
        for (size_t k = 0; k < DIRECTIONS; k++)
            judge_glass(ior[i], &from[k], &off);
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
        for (size_t k = 0; k < DIRECTIONS; k++) {
            const struct scatter s = scatter_of(&some[i]);
            const vec3 wo = direction(&from[k]);
            struct scatter_choice c[2];
            single &= scatter_choices(&s, wo, c) == 1;
            const vec3 wi = c[0].sample.wi;
            single &= wi[0] == -wo[0] && wi[1] == -wo[1] && wi[2] == wo[2];
            off = fmax(off, way_back(&s, wo, &c[0]));
            off = fmax(off, (double)rgb_max(c[0].sample.weight) - 1);
        }
    ok(single && off == 0, "mirrors reflect into one direction, there and back, 1 at most");
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
                                .dielectric = {glass[i].ior, glass[i].alpha}},
              glass[i].name);
}

int main(void)
{
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
    return tap_done();
}
