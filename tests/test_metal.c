/* Metal beyond one width: every law of scattering over roughness and anisotropy, and what is known
 * of GGX (ACCURACY rows A-14, F-22 to F-25, F-40): albedos by quadrature, the table made of them,
 * the white furnace, widths that change places, corners.
 * SPDX-License-Identifier: MIT */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "common/trace/albedo.h"
#include "common/trace/bsdf.h"
#include "tests/albedo_make.h"
#include "tests/dice.h"
#include "tests/ggx_albedo.h"
#include "tests/stat/laws.h"
#include "tests/stat/scatter.h"
#include "tests/tap.h"

static const double pi = 3.14159265358979323846;

static vec3 direction(double z, double phi)
{
    const double r = sqrt(1 - z * z);
    return vec3_make((float)(r * cos(phi)), (float)(r * sin(phi)), (float)z);
}

/* Turned by `deg`. eta 1, k 1e5: reflects everything, F is 1 less 4e-10. */
static struct material metal(float alpha_x, float alpha_y, double deg, bool multiscatter)
{
    const double turn = deg * pi / 180;
    return (struct material){.kind = MATERIAL_METAL,
                             .metal = {.eta = rgb_gray(1),
                                       .k = rgb_gray(1e5f),
                                       .alpha_x = alpha_x,
                                       .alpha_y = alpha_y,
                                       .turn_cos = (float)cos(turn),
                                       .turn_sin = (float)sin(turn),
                                       .multiscatter = multiscatter}};
}

static struct material coloured(struct material m)
{
    m.metal.eta = (rgb){.2f, .9f, 1.1f, 0};
    m.metal.k = (rgb){3.9f, 2.4f, 2.2f, 0};
    return m;
}

/* --- the grid --- */

static void laws(void)
{
    static const struct {
        float x, y;
        double deg;
        bool multiscatter;
    } grid[] = {
        {.003f, .03f, 0, false}, {.01f, .1f, 30, false}, {.3f, .03f, 0, false},
        {.05f, .5f, 77, false},  {.2f, .4f, 0, false},   {1, .1f, -45, false},
        {.1f, .1f, 0, true},     {.3f, .3f, 0, true},    {.5f, .5f, 0, true},
        {1, 1, 0, true},         {.05f, .5f, 20, true},  {1, .1f, 0, true},
    };
    laws_begin(countof(grid) + 1);
    for (size_t i = 0; i < countof(grid); i += stat_is_long() ? 1 : 2) {
        const struct material m = metal(grid[i].x, grid[i].y, grid[i].deg, grid[i].multiscatter);
        char name[64];
        snprintf(name, sizeof name, "%s %g x %g at %g", grid[i].multiscatter ? "whole" : "GGX",
                 (double)grid[i].x, (double)grid[i].y, grid[i].deg);
        laws_obeyed(&m, name);
    }
    const struct material gold = coloured(metal(.4f, .2f, 10, true));
    laws_obeyed(&gold, "metal .4 x .2");
}

/* --- A-14, F-23: albedos --- */

/* Height-correlated, to 1e-5, by the quadrature below with 2048 points a side. */
static const double alphas[5] = {.1, .25, .5, .75, 1}, cosines[5] = {.1, .3, .5, .8, 1};
static const double a14[5][5] = {{.88345, .93625, .96920, .98457, .98830},
                                 {.89162, .83791, .85726, .89727, .91581},
                                 {.86010, .74527, .69825, .68205, .68785},
                                 {.81071, .65028, .56462, .49232, .46392},
                                 {.76021, .56010, .45069, .35126, .30685}};

static void albedo_table_is_quadrature(void)
{
    const uint32_t points = (uint32_t)stat_tries(384, 1024) / STAT_SLOW;
    const double most = STAT_SLOW > 1 ? 1e-3 : stat_is_long() ? 1e-5 : 1e-4;
    double off = 0, sampled = 0;
    for (int i = 0; i < 5; i++)
        for (int k = 0; k < 5; k++) {
            const struct ggx_albedo a = {alphas[i], alphas[i], cosines[k], 0.3};
            off = fmax(off, fabs(ggx_albedo(&a, points) - a14[i][k]));
            const float alpha = (float)alphas[i];
            const struct material m = metal(alpha, alpha, 0, false);
            const struct scatter s = scatter_of(&m);
            sampled =
                fmax(sampled, fabs(scatter_albedo(&s, direction(cosines[k], .3), 1) - a14[i][k]));
        }
    ok(off < most, "A-14: the table is the quadrature to %.0e (%.1e)", most, off);
    ok(sampled < 0.001, "A-14: eval's integrals are the table's within .001 (%.1e)", sampled);
}

/* What leaves a white surface from one direction. */
static double whole(const struct ggx_albedo *a, uint32_t n)
{
    const struct facet f = {(float)a->x, (float)a->y};
    enum { HEIGHTS = 64, TURNS = 16 };
    double mean = 0; /* the lobe is the product of two shares: its integral is their mean's */
    for (int i = 0; i < HEIGHTS; i++)
        for (int k = 0; k < TURNS; k++)
            mean += (double)albedo_missing(
                        direction(sqrt((i + .5) / HEIGHTS), (k + .5) / TURNS * pi / 2), f) /
                    (HEIGHTS * TURNS);
    return ggx_albedo(a, n) + (double)albedo_missing(direction(a->cos, a->phi), f) * mean /
                                  (double)albedo_missing_mean(f);
}

static void white_furnace(void)
{
    struct dice dice = dice_make(5);
    double least[2] = {9, 9}, most[2] = {0, 0};
    for (uint32_t i = 0; i < stat_tries(300, 20000) / STAT_SLOW; i++) {
        const bool two = i & 1;
        const double alpha = dice_unit(&dice) * dice_unit(&dice);
        const double x = fmax((double)BSDF_LEAST_ALPHA, alpha);
        const double y = two ? fmax((double)BSDF_LEAST_ALPHA, x * dice_range(&dice, .1, 1)) : x;
        const struct ggx_albedo a = {x, y, dice_range(&dice, .1, 1), dice_range(&dice, 0, 2 * pi)};
        const double w = whole(&a, 64);
        least[two] = fmin(least[two], w);
        most[two] = fmax(most[two], w);
    }
    ok(least[0] > .995 && most[0] < 1.001,
       "F-23: whole GGX in a white furnace, one width: [%.4f, %.4f]", least[0], most[0]);
    ok(least[1] > .98 && most[1] < 1.001, "F-23: two widths, up to 1:10: [%.4f, %.4f]", least[1],
       most[1]);
}

static void stored_table_is_made(void)
{
    const uint32_t step = (uint32_t)stat_tries(41, 1) * STAT_SLOW;
    int off_share = 0;
    double off_mean = 0;
    for (uint32_t i = 0; i < countof(albedo_table.one); i += step)
        off_share = (int)fmax(off_share, abs(albedo_table.one[i] - albedo_make_one(i)));
    for (uint32_t i = 0; i < countof(albedo_table.two); i += step)
        off_share = (int)fmax(off_share, abs(albedo_table.two[i] - albedo_make_two(i)));
    for (uint32_t i = 0; i < countof(albedo_table.mean_one); i += step)
        off_mean =
            fmax(off_mean,
                 fabs((double)(albedo_table.mean_one[i] - albedo_make_mean_one(&albedo_table, i))));
    for (uint32_t i = 0; i < countof(albedo_table.mean_two); i += step)
        off_mean =
            fmax(off_mean,
                 fabs((double)(albedo_table.mean_two[i] - albedo_make_mean_two(&albedo_table, i))));
    ok(off_share <= 1 && off_mean < 1e-6,
       "albedo_table.c is what tool_albedo makes (%d / 65535, means %.1e)", off_share, off_mean);
}

/* --- F-24: D and G1 belong together --- */

/* The integral of G1 D / (4 mu) over all reflected directions, above the horizon or not. */
static double weak_albedo(struct facet a, vec3 o, uint32_t n)
{
    double sum = 0; /* over the normals m by their slopes, tan = r / (1 - r): dw_i = 4 (o.m) dw_m */
    for (uint32_t i = 0; i < n; i++)
        for (uint32_t k = 0; k < n; k++) {
            const double r = (i + .5) / n, phi = 2 * pi * (k + .5) / n, slope = r / (1 - r);
            const double x = -slope * cos(phi) * (double)a.x, y = -slope * sin(phi) * (double)a.y;
            const double l = sqrt(1 + x * x + y * y), area = (double)a.x * (double)a.y;
            const vec3 m = vec3_make((float)(x / l), (float)(y / l), (float)(1 / l));
            const double seen = (double)vec3_dot(o, m);
            if (seen > 0) /* dw_m = l^-3 times the slopes' area, slope / (1 - r)^2 dr dphi area */
                sum += (double)facet_reflect_pdf_w(o, m, a) * 4 * seen / (l * l * l) * slope /
                       ((1 - r) * (1 - r)) * area;
        }
    return sum * 2 * pi / n / n;
}

static void weak_furnace(void)
{
    static const float width[] = {.05f, .1f, .3f, 1};
    static const double mu[] = {.05, .2, .5, 1};
    double off = 0, oracle = 0;
    for (size_t i = 0; i < countof(width); i++)
        for (size_t k = 0; k < countof(mu); k++)
            for (int turn = 0; turn < 3; turn++) {
                const struct facet a = {width[i], turn == 2 ? width[i] : width[i] / 10};
                const struct ggx_albedo g = {(double)a.x, (double)a.y, mu[k], turn * .7};
                const double w = weak_albedo(a, direction(g.cos, g.phi), 256);
                off = fmax(off, fabs(w - 1));
                oracle = fmax(oracle, fabs(ggx_albedo_weak(&g, 256) - 1));
            }
    ok(off < 1e-3, "F-24: weak white furnace, 10:1 and 1:1, mu .05 to 1: 1 within %.1e", off);
    ok(oracle < 1e-3, "and so in the oracle (%.1e)", oracle);
}

/* --- F-22, F-25, F-40: where parameters end --- */

static bool same(rgb a, rgb b)
{
    return a[0] == b[0] && a[1] == b[1] && a[2] == b[2];
}

/* x and y change places when the widths do, to the bit, and a turn of 90 degrees is that, too. */
static void swapped_widths(void)
{
    struct dice dice = dice_make(9);
    const struct material m = coloured(metal(.4f, .04f, 0, true));
    const struct material swapped = coloured(metal(.04f, .4f, 0, true));
    struct material turned = swapped;
    turned.metal.turn_cos = 0;
    turned.metal.turn_sin = 1;
    bool bits = true;
    double off = 0;
    for (int i = 0; i < 20000; i++) {
        const vec3 o = direction(dice_range(&dice, .01, 1), dice_range(&dice, 0, 2 * pi));
        const vec3 w = direction(dice_range(&dice, .01, 1), dice_range(&dice, 0, 2 * pi));
        const rgb f = bsdf_eval(&m, o, w);
        bits &=
            same(f, bsdf_eval(&swapped, vec3_make(o[1], o[0], o[2]), vec3_make(w[1], w[0], w[2])));
        bits &= same(f, bsdf_eval(&turned, o, w));
        struct material all_round = m;
        all_round.metal.turn_cos = -1;
        off = fmax(off, fabs((double)(bsdf_eval(&all_round, o, w)[0] - f[0])));
    }
    ok(bits, "F-25: widths change places with x and y, and by a turn of 90 degrees: the same bits");
    ok(off == 0, "half a turn changes nothing");
}

/* With one width it is the conductor. */
static void one_width_is_conductor(void)
{
    struct dice dice = dice_make(10);
    double off = 0;
    for (int i = 0; i < 20000; i++) {
        const float alpha = (float)dice_range(&dice, .002, 1);
        const struct material m = coloured(metal(alpha, alpha, 33, false));
        struct material plain = {.kind = MATERIAL_CONDUCTOR};
        plain.conductor.eta = m.metal.eta;
        plain.conductor.k = m.metal.k;
        plain.conductor.alpha = alpha;
        const vec3 o = direction(dice_range(&dice, .01, 1), dice_range(&dice, 0, 2 * pi));
        struct bsdf_sample s;
        struct square q;
        q.u = dice_float(&dice);
        q.v = dice_float(&dice);
        if (!bsdf_sample(&plain, o, 0, q, &s) || s.wi[2] < .01f)
            continue;
        const double f = (double)bsdf_eval(&plain, o, s.wi)[0];
        off = fmax(off, fabs((double)bsdf_eval(&m, o, s.wi)[0] - f) / f);
        off = fmax(off, fabs((double)(bsdf_pdf_w(&m, o, s.wi) / s.pdf_w) - 1));
    }
    ok(off < 1e-3, "of one width it is the conductor (%.1e)", off);
}

static double albedo(const struct material *m, vec3 wo)
{
    struct dice dice = dice_make(2);
    const int n = 20000 / STAT_SLOW;
    double sum = 0;
    for (int i = 0; i < n; i++) {
        struct bsdf_sample s;
        const float lobe = dice_float(&dice);
        struct square q;
        q.u = dice_float(&dice);
        q.v = dice_float(&dice);
        if (bsdf_sample(m, wo, lobe, q, &s))
            sum += (double)s.weight[1] / n;
    }
    return sum;
}

static void narrow_lobes_meet_mirror(void)
{
    double off = 0;
    for (int whole = 0; whole < 2; whole++)
        for (int i = 1; i <= 20; i++) {
            const vec3 o = direction(i / 20.0, .4);
            const float least = BSDF_LEAST_ALPHA;
            const struct material lobe = coloured(metal(least, .99f * least, 0, whole));
            const struct material delta = coloured(metal(.99f * least, .5f * least, 0, whole));
            off = fmax(off, fabs(albedo(&lobe, o) - albedo(&delta, o)));
        }
    ok(off < 1e-3, "F-22: albedo is continuous where the lobe becomes a mirror (%.1e)", off);
    const struct material none = metal(0, 0, 0, true), half = metal(0, .3f, 0, true);
    ok(bsdf_is_delta(&none) && !bsdf_is_delta(&half), "only two widths of 0 make a mirror");
}

static bool sample_is_good(const struct material *m, vec3 wo, float lobe, struct square q)
{
    struct bsdf_sample s;
    if (!bsdf_sample(m, wo, lobe, q, &s))
        return true;
    const rgb f = bsdf_eval(m, wo, s.wi);
    bool good = s.pdf_w >= 0 && isfinite(s.pdf_w) && isfinite(bsdf_pdf_w(m, wo, s.wi));
    for (int c = 0; c < 3; c++)
        good &= s.weight[c] >= 0 && s.weight[c] <= (m->metal.multiscatter ? 20 : 1.00001f) &&
                f[c] >= 0 && isfinite(f[c]);
    return good && fabsf(vec3_length(s.wi) - 1) < 1e-5f;
}

/* F-40: grazing down to 1e-25, all corners of the numbers, one width 0. */
static void corners(void)
{
    static const float edge[] = {0, 0x1p-24f, 0.25f, 0.5f, 0.75f, 1 - 0x1p-23f, 1 - 0x1p-24f};
    static const double z[] = {1, 0.999999, 0.5, 1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-25, -1e-6};
    static const float width[][2] = {
        {1, 1}, {1, 0}, {0, 1}, {.3f, .03f}, {BSDF_LEAST_ALPHA, .3f}, {BSDF_LEAST_ALPHA, 0},
        {0, 0}};
    int bad = 0;
    for (size_t i = 0; i < 2 * countof(width); i++)
        for (size_t d = 0; d < countof(z); d++)
            for (size_t n = 0; n < countof(edge) * countof(edge) * countof(edge); n++) {
                const struct material m =
                    coloured(metal(width[i / 2][0], width[i / 2][1], 12, i & 1));
                const struct square q = {edge[n % 7], edge[n / 7 % 7]};
                bad += !sample_is_good(&m, direction(z[d], .1), edge[n / 49], q);
            }
    ok(bad == 0, "F-40: corners of the unit cube at all angles give finite samples (%d bad)", bad);
}

int main(void)
{
    laws();
    albedo_table_is_quadrature();
    white_furnace();
    stored_table_is_made();
    weak_furnace();
    swapped_widths();
    one_width_is_conductor();
    narrow_lobes_meet_mirror();
    corners();
    return tap_done();
}
