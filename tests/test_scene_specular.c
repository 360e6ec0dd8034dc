/* scene_specular.c: what documents say of glass and metals, which kind of material that is, and
 * that named metals have the colours that are known of them. SPDX-License-Identifier: MIT */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "common/scene.h"
#include "common/trace/fresnel.h"
#include "tests/tap.h"

static struct arena arena;
static struct scene scene;

/* The only material of a document. */
static struct material material_of(const char *json)
{
    static char text[2048];
    struct scene_errors errors = {0};
    snprintf(text, sizeof text,
             "{\"smalti\": 1, \"film\": {\"width\": 64, \"height\": 48}, \"camera\": {\"type\": "
             "\"perspective\", \"fov_deg\": 90, \"look_at\": {\"from\": [1, 2, 3], \"to\": [1, 2, "
             "0]}}, \"materials\": {\"m\": {%s}}, \"shapes\": []}",
             json);
    const bool good = scene_parse(&scene, text, strlen(text), SCENE_FROM_DISK, &arena, &errors);
    ok(good, "valid: %s", json);
    if (!good)
        diag("%s: %s", errors.list[0].where, errors.list[0].what);
    return good ? scene.materials[0] : (struct material){0};
}

static bool is_rgb(rgb c, double r, double g, double b)
{
    return c[0] == (float)r && c[1] == (float)g && c[2] == (float)b;
}

/* Reflectance of clean metal seen straight on, 380 to 750 nm folded to Rec. 709: T. Akenine-Moeller
 * et al., "Real-Time Rendering", 4th ed., table 9.2 (gold's red is cut at 1 there). */
static void named_metals(void)
{
    static const struct {
        const char *name;
        double f0[3], most; /* apart */
    } known[] = {{"gold", {1, .782, .344}, .065},      {"silver", {.972, .960, .915}, .065},
                 {"copper", {.955, .638, .538}, .065}, {"aluminium", {.913, .922, .924}, .01},
                 {"iron", {.562, .565, .578}, .09},    {"chromium", {.549, .556, .554}, .065},
                 {"brass", {.910, .778, .423}, .065}};
    for (size_t i = 0; i < countof(known); i++) {
        char json[128];
        snprintf(json, sizeof json, "\"type\": \"conductor\", \"metal\": \"%s\", \"alpha\": 0.1",
                 known[i].name);
        const struct material m = material_of(json);
        const rgb f = fresnel_conductor(1, m.conductor.eta, m.conductor.k);
        double off = 0;
        for (int c = 0; c < 3; c++)
            off = fmax(off, fabs((double)f[c] - known[i].f0[c]));
        ok(m.kind == MATERIAL_CONDUCTOR && off < known[i].most,
           "%s has its colour: %.3f %.3f %.3f (%.3f)", known[i].name, (double)f[0], (double)f[1],
           (double)f[2], off);
    }
}

static void conductors(void)
{
    struct material m =
        material_of("\"type\": \"conductor\", \"eta\": [0.2, 0.4, 1.4], \"k\": 3, \"alpha\": "
                    "[0.25, 0.25], \"rotation_deg\": 30");
    ok(m.kind == MATERIAL_CONDUCTOR && m.conductor.alpha == .25f &&
           is_rgb(m.conductor.eta, .2, .4, 1.4) && is_rgb(m.conductor.k, 3, 3, 3),
       "two equal widths are one: the plain conductor");
    m = material_of("\"type\": \"conductor\", \"eta\": [0.2, 0.4, 1.4], \"k\": 3, \"alpha\": "
                    "[0.25, 0.5], \"rotation_deg\": 90");
    ok(m.kind == MATERIAL_METAL && m.metal.alpha_x == .25f && m.metal.alpha_y == .5f &&
           m.metal.turn_cos == 0 && m.metal.turn_sin == 1 && !m.metal.multiscatter &&
           is_rgb(m.metal.eta, .2, .4, 1.4),
       "two widths, turned; a quarter turn is exact");
    m = material_of("\"type\": \"conductor\", \"metal\": \"iron\", \"alpha\": 0.5, "
                    "\"multiscatter\": true");
    ok(m.kind == MATERIAL_METAL && m.metal.multiscatter && m.metal.alpha_x == .5f &&
           m.metal.alpha_y == .5f && m.metal.turn_cos == 1 && m.metal.turn_sin == 0 &&
           !strcmp(m.name, "m"),
       "light of several facets, asked for");
    m = material_of("\"type\": \"conductor\", \"metal\": \"iron\", \"alpha\": 0.5, "
                    "\"multiscatter\": false");
    ok(m.kind == MATERIAL_CONDUCTOR, "not asked for: the plain conductor");
    m = material_of("\"type\": \"conductor\", \"metal\": \"iron\", \"alpha\": 0, "
                    "\"thin_film\": {\"thickness_nm\": 120, \"ior\": 2.2}");
    ok(m.kind == MATERIAL_METAL && m.metal.film.thickness_nm == 120 && m.metal.film.ior == 2.2f,
       "a film");
    m = material_of("\"type\": \"conductor\", \"metal\": \"iron\", \"alpha\": 0, "
                    "\"thin_film\": {\"thickness_nm\": 120, \"ior\": 1}");
    ok(m.kind == MATERIAL_CONDUCTOR, "of index 1 it is none");
}

static void dielectrics(void)
{
    struct material m = material_of("\"type\": \"dielectric\", \"ior\": 1.5");
    ok(m.kind == MATERIAL_DIELECTRIC && m.dielectric.ior == 1.5f &&
           is_rgb(m.inside.absorption, 0, 0, 0) && m.inside.priority == 0 &&
           !m.dielectric.multiscatter,
       "clear, and without a priority");
    m = material_of("\"type\": \"dielectric\", \"ior\": 1.5, \"absorption\": [1, 20, 0], "
                    "\"priority\": 7");
    ok(is_rgb(m.inside.absorption, 1, 20, 0) && m.inside.priority == 7, "absorption, priority");
    m = material_of(
        "\"type\": \"dielectric\", \"ior\": 1.5, \"alpha\": 0.5, \"multiscatter\": true");
    ok(m.dielectric.multiscatter && m.dielectric.alpha == .5f, "light of several facets of glass");
    m = material_of("\"type\": \"thin_dielectric\", \"ior\": 1.5");
    ok(m.kind == MATERIAL_PANE && m.pane.ior == 1.5f, "a pane");
}

int main(void)
{
    dielectrics();
    named_metals();
    conductors();
    arena_release(&arena);
    return tap_done();
}
