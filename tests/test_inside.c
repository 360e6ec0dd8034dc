/* The principled material seen from inside its body, where light passes it: the white furnace, the
 * laws of scattering, and the table of what coat and sheen keep (ACCURACY row F-29).
 *
 * In a furnace of radiance 1, radiance in a body of index n is n^2. A body that takes nothing looks
 * so from inside: of a path, what is reflected and, rid of the change of radiance, what goes out
 * add up to 1 (weight / scale of bsdf.h), as they do from outside. SPDX-License-Identifier: MIT */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "common/trace/bsdf.h"
#include "common/trace/covers.h"
#include "common/trace/glass_albedo.h"
#include "common/trace/inside.h"
#include "tests/dice.h"
#include "tests/furnace.h"
#include "tests/inside_make.h"
#include "tests/stat/laws.h"
#include "tests/stat/stat.h"
#include "tests/tap.h"

/* --- the furnace --- */

struct made { /* of what */
    bool smooth, mixed;
};

static struct material white(struct dice *d, struct made made)
{
    struct material m = {.kind = MATERIAL_PRINCIPLED};
    m.principled.base_color = rgb_gray(1);
    m.principled.roughness = made.smooth ? 0 : furnace_parameter(d, .04);
    m.principled.ior = (float)dice_range(d, 1.1, 2.5);
    m.principled.transmission = made.mixed ? furnace_parameter(d, 0.05) : 1;
    m.principled.metallic = made.mixed ? furnace_parameter(d, 0) : 0;
    m.principled.clearcoat = furnace_parameter(d, 0);
    m.principled.clearcoat_roughness = furnace_parameter(d, 0);
    m.principled.sheen_color = rgb_gray(furnace_parameter(d, 0));
    m.principled.sheen_roughness = furnace_parameter(d, .1);
    return m;
}

static void furnace(struct made made, const char *name)
{
    struct dice dice = dice_make(made.smooth + 2 * made.mixed);
    const struct furnace none = {.least = (double)INFINITY};
    struct furnace inside = none, outside = none;
    for (uint32_t i = 0; i <= stat_tries(5, 400) / STAT_SLOW; i++) {
        const struct material m = white(&dice, made);
        const float z = (float)dice_range(&dice, .1, 1), x = __builtin_sqrtf(1 - z * z);
        furnace_add(&inside, furnace_returned(&m, vec3_make(x, 0, -z)));
        furnace_add(&outside, furnace_returned(&m, vec3_make(x, 0, z)));
    }
    ok(furnace_is_white(&inside), "F-29: %s from inside: [%.4f, %.4f]", name, inside.least,
       inside.most);
    ok(furnace_is_white(&outside), "F-29: %s from outside: [%.4f, %.4f]", name, outside.least,
       outside.most);
}

/* Below a cosine of .1 the parts are off by more than above (below), but not their sum. */
static void grazing_furnace(void)
{
    struct dice dice = dice_make(17);
    double most = 0;
    for (uint32_t i = 0; i <= stat_tries(5, 200) / STAT_SLOW; i++) {
        const struct material m = white(&dice, (struct made){false, false});
        const float z = (float)dice_range(&dice, .02, .1), x = __builtin_sqrtf(1 - z * z);
        most = fmax(most, furnace_returned(&m, vec3_make(x, 0, -z)));
    }
    ok(most < 1.001, "F-29: nor is light made inside at cosines from .02 to .1 (%.4f)", most);
}

/* Along the surface there is no cosine to divide by. */
static void seen_from_the_side(void)
{
    static const float cosines[] = {0, 1e-40f, -1e-40f, 1e-20f, -1e-20f, 1e-7f, -1e-7f, .5f, -.5f};
    struct dice dice = dice_make(23);
    int bad = 0;
    for (int i = 0; i < 200; i++) {
        const struct material m = white(&dice, (struct made){i & 1, i & 2});
        for (size_t k = 0; k < countof(cosines) * countof(cosines); k++) {
            const float z = cosines[k % countof(cosines)], t = cosines[k / countof(cosines)];
            const vec3 wo = vec3_unit(vec3_make(.6f, .8f, z)), wi = vec3_unit(vec3_make(-1, 0, t));
            const rgb f = bsdf_eval(&m, wo, wi);
            const float pdf_w = bsdf_pdf_w(&m, wo, wi);
            bad += !(rgb_max(f) >= 0 && rgb_max(f) < (float)INFINITY);
            bad += !(pdf_w >= 0 && pdf_w < (float)INFINITY);
        }
    }
    ok(bad == 0, "F-20: seen or lit along the surface: %d values that are no number", bad);
}

/* --- the laws --- */

static struct material layered(float roughness, float ior, float coat_roughness, float sheen)
{
    struct material m = {.kind = MATERIAL_PRINCIPLED};
    m.principled.base_color = (rgb){.9f, .5f, 1, 0};
    m.principled.roughness = roughness;
    m.principled.ior = ior;
    m.principled.transmission = 1;
    m.principled.clearcoat = 1;
    m.principled.clearcoat_roughness = coat_roughness;
    m.principled.sheen_color = (rgb){sheen, .5f * sheen, 0, 0};
    m.principled.sheen_roughness = .5f;
    return m;
}

static void laws(void)
{
    static const struct {
        const char *name;
        float roughness, ior, coat_roughness, sheen;
    } of[] = {{"dust over clear glass and paint", 0, 1.5f, 0, .6f},
              {"coat over frosted glass", .6f, 1.5f, 0, 0},
              {"rough coat over frosted crystal", .7f, 2.2f, .6f, 0},
              {"coat and sheen over frosted ice", .8f, 1.31f, .3f, .3f}};
    laws_begin(2 * (countof(of) + 1));
    for (size_t i = 0; i < countof(of); i += stat_is_long() ? 1 : 3) {
        struct material m = layered(of[i].roughness, of[i].ior, of[i].coat_roughness, of[i].sheen);
        m.principled.transmission = of[i].roughness > 0 ? 1 : .5f; /* laws want more than mirrors */
        laws_obeyed_from(&m, of[i].name, 1);
    }
    if (!stat_is_long()) /* test_coats.c has some milk */
        return;
    struct material milk = layered(.5f, 1.4f, .5f, .5f);
    milk.principled.transmission = .6f;
    milk.principled.metallic = .2f;
    laws_obeyed_from(&milk, "milky glass with a bit of metal", 1);
}

/* --- the table --- */

static void table_is_made(void)
{
    const int rows = INSIDE_IORS * INSIDE_WIDTHS * INSIDE_HEIGHTS;
    const int step = (stat_is_long() ? 1 : 97) * STAT_SLOW;
    int off = 0;
    for (int i = 0; i < rows; i += step) {
        const int ior = i / (INSIDE_WIDTHS * INSIDE_HEIGHTS),
                  width = i / INSIDE_HEIGHTS % INSIDE_WIDTHS;
        uint16_t row[INSIDE_PARTS];
        inside_make_row(ior, width, i % INSIDE_HEIGHTS, row);
        for (int k = 0; k < INSIDE_PARTS; k++)
            off += abs(row[k] - inside_table.part[ior][width][i % INSIDE_HEIGHTS][k]) > 1;
        float mean[INSIDE_PARTS], several[INSIDE_CELLS];
        inside_make_mean(&inside_table, ior, width, mean);
        inside_make_several(ior, width, several);
        for (int k = 0; k < INSIDE_PARTS; k++)
            off += fabsf(mean[k] - inside_table.mean[ior][width][k]) > 1e-6f;
        for (int k = 0; k < INSIDE_CELLS; k++)
            off += fabsf(several[k] - inside_table.several[ior][width][k]) > 1e-6f;
    }
    ok(off == 0, "inside_table.c is what tool_inside makes, every %d. row", step);
}

/* Of what several facets let through from the cosine z. */
static double kept_of_several(const struct inside_glass *in, double z)
{
    enum { STEPS = 64 };
    const struct glass_albedo g = {in->ior, in->alpha};
    const double nn = (double)g.ior * (double)g.ior;
    double sum = 0;
    for (int i = 0; i < STEPS; i++) {
        const double root = (i + 0.5) / STEPS, cell = root * STACK_CELLS;
        const int k = (int)cell;
        const double kept =
            (double)in->kept[k][0] * (k + 1 - cell) + (double)in->kept[k + 1][0] * (cell - k);
        sum += kept * (double)glass_albedo_missing(&g, false, (float)(root * root)) * 4 * root *
               root * root / STEPS;
    }
    return sum * (double)glass_albedo_missing(&g, true, (float)z) /
           ((double)glass_albedo_mean(&g, false) + nn * (double)glass_albedo_mean(&g, true));
}

/* What facets mirror for a coat is never more than is kept, and between knots R is what it should
 * be: by the margins in units of all light. */
static void table_is_the_quadrature(double z_least, double z_most, double margin)
{
    struct dice dice = dice_make(5);
    double over = 0, more = 0, less = 0;
    const uint32_t tries = stat_tries(300, 6000) / STAT_SLOW;
    for (uint32_t t = 0; t < tries; t++) {
        const struct material m = white(&dice, (struct made){false, false});
        const struct covers covers = covers_of(&m);
        const double root = dice_range(&dice, 0x1p-5, 1), z = dice_range(&dice, z_least, z_most);
        struct inside_glass g = {.ior = m.principled.ior, .alpha = (float)(root * root)};
        g.straight = 1 - covers_coat_passes(&covers, 1);
        g.steep = 1 - covers_coat_passes(&covers, 0) - g.straight;
        double parts[INSIDE_PARTS], kept = 0;
        inside_make_parts(z, (double)g.ior, (double)g.alpha, 96, parts);
        for (int k = 0; k < INSIDE_CELLS; k++) {
            g.kept[k] = 1 - covers_pass(&covers, (float)(k * k) / 64);
            kept += parts[k] * (double)g.kept[k][0];
        }
        kept += kept_of_several(&g, z);
        const double mirrored =
            parts[INSIDE_CELLS] * (double)g.straight + parts[INSIDE_CELLS + 1] * (double)g.steep;
        const struct glass_albedo glass = {g.ior, g.alpha};
        const double left =
            (double)inside_left(&g, (float)z, glass_albedo_missing(&glass, true, (float)z))[0];
        over = fmax(over, 0.995 * mirrored - kept);
        more = fmax(more, left - fmax(0, kept - mirrored));
        less = fmax(less, kept - mirrored - left);
    }
    ok(over < 2 * margin, "facets mirror no more than coat and sheen keep from %g on (%.5f)",
       z_least, over);
    ok(more < margin && less < 0.015,
       "between knots what is left is at most %.4f too much, %.4f short", more, less);
}

int main(void)
{
    furnace((struct made){true, false}, "white layers over clear glass");
    furnace((struct made){false, false}, "white layers over frosted glass");
    furnace((struct made){true, true}, "clear glass, paint and metal under white layers");
    furnace((struct made){false, true}, "frosted glass, paint and metal under white layers");
    grazing_furnace();
    seen_from_the_side();
    laws();
    table_is_made();
    table_is_the_quadrature(.1, 1, .001);
    table_is_the_quadrature(.02, .1, .005);
    return tap_done();
}
