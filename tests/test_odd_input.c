/* Documents that are allowed, but in which something is not there: no width, no refraction, no
 * area, no tangent, no light. Each goes through the reader and is rendered, and must be what the
 * document without that thing is: mostly to the bit. (What is refused: tests/invalid/,
 * test_image_asset.c, test_scene_disk.c.) SPDX-License-Identifier: MIT */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "common/image_asset.h"
#include "common/trace/prep.h"
#include "tests/image_files.h"
#include "tests/scenes.h"
#include "tests/stat/stat.h"
#include "tests/tap.h"

/* --- a document, and its image --- */

struct odd { /* members of the document, as text; NULL: none */
    const char *materials, *textures, *shapes, *lights;
};

static struct arena arena;
static struct buf file; /* what every image of a document is read from, an EXR */

static bool load_images(const struct scene *scene, struct err *err)
{
    for (uint32_t i = 0; i < scene->image_count; i++)
        if (!image_asset_read(&scene->images[i], file.data, file.size, &arena, err))
            return false;
    return true;
}

#define BALL "{\"type\": \"sphere\", \"material\": \"m\", \"center\": [0, 0, 0], \"radius\": 1}"
#define SKY  "{\"type\": \"sky\", \"radiance\": 1}"

static const struct stage *stage_of(const struct odd *o)
{
    static char text[8192];
    struct scene scene;
    struct scene_errors errors;
    struct arena scratch = {0};
    const struct stage *stage = NULL;
    struct err err = {0};
    snprintf(text, sizeof text,
             "{\"smalti\": 1, \"film\": {\"width\": 8, \"height\": 8}, \"camera\": {\"type\": "
             "\"perspective\", \"fov_deg\": 25, \"look_at\": {\"from\": [1, 2, 4], \"to\": [0, 0, "
             "0]}}, \"textures\": {%s}, \"materials\": {\"m\": %s}, \"shapes\": [%s], \"lights\": "
             "[%s]}",
             o->textures ? o->textures : "", o->materials, o->shapes ? o->shapes : BALL,
             o->lights ? o->lights : SKY);
    if (!scene_parse(&scene, text, strlen(text), SCENE_FROM_DISK, &arena, &errors))
        diag("%s: %s", errors.list[0].where, errors.list[0].what);
    else if (!load_images(&scene, &err) ||
             !prep_stage(&scene, NULL, &arena, &scratch, &stage, &err))
        diag("%s", err.text);
    arena_release(&scratch);
    return stage;
}

enum { SPP = 64, PIXELS = 64 };

static bool film_of(const struct odd *o, struct film *film)
{
    const struct stage *stage = stage_of(o);
    *film = (struct film){0};
    if (!stage)
        return false;
    scenes_render(stage, SPP, film);
    return true;
}

/* No sample is invalid and none of the pixels is dark or bright; how far at most one is from 1. */
static double off_one(const struct odd *o)
{
    struct film film;
    double worst = 0;
    if (!film_of(o, &film))
        return (double)INFINITY;
    for (size_t i = 0; i < PIXELS; i++) {
        double mean[3];
        film_mean(&film, i, mean);
        for (int c = 0; c < 3; c++)
            worst = fmax(worst, fabs(mean[c] - 1));
    }
    if (film.invalid_count)
        worst = (double)INFINITY;
    film_release(&film);
    return worst;
}

static bool same(const struct odd *a, const struct odd *b)
{
    struct film one, other;
    const bool first = film_of(a, &one), made = film_of(b, &other) && first;
    const bool good =
        made && !one.invalid_count && !other.invalid_count &&
        !memcmp(one.replicate, other.replicate, PIXELS * FILM_CHANNELS * sizeof *one.replicate);
    film_release(&one);
    film_release(&other);
    return good;
}

/* --- materials at the ends of their ranges --- */

/* What has the index of its surroundings cannot be seen: every pixel is the sky's 1. */
static void index_of_one(void)
{
    static const char *const clear[] = {
        "{\"type\": \"dielectric\", \"ior\": 1}",
        "{\"type\": \"dielectric\", \"ior\": 1, \"alpha\": 0.5}",
        "{\"type\": \"dielectric\", \"ior\": 1, \"alpha\": 1, \"multiscatter\": true}",
        "{\"type\": \"dielectric\", \"ior\": 1, \"priority\": 3}",
        "{\"type\": \"dielectric\", \"ior\": {\"texture\": \"t\"}, \"alpha\": 0.3}",
        "{\"type\": \"thin_dielectric\", \"ior\": 1}",
        "{\"type\": \"thin_dielectric\", \"ior\": {\"texture\": \"t\"}}"};
    for (size_t i = 0; i < countof(clear); i++) {
        const struct odd o = {clear[i], "\"t\": {\"type\": \"checker\", \"colors\": [1, 0]}", NULL,
                              NULL};
        const double off = off_one(&o);
        ok(off < 1e-5, "ior 1 is not seen: %s (%.1e)", clear[i], off);
    }
}

static void no_width(void)
{
    static const struct {
        const char *what, *with, *without;
    } pairs[] = {
        {"dielectric, alpha 0", "{\"type\": \"dielectric\", \"ior\": 1.5, \"alpha\": 0}",
         "{\"type\": \"dielectric\", \"ior\": 1.5}"},
        {"dielectric, alpha 0 by a texture",
         "{\"type\": \"dielectric\", \"ior\": 1.5, \"alpha\": {\"texture\": \"t\"}}",
         "{\"type\": \"dielectric\", \"ior\": 1.5}"},
        {"plastic, alpha 0", "{\"type\": \"plastic\", \"albedo\": 0.5, \"alpha\": 0}",
         "{\"type\": \"plastic\", \"albedo\": 0.5}"},
        {"metal, two widths of 0",
         "{\"type\": \"conductor\", \"metal\": \"gold\", \"alpha\": [0, 0]}",
         "{\"type\": \"conductor\", \"metal\": \"gold\", \"alpha\": 0}"},
        {"metal, width 1e-30", "{\"type\": \"conductor\", \"metal\": \"gold\", \"alpha\": 1e-30}",
         "{\"type\": \"conductor\", \"metal\": \"gold\", \"alpha\": 0}"},
        {"metal, alpha 0 by a texture",
         "{\"type\": \"conductor\", \"metal\": \"gold\", \"alpha\": {\"texture\": \"t\"}}",
         "{\"type\": \"conductor\", \"metal\": \"gold\", \"alpha\": 0}"},
        {"rough diffuse, roughness 0",
         "{\"type\": \"rough_diffuse\", \"albedo\": 0.5, \"roughness\": 0}",
         "{\"type\": \"diffuse\", \"albedo\": 0.5}"},
        {"metal under a film of no thickness",
         "{\"type\": \"conductor\", \"metal\": \"gold\", \"alpha\": 0, \"thin_film\": "
         "{\"thickness_nm\": 0, \"ior\": 1.5}}",
         "{\"type\": \"conductor\", \"metal\": \"gold\", \"alpha\": 0}"},
        {"a mask of opacity 1",
         "{\"type\": \"diffuse\", \"albedo\": 0.5}, \"n\": {\"type\": "
         "\"mask\", \"material\": \"m\", \"opacity\": 1}",
         "{\"type\": \"diffuse\", \"albedo\": 0.5}, \"n\": {\"type\": \"diffuse\", \"albedo\": "
         "0.5}"}};
    for (size_t i = 0; i < countof(pairs); i++) {
        struct odd a = {pairs[i].with, "\"t\": {\"type\": \"checker\", \"colors\": [0, 0]}", NULL,
                        NULL};
        struct odd b = {pairs[i].without, NULL, NULL, NULL};
        if (strstr(pairs[i].with, "\"n\""))
            a.shapes = b.shapes =
                "{\"type\": \"sphere\", \"material\": \"n\", \"center\": [0, 0, 0], \"radius\": 1}";
        ok(same(&a, &b), "%s: the bits of what has none", pairs[i].what);
    }
}

/* White in a white sky: nothing is brighter than that, and what loses nothing (as single scattering
 * does) not darker. */
static void white_at_the_ends(void)
{
    static const struct {
        double least;
        const char *material;
    } ends[] = {
        {0, "{\"type\": \"conductor\", \"eta\": 0.001, \"k\": 100, \"alpha\": [0, 1]}"},
        {0, "{\"type\": \"conductor\", \"eta\": 0.001, \"k\": 100, \"alpha\": [1e-30, 0.5]}"},
        {.999, "{\"type\": \"retroreflector\", \"reflectance\": 1, \"alpha\": 0}"},
        {.999, "{\"type\": \"principled\", \"base_color\": 1, \"metallic\": 1, \"roughness\": 0}"},
        {.98, "{\"type\": \"principled\", \"base_color\": 1, \"roughness\": 0, \"clearcoat\": 1, "
              "\"clearcoat_roughness\": 0, \"sheen_color\": 1, \"sheen_roughness\": 0.1}"},
        {.999, "{\"type\": \"principled\", \"base_color\": 1, \"roughness\": 0, \"transmission\": "
               "1, \"ior\": 1.1}"}};
    for (size_t i = 0; i < countof(ends); i++) {
        const struct odd o = {.materials = ends[i].material};
        struct film film;
        double lo = 2, hi = 0;
        if (film_of(&o, &film)) {
            const struct scenes_mean m = scenes_mean(&film, 1);
            lo = m.mean + 4 * m.error;
            hi = film.invalid_count ? (double)INFINITY : m.mean - 4 * m.error;
        }
        ok(lo >= ends[i].least && hi > 0 && hi <= 1.001, "white: %s (%.4f to %.4f)",
           ends[i].material, hi, lo);
        film_release(&film);
    }
}

/* --- lights without area --- */

#define WHITE "{\"type\": \"diffuse\", \"albedo\": 0.5}"
#define FLOOR                                                                                      \
    "{\"type\": \"quad\", \"material\": \"m\", \"vertices\": [[-2, -1, 2], [2, -1, 2], [2, -1, "   \
    "-2], [-2, -1, -2]]}"
#define LAMP(vertices, triangles)                                                                  \
    "{\"type\": \"mesh\", \"material\": \"m\", \"emission\": 1000, \"vertices\": [" vertices       \
    "], \"triangles\": [" triangles "]}"

/* Their light is what their area is, down to where float has none: the rest of the image stays. */
static void next_to_no_area(void)
{
    const struct odd dark = {WHITE, NULL, FLOOR, NULL};
    struct film film;
    double before = 0, bad = 0;
    if (film_of(&dark, &film))
        before = scenes_mean(&film, 1).mean;
    film_release(&film);
    for (int k = 3; k <= 40; k++) {
        char shapes[1024];
        snprintf(shapes, sizeof shapes,
                 FLOOR ", " LAMP("[0, 1, 0], [1e-%d, 1, 0], [0, 1, 1e-%d]", "[0, 1, 2]"), k, k);
        const struct odd o = {WHITE, NULL, shapes, NULL};
        if (!film_of(&o, &film))
            bad++;
        const double more = scenes_mean(&film, 1).mean - before, most = 1000 * pow(10, -2 * k) / 2;
        bad += film.invalid_count || fabs(more) > most + 1e-6 || (k == 3 && more < most / 100);
        film_release(&film);
    }
    ok(before > .4 && bad == 0, "lamps of 1e-3 to 1e-40 m: light as their area, no invalid sample");
}

static void no_area(void)
{
    static const char *const none[] = {
        LAMP("[0, 0, 0], [1, 1, 1], [2, 2, 2]", "[0, 1, 2]"),
        LAMP("[0, 0, 0], [1, 1, 1], [1, 1, 1]", "[0, 1, 2], [0, 0, 1], [2, 2, 2]")};
    static const struct odd dark = {WHITE, NULL, FLOOR, "{\"type\": \"sky\", \"radiance\": 0.5}"};
    for (size_t i = 0; i < countof(none); i++) {
        char shapes[1024];
        snprintf(shapes, sizeof shapes, FLOOR ", %s", none[i]);
        struct odd o = dark;
        o.shapes = shapes;
        const struct stage *stage = stage_of(&o);
        ok(stage && stage->emitters.count == 0 && stage->dropped_degenerate == (i ? 3 : 1),
           "a lamp of triangles without area is none, and they are counted");
        ok(same(&o, &dark), "and the image is as without it");
    }
    const struct odd one = {WHITE, NULL,
                            FLOOR ", " LAMP("[0, 1, 0], [1, 1, 0], [0, 1, 1]", "[0, 1, 2]"), NULL};
    const struct odd more = {
        WHITE, NULL,
        FLOOR ", " LAMP("[0, 1, 0], [1, 1, 0], [0, 1, 1], [0.5, 1, 0]", "[0, 1, 2], [0, 3, 1]"),
        NULL};
    ok(same(&one, &more), "a triangle without area beside one that has some changes nothing");
}

/* --- directions that are not there --- */

#define MESH(more)                                                                                 \
    "{\"type\": \"mesh\", \"material\": \"m\", \"vertices\": [[-1, 0, 1], [1, 0, 1], [1, 0, -1], " \
    "[-1, 0, -1]], \"triangles\": [[0, 1, 2], [0, 2, 3]]" more "}"

static void no_directions(void)
{
    static const struct odd flat = {WHITE, NULL, MESH(""), NULL};
    static const struct odd zero = {
        WHITE, NULL, MESH(", \"normals\": [[0, 0, 0], [0, 0, 0], [0, 0, 0], [0, 0, 0]]"), NULL};
    static const struct odd bent = {
        WHITE, NULL, MESH(", \"normals\": [[1, 0, 0], [-1, 0, 0], [0, -1, 0], [1e-30, 0, 1e-30]]"),
        NULL};
    struct film film;
    ok(same(&zero, &flat), "normals of 0: those of the triangles");
    ok(film_of(&bent, &film) && !film.invalid_count && scenes_mean(&film, 0).mean < 1.001,
       "normals along the surface, against it and too short: no invalid sample");
    film_release(&film);
    static const char *const uvs[] = {"", ", \"uvs\": [[0, 0], [0, 0], [0, 0], [0, 0]]",
                                      ", \"uvs\": [[0, 0], [1, 1], [2, 2], [3, 3]]",
                                      ", \"uvs\": [[0, 0], [1e-30, 0], [1e-30, 1e-30], [0, 1e-30]]",
                                      ", \"uvs\": [[0, 0], [1e6, 0], [1e6, 1e6], [0, 1e6]]"};
    for (size_t i = 0; i < countof(uvs); i++) {
        char shapes[1024];
        snprintf(shapes, sizeof shapes, MESH("%s"), uvs[i]);
        const struct odd brushed = {
            "{\"type\": \"conductor\", \"eta\": 0.001, \"k\": 100, \"alpha\": [0.05, 0.5], "
            "\"rotation_deg\": 30, \"multiscatter\": true}",
            NULL, shapes, NULL};
        double most = (double)INFINITY;
        if (film_of(&brushed, &film) && !film.invalid_count)
            most = scenes_mean(&film, 1).mean;
        ok(most > .98 && most <= 1.001, "F-25: brushed metal, uvs%s: returns %.4f", uvs[i], most);
        film_release(&film);
    }
}

/* --- images of one pixel, and black ones --- */

static void image_is(uint32_t width_px, uint32_t height_px, float value)
{
    static const char *const names[] = {"B", "G", "R"};
    static float pixels[64 * 3];
    for (size_t i = 0; i < countof(pixels); i++)
        pixels[i] = value;
    buf_release(&file);
    if (!image_files_exr(&file,
                         &(struct image_files_exr){width_px, height_px, names, 3, IMAGE_FILES_HALF,
                                                   IMAGE_FILES_ZIP, .pixels = pixels}))
        ok(false, "an EXR can be made");
}

static void small_images(void)
{
    static const char map[] = "{\"type\": \"environment\", \"file\": \"e.exr\"}";
    const struct odd in_map = {WHITE, NULL, NULL, map};
    const struct odd in_sky = {WHITE, NULL, NULL, "{\"type\": \"sky\", \"radiance\": 0.75}"};
    const struct odd in_dark = {WHITE, NULL, NULL, "{\"type\": \"sky\", \"radiance\": 0}"};
    const struct odd textured = {
        "{\"type\": \"diffuse\", \"albedo\": {\"texture\": \"t\"}}, \"n\": " WHITE,
        "\"t\": {\"type\": \"image\", \"file\": \"e.exr\"}", NULL, NULL};
    const struct odd plain = {"{\"type\": \"diffuse\", \"albedo\": 0.75}", NULL, NULL, NULL};
    image_is(1, 1, .75f);
    ok(same(&in_map, &in_sky), "an environment map of one pixel is a sky");
    ok(same(&textured, &plain), "a texture of one pixel is its colour");
    image_is(8, 4, .75f);
    ok(same(&in_map, &in_sky), "and so is one whose pixels are all alike");
    image_is(8, 4, 0);
    ok(same(&in_map, &in_dark), "a black map is no light");
    image_is(1, 1, 0);
    ok(same(&in_map, &in_dark), "nor is one black pixel");
    image_is(4, 4, -3);
    ok(same(&in_map, &in_dark), "a map below 0 is black");
}

int main(void)
{
    index_of_one();
    no_width();
    white_at_the_ends();
    no_area();
    next_to_no_area();
    no_directions();
    small_images();
    buf_release(&file);
    arena_release(&arena);
    return tap_done();
}
