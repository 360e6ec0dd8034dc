/* Diffuse surfaces, retroreflectors, leaves and coats, over their parameters: the laws of
 * scattering (stat/laws.h), and the energy that must be exact. Metals and glass: test_materials.c.
 * SPDX-License-Identifier: MIT */
#include "common/trace/bsdf.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "common/trace/coat.h"
#include "common/trace/coat_table.h"
#include "tests/coat_make.h"
#include "tests/furnace.h"
#include "tests/sheen_make.h"
#include "tests/stack_make.h"
#include "tests/stat/laws.h"
#include "tests/stat/scatter.h"
#include "tests/stat/stat.h"
#include "tests/tap.h"

enum { ROUGH = 4, RETRO = 4, LEAVES = 2, PLASTICS = 6, CLOTHS = 4, PRINCIPLED = 6, CLEAR = 2 };

static const rgb orange = {.9f, .5f, .1f, 0};

/* The quick tier takes some of the slow ones. */
static int quick_step(int step)
{
    return stat_is_long() ? 1 : step;
}

static void obeyed(const struct material *m, const char *name)
{
    laws_obeyed_from(m, name, 2);
}

static void diffuse_obeys(void)
{
    static const float roughness[ROUGH] = {0, .2f, .6f, 1};
    static const float alpha[RETRO] = {.003f, .05f, .3f, 1};
    char name[48];
    for (int i = 0; i < ROUGH; i += quick_step(2)) {
        snprintf(name, sizeof name, "rough diffuse %g", (double)roughness[i]);
        obeyed(&(struct material){.kind = MATERIAL_ROUGH_DIFFUSE,
                                  .rough_diffuse = {orange, roughness[i]}},
               name);
    }
    for (int i = quick_step(2) - 1; i < RETRO; i += quick_step(2)) {
        snprintf(name, sizeof name, "retroreflector %g", (double)alpha[i]);
        obeyed(
            &(struct material){.kind = MATERIAL_RETROREFLECTOR, .retro = {rgb_gray(1), alpha[i]}},
            name);
    }
    obeyed(
        &(struct material){.kind = MATERIAL_LEAF, .leaf = {{.3f, .5f, .1f, 0}, {.2f, .4f, .6f, 0}}},
        "leaf, either way");
    obeyed(&(struct material){.kind = MATERIAL_LEAF, .leaf = {rgb_gray(0), orange}},
           "leaf, through alone");
}

static void plastic_obeys(void)
{
    static const struct {
        float ior, alpha;
    } coat[PLASTICS] = {{1.5f, 0}, {1.5f, .05f}, {1.5f, .2f}, {1.5f, 1}, {1.1f, .4f}, {3, .3f}};
    char name[48];
    for (int i = 0; i < PLASTICS; i += quick_step(2)) {
        snprintf(name, sizeof name, "plastic %g, %g", (double)coat[i].ior, (double)coat[i].alpha);
        obeyed(&(struct material){.kind = MATERIAL_PLASTIC,
                                  .plastic = {orange, coat[i].ior, coat[i].alpha}},
               name);
    }
}

static void cloth_obeys(void)
{
    static const float roughness[CLOTHS] = {.1f, .3f, .6f, 1};
    char name[32];
    for (int i = 0; i < CLOTHS; i += quick_step(3)) {
        snprintf(name, sizeof name, "cloth %g", (double)roughness[i]);
        obeyed(&(struct material){.kind = MATERIAL_CLOTH,
                                  .cloth = {orange, {.5f, .9f, 1, 0}, roughness[i]}},
               name);
    }
}

static const struct material principled[PRINCIPLED + CLEAR] = {
    {.kind = MATERIAL_PRINCIPLED,
     .principled =
         {.base_color = {.9f, .5f, .1f, 0}, .roughness = .5f, .ior = 1.5f, .sheen_roughness = .3f}},
    {.kind = MATERIAL_PRINCIPLED,
     .principled = {.base_color = {.9f, .5f, .1f, 0},
                    .metallic = 1,
                    .roughness = .6f,
                    .ior = 1.5f,
                    .clearcoat = 1,
                    .sheen_roughness = .3f}},
    {.kind = MATERIAL_PRINCIPLED,
     .principled = {.base_color = {1, .5f, .1f, 0},
                    .metallic = 1,
                    .roughness = 1,
                    .ior = 1.5f,
                    .sheen_roughness = .3f}},
    {.kind = MATERIAL_PRINCIPLED,
     .principled = {.base_color = {.9f, .5f, .1f, 0},
                    .metallic = .3f,
                    .roughness = .7f,
                    .ior = 1.3f,
                    .clearcoat = .5f,
                    .clearcoat_roughness = .4f,
                    .sheen_color = {.2f, .9f, 1, 0},
                    .sheen_roughness = .5f}},
    {.kind = MATERIAL_PRINCIPLED,
     .principled = {.base_color = {1, 1, 1, 0},
                    .roughness = 0,
                    .ior = 1.5f,
                    .clearcoat = 1,
                    .clearcoat_roughness = .3f,
                    .sheen_color = {1, 1, 1, 0},
                    .sheen_roughness = .2f}},
    {.kind = MATERIAL_PRINCIPLED,
     .principled = {.base_color = {1, 1, 1, 0},
                    .roughness = 1,
                    .ior = 2,
                    .sheen_color = {1, 1, 1, 0},
                    .sheen_roughness = 1}},
    {.kind = MATERIAL_PRINCIPLED,
     .principled = {.base_color = {.9f, .5f, .1f, 0},
                    .metallic = .2f,
                    .roughness = .7f,
                    .ior = 1.5f,
                    .transmission = .8f,
                    .clearcoat = .5f,
                    .clearcoat_roughness = .6f,
                    .sheen_color = {.3f, .3f, .3f, 0},
                    .sheen_roughness = .4f}},
    {.kind = MATERIAL_PRINCIPLED,
     .principled = {.base_color = {.9f, .5f, .1f, 0},
                    .metallic = .2f,
                    .roughness = .7f,
                    .ior = 1.5f,
                    .transmission = .8f,
                    .sheen_roughness = .3f}}};

static void principled_obeys(void)
{
    static const char *const names[] = {"plain",        "metallic paint", "rough metal",
                                        "a bit of all", "lacquer",        "rough cloth",
                                        "milky glass",  "frosted glass"};
    char name[48];
    /* The quick tier takes that which has a bit of all, and frosted glass. */
    for (size_t i = stat_is_long() ? 0 : 3; i < countof(principled); i += (size_t)quick_step(4)) {
        snprintf(name, sizeof name, "principled, %s", names[i]);
        laws_obeyed_from(&principled[i], name, 1);
    }
}

/* --- what white surfaces return, at 64 cosines from straight above to grazing --- */

enum { COSINES = 64 };

static vec3 seen(int i)
{
    const float z = (float)(i + 1) / COSINES; /* 1/64 to 1 */
    return vec3_make(__builtin_sqrtf(1 - z * z), 0, z);
}

/* What goes into single directions. */
static double delta_share(const struct scatter *s, vec3 wo)
{
    enum { STEPS = 1 << 14 };
    double sum = 0;
    for (int i = 0; i < STEPS; i++) {
        struct bsdf_sample b = {.scale = 1};
        const float lobe = ((float)i + 0.5f) / STEPS;
        if (s->sample(s->what, wo, lobe, (struct square){0.5f, 0.5f}, &b) && b.pdf_w == 0)
            sum += (double)b.weight[0] / STEPS;
    }
    return sum;
}

struct extent {
    double least, most;
};

static struct extent returned(const struct material *m)
{
    const struct scatter s = scatter_of(m);
    struct extent e = {(double)INFINITY, 0};
    const int step = stat_is_long() ? 1 : COSINES - 1;
    for (int i = 0; i < COSINES; i += step) {
        const double a = scatter_albedo(&s, seen(i), 0) + delta_share(&s, seen(i));
        e.least = fmin(e.least, a);
        e.most = fmax(e.most, a);
    }
    return e;
}

static void whites_return_all(void)
{
    struct extent e = {(double)INFINITY, 0};
    for (int i = 0; i <= 4; i++) {
        const struct extent one = returned(&(struct material){
            .kind = MATERIAL_ROUGH_DIFFUSE, .rough_diffuse = {rgb_gray(1), (float)i / 4}});
        e = (struct extent){fmin(e.least, one.least), fmax(e.most, one.most)};
    }
    ok(e.least > 0.999 && e.most < 1.001, "F-29 rough diffuse: white returns %.5f to %.5f", e.least,
       e.most);
}

/* The mean that coat_passes really has, over the one that is tabled. */
static double mean_off(const struct coat *c)
{
    enum { STEPS = 2048 };
    double sum = 0;
    for (int i = 0; i < STEPS; i++) {
        const double root = (i + 0.5) / STEPS, z = root * root; /* steep where z is small */
        sum += (double)coat_passes(c, (float)z) * 4 * z * root / STEPS;
    }
    return sum / (double)coat_passes_mean(c);
}

/* Under a rough coat: what facets reflect by quadrature, and all that passes comes back. (That eval
 * is that is the laws' business; its narrow lobes are not for the quadrature above.) Knots of the
 * tables and the middles between them. */
static struct extent white_rough(void)
{
    static const float ior[] = {1.1f, 1.17f, 1.33f, 1.5f, 1.8f, 2.4f, 3};
    static const float root[] = {.032f, .045f, .0625f, .094f, .125f, .156f,
                                 .22f,  .31f,  .53f,   .75f,  1};
    struct extent e = {(double)INFINITY, 0};
    for (size_t k = 0; k < countof(ior) * countof(root); k++) {
        const float r = root[k % countof(root)];
        const struct coat c = {ior[k / countof(root)], r * r};
        const double off = mean_off(&c);
        for (int i = 0; i < COSINES; i += stat_is_long() ? 1 : 21) {
            const float z = seen(i)[2];
            const double all = coat_make_albedo((double)z, (double)c.alpha, (double)c.ior) +
                               (double)coat_passes(&c, z) * off;
            e = (struct extent){fmin(e.least, all), fmax(e.most, all)};
        }
    }
    return e;
}

static void white_under_coats(void)
{
    struct extent e = {(double)INFINITY, 0};
    static const float ior[] = {1.1f, 1.33f, 1.5f, 2, 3};
    for (size_t k = 0; k < countof(ior); k++) {
        const struct extent one = returned(
            &(struct material){.kind = MATERIAL_PLASTIC, .plastic = {rgb_gray(1), ior[k], 0}});
        e = (struct extent){fmin(e.least, one.least), fmax(e.most, one.most)};
    }
    ok(e.least > 0.999 && e.most < 1.001, "F-29 plastic, smooth: white returns %.5f to %.5f",
       e.least, e.most);
    e = white_rough();
    ok(e.least > 0.98 && e.most < 1.001, "plastic, rough: white returns %.5f to %.5f", e.least,
       e.most);
}

/* As white_rough: fibres by quadrature, and all that they leave. */
static void white_cloth(void)
{
    enum { STEPS = 2048 };
    struct extent e = {(double)INFINITY, 0};
    for (int k = 0; k <= 36; k += quick_step(4)) {
        const float r = 0.1f + 0.025f * (float)k;
        double mean = 0;
        for (int i = 0; i < STEPS; i++) {
            const double root = (i + 0.5) / STEPS, z = root * root;
            mean += (1 - (double)sheen_albedo(r, (float)z)) * 4 * z * root / STEPS;
        }
        for (int i = 0; i < COSINES; i += stat_is_long() ? 1 : 21) {
            const float z = seen(i)[2];
            const double all =
                sheen_make_albedo((double)r, (double)z) +
                (1 - (double)sheen_albedo(r, z)) * mean / (1 - (double)sheen_mean(r));
            e = (struct extent){fmin(e.least, all), fmax(e.most, all)};
        }
    }
    ok(e.least > 0.98 && e.most < 1.001, "cloth: white returns %.5f to %.5f", e.least, e.most);
}

/* Layers upon layers. Lobes wide enough for the quadrature, or single directions. */
static void white_principled(void)
{
    static const struct {
        float metallic, roughness, clearcoat, clearcoat_roughness, sheen;
    } made[] = {{0, .5f, 1, 0, 0},       {0, .6f, 1, .5f, 0}, {0, 0, .5f, 0, 1},
                {0, .5f, 1, .5f, 1},     {1, .4f, 1, 0, 0},   {1, .7f, 0, 0, 0},
                {1, 0, 1, .4f, 0},       {1, 1, 1, 0, 1},     {1, .5f, 1, .5f, .5f},
                {.5f, .6f, .5f, 1, .3f}, {1, .6f, 0, 0, 1},   {.3f, 1, 1, 1, 1}};
    struct extent e = {(double)INFINITY, 0};
    for (size_t i = stat_is_long() ? 0 : 8; i < countof(made); i += stat_is_long() ? 1 : 4) {
        struct material m = {.kind = MATERIAL_PRINCIPLED};
        m.principled.base_color = rgb_gray(1);
        m.principled.sheen_color = rgb_gray(made[i].sheen);
        m.principled.metallic = made[i].metallic;
        m.principled.roughness = made[i].roughness;
        m.principled.ior = 1.5f;
        m.principled.clearcoat = made[i].clearcoat;
        m.principled.clearcoat_roughness = made[i].clearcoat_roughness;
        m.principled.sheen_roughness = .4f;
        const struct extent one = returned(&m);
        e = (struct extent){fmin(e.least, one.least), fmax(e.most, one.most)};
    }
    ok(e.least > 0.98 && e.most < 1.001, "F-29: stacks of layers: white returns %.5f to %.5f",
       e.least, e.most);
}

/* Any parameters, cosines from 0.1 on. */
static struct material white_of(enum material_kind kind, struct dice *d)
{
    struct material m = {.kind = kind};
    const float ior = (float)dice_range(d, 1.1, 3);
    if (kind == MATERIAL_PLASTIC) {
        m.plastic.albedo = rgb_gray(1);
        m.plastic.ior = ior;
        m.plastic.alpha = furnace_parameter(d, 0);
    } else if (kind == MATERIAL_CLOTH) {
        m.cloth.albedo = m.cloth.color = rgb_gray(1);
        m.cloth.roughness = furnace_parameter(d, .1);
    } else {
        m.principled.base_color = rgb_gray(1);
        m.principled.sheen_color = rgb_gray(furnace_parameter(d, 0));
        m.principled.metallic = furnace_parameter(d, 0);
        m.principled.roughness = furnace_parameter(d, 0);
        m.principled.ior = ior;
        m.principled.clearcoat = furnace_parameter(d, 0);
        m.principled.clearcoat_roughness = furnace_parameter(d, 0);
        m.principled.sheen_roughness = furnace_parameter(d, .1);
    }
    return m;
}

static void white_everywhere(void)
{
    static const enum material_kind kind[] = {MATERIAL_PLASTIC, MATERIAL_CLOTH,
                                              MATERIAL_PRINCIPLED};
    static const char *const name[] = {"plastic", "cloth", "principled"};
    for (size_t k = 0; k < countof(kind); k++) {
        struct dice dice = dice_make(70 + k);
        struct furnace f = {.least = (double)INFINITY};
        for (uint32_t i = 0; i <= stat_tries(7, 400) / STAT_SLOW; i++) {
            const struct material m = white_of(kind[k], &dice);
            const float z = (float)dice_range(&dice, .1, 1);
            furnace_add(&f, furnace_returned(&m, vec3_make(__builtin_sqrtf(1 - z * z), 0, z)));
        }
        ok(furnace_is_white(&f), "F-29: %s of any parameters: white returns %.4f to %.4f", name[k],
           f.least, f.most);
    }
}

/* --- the tables --- */

static void table_is_the_quadrature(void)
{
    const int step = stat_is_long() ? 1 : 977;
    int off = 0;
    for (int i = 0; i < COAT_IORS * COAT_WIDTHS * COAT_SLOPES; i += step) {
        const int n = i / (COAT_WIDTHS * COAT_SLOPES), rest = i % (COAT_WIDTHS * COAT_SLOPES);
        const int width = rest / COAT_SLOPES, slope = rest % COAT_SLOPES;
        off += coat_table.ratio[n][width][slope] != coat_make_ratio(n, width, slope);
        off += coat_table.mean[n][width] != coat_make_mean(&coat_table, n, width);
    }
    for (int i = 0; i < SHEEN_WIDTHS * SHEEN_COSINES; i += stat_is_long() ? 1 : 41) {
        const int width = i / SHEEN_COSINES, cosine = i % SHEEN_COSINES;
        off += sheen_table.albedo[width][cosine] != sheen_make_entry(width, cosine);
        off += sheen_table.mean[width] != sheen_make_mean(&sheen_table, width);
    }
    for (int i = 0; i < STACK_LOBES * STACK_WIDTHS * STACK_COSINES; i += stat_is_long() ? 1 : 101) {
        const int lobe = i / (STACK_WIDTHS * STACK_COSINES),
                  rest = i % (STACK_WIDTHS * STACK_COSINES);
        const int width = rest / STACK_COSINES, cosine = rest % STACK_COSINES;
        uint16_t row[STACK_CELLS];
        stack_make_row((enum stack_lobe)lobe, width, cosine, row);
        off += memcmp(row, stack_table[lobe][width][cosine], sizeof row) != 0;
    }
    ok(off == 0,
       "the tables are what tool_coat, tool_sheen and tool_stack make of the quadrature, "
       "every %d. entry",
       step);
}

/* The mean of Fresnel's F over even light, in closed form. */
static double duntley(double n)
{
    const double nn = n * n, a = nn + 1, b = nn * nn - 1;
    return 0.5 + (n - 1) * (3 * n + 1) / (6 * (n + 1) * (n + 1)) +
           nn * (nn - 1) * (nn - 1) / (a * a * a) * log((n - 1) / (n + 1)) -
           2 * n * nn * (nn + 2 * n - 1) / (a * b) +
           8 * nn * nn * (nn * nn + 1) / (a * b * b) * log(n);
}

static void averages(void)
{
    double off = 0;
    for (int i = 0; i <= 1000; i++) {
        const struct coat c = {1.1f + 1.9f * (float)i / 1000, 0};
        off = fmax(off, fabs(1 - (double)coat_passes_mean(&c) - duntley((double)c.ior)));
    }
    ok(off < 1e-5, "A-10 the mean of a smooth coat is Duntley's (%.1e)", off);
    const struct coat glass = {1.5f, 0};
    const double mean = (double)coat_passes_mean(&glass);
    near(1 - mean, .091777959, 1e-5, "of 1.5");
    near(1 - mean / 2.25, .596345760, 1e-5, "and inside");
    const rgb gray = coat_base(&glass, (float)mean, rgb_gray(.5f));
    near((double)gray[0], .5 * (1 - .596345760) / (1 - .5 * .596345760), 1e-5,
         "a gray of .5 is %.3f under it", (double)gray[0]);
}

int main(void)
{
    laws_begin(ROUGH + RETRO + LEAVES + PLASTICS + CLOTHS + PRINCIPLED + 2 * CLEAR);
    diffuse_obeys();
    plastic_obeys();
    cloth_obeys();
    principled_obeys();
    whites_return_all();
    white_under_coats();
    white_cloth();
    white_principled();
    white_everywhere();
    averages();
    table_is_the_quadrature();
    return tap_done();
}
