/* Diffuse surfaces, retroreflectors, leaves and coats, over their parameters: the laws of
 * scattering (stat/laws.h), and the energy that must be exact. Metals and glass: test_materials.c.
 * SPDX-License-Identifier: MIT */
#include "common/trace/bsdf.h"

#include <math.h>
#include <stdio.h>

#include "tests/stat/laws.h"
#include "tests/stat/scatter.h"
#include "tests/stat/stat.h"
#include "tests/tap.h"

enum { ROUGH = 4, RETRO = 4, LEAVES = 2 };

static const rgb orange = {.9f, .5f, .1f, 0};

static void diffuse_obeys(void)
{
    static const float roughness[ROUGH] = {0, .2f, .6f, 1};
    static const float alpha[RETRO] = {.003f, .05f, .3f, 1};
    char name[32];
    for (int i = 0; i < ROUGH; i++) {
        snprintf(name, sizeof name, "rough diffuse %g", (double)roughness[i]);
        laws_obeyed(&(struct material){.kind = MATERIAL_ROUGH_DIFFUSE,
                                       .rough_diffuse = {orange, roughness[i]}},
                    name);
    }
    for (int i = 0; i < RETRO; i++) {
        snprintf(name, sizeof name, "retroreflector %g", (double)alpha[i]);
        laws_obeyed(
            &(struct material){.kind = MATERIAL_RETROREFLECTOR, .retro = {rgb_gray(1), alpha[i]}},
            name);
    }
    laws_obeyed(
        &(struct material){.kind = MATERIAL_LEAF, .leaf = {{.3f, .5f, .1f, 0}, {.2f, .4f, .6f, 0}}},
        "leaf, either way");
    laws_obeyed(&(struct material){.kind = MATERIAL_LEAF, .leaf = {rgb_gray(0), orange}},
                "leaf, through alone");
}

/* --- what white surfaces return, at 64 cosines from straight above to grazing --- */

enum { COSINES = 64 };

static vec3 seen(int i)
{
    const float z = (float)(i + 1) / COSINES; /* 1/64 to 1 */
    return vec3_make(__builtin_sqrtf(1 - z * z), 0, z);
}

struct extent {
    double least, most;
};

static struct extent returned(const struct material *m)
{
    const struct scatter s = scatter_of(m);
    struct extent e = {INFINITY, 0};
    const int step = stat_is_long() ? 1 : 9;
    for (int i = 0; i < COSINES; i += step) {
        const double a = scatter_albedo(&s, seen(i), 0);
        e.least = fmin(e.least, a);
        e.most = fmax(e.most, a);
    }
    return e;
}

static void whites_return_all(void)
{
    struct extent e = {INFINITY, 0};
    for (int i = 0; i <= 4; i++) {
        const struct extent one = returned(&(struct material){
            .kind = MATERIAL_ROUGH_DIFFUSE, .rough_diffuse = {rgb_gray(1), (float)i / 4}});
        e = (struct extent){fmin(e.least, one.least), fmax(e.most, one.most)};
    }
    ok(e.least > 0.999 && e.most < 1.001, "F-29 rough diffuse: white returns %.5f to %.5f", e.least,
       e.most);
}

int main(void)
{
    laws_begin(ROUGH + RETRO + LEAVES);
    diffuse_obeys();
    whites_return_all();
    return tap_done();
}
