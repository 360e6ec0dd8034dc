/* scene_json.c and its neighbours: what valid documents mean, what defaults they get, and the
 * limits whose documents are too large to keep as files (tests/invalid has the rest).
 * SPDX-License-Identifier: MIT */
#include "common/scene.h"

#include <dirent.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/buf.h"
#include "common/layers.h"
#include "tests/tap.h"

static struct arena arena;
static struct scene scene;
static struct scene_errors errors;

static bool parse(const char *json)
{
    const bool good = scene_parse(&scene, json, strlen(json), SCENE_FROM_DISK, &arena, &errors);
    for (size_t i = 0; !good && i < errors.count && i < 5; i++)
        diag("%s: %s", errors.list[i].where, errors.list[i].what);
    return good;
}

#define FILM "\"film\": {\"width\": 64, \"height\": 48}"
#define CAMERA                                                                                     \
    "\"camera\": {\"type\": \"perspective\", \"fov_deg\": 90, "                                    \
    "\"look_at\": {\"from\": [1, 2, 3], \"to\": [1, 2, 0]}}"
#define HEAD            "{\"smalti\": 1, " FILM ", " CAMERA ", "
#define PLAIN(settings) HEAD "\"materials\": {}, \"shapes\": [], \"settings\": {" settings "}}"
#define GRAY            "\"materials\": {\"gray\": {\"type\": \"diffuse\", \"albedo\": 0.5}}, "

static bool is_vec(const float v[3], double x, double y, double z)
{
    return v[0] == (float)x && v[1] == (float)y && v[2] == (float)z;
}

static bool is_rgb(rgb c, double r, double g, double b)
{
    return c[0] == (float)r && c[1] == (float)g && c[2] == (float)b;
}

static bool near_point(const struct xform *x, const double p[3], const double want[3])
{
    const vec3 got = xform_point(x, vec3_make((float)p[0], (float)p[1], (float)p[2]));
    double worst = 0;
    for (int i = 0; i < 3; i++)
        worst = fmax(worst, fabs((double)got[i] - want[i]));
    if (!(worst <= 1e-6))
        diag("got %g %g %g, want %g %g %g", (double)got[0], (double)got[1], (double)got[2], want[0],
             want[1], want[2]);
    return worst <= 1e-6;
}

static void defaults(void)
{
    ok(parse(HEAD "\"materials\": {}, \"shapes\": []}"), "the smallest document is valid");
    ok(!strcmp(scene.title, ""), "title defaults to the empty one");
    ok(scene.film.width_px == 64 && scene.film.height_px == 48, "film has its size");
    ok(scene.film.crop_x_begin == 0 && scene.film.crop_y_begin == 0 &&
           scene.film.crop_x_end == 64 && scene.film.crop_y_end == 48,
       "crop defaults to the whole film");
    ok(scene.film.filter == FILTER_BOX && scene.film.filter_radius_px == .5f,
       "filter defaults to a box of one pixel");
    ok(scene.settings.integrator == INTEGRATOR_AUTO && scene.settings.strategy == STRATEGY_MIS &&
           scene.settings.sampler == SAMPLER_SOBOL && scene.settings.max_bounces == 64 &&
           scene.settings.clamp == 0 && scene.settings.seed == 0,
       "settings default to auto, sobol, 64 bounces, seed 0");
    ok(scene.settings.target.spp == 64 && scene.settings.target.error == 0 &&
           scene.settings.target.seconds == 0,
       "target defaults to 64 samples per pixel");
    ok(scene.material_count == 0 && scene.shape_count == 0 && scene.light_count == 0 &&
           scene.mesh_count == 0,
       "an empty scene is empty");
}

static bool filtered(const char *filter)
{
    char json[1024];
    snprintf(json, sizeof json,
             "{\"smalti\": 1, \"film\": {\"width\": 64, \"height\": 48, \"filter\": %s}, " CAMERA
             ", \"materials\": {}, \"shapes\": []}",
             filter);
    return parse(json);
}

static void film_and_settings(void)
{
    ok(parse("{\"smalti\": 1.0, \"title\": \"B\\u00f6x\", \"film\": {\"width\": 640.0, "
             "\"height\": 4.8e2, \"filter\": {\"type\": \"tent\"}, \"crop\": [10, 20, 30, "
             "40]}, " CAMERA ", \"materials\": {}, \"shapes\": [], \"settings\": {\"integrator\": "
             "\"path\", \"max_bounces\": 0, \"clamp\": 10.5, \"seed\": 9007199254740991, "
             "\"target\": {\"error\": "
             "0.02, \"seconds\": 60}}}"),
       "whole numbers may be written as 640.0 and 4.8e2");
    ok(!strcmp(scene.title, "B\xc3\xb6x"), "title is UTF-8");
    ok(scene.film.width_px == 640 && scene.film.height_px == 480, "and mean 640 and 480");
    ok(scene.film.filter == FILTER_TENT && scene.film.filter_radius_px == 1,
       "a tent's radius defaults to 1");
    ok(scene.film.crop_x_begin == 10 && scene.film.crop_y_begin == 20 &&
           scene.film.crop_x_end == 30 && scene.film.crop_y_end == 40,
       "crop is x_begin, y_begin, x_end, y_end");
    ok(scene.film.layers == 0, "no layers are made unless asked for");
    ok(scene.settings.clamp == 10.5f, "a clamp is read");
    ok(scene.settings.max_bounces == 0 && scene.settings.seed == 9007199254740991u,
       "bounces and seed reach the ends of their ranges");
    ok(scene.settings.target.error == .02 && scene.settings.target.seconds == 60 &&
           scene.settings.target.spp == SCENE_MAX_SPP,
       "beside another target, samples are unlimited");
    const struct scene_film *film = &scene.film;
    ok(filtered("{\"type\": \"gaussian\"}") && film->filter == FILTER_GAUSSIAN &&
           film->filter_sigma_px == .5f && film->filter_radius_px == 1.5f &&
           filtered("{\"type\": \"gaussian\", \"radius\": 3, \"sigma\": 0.75}") &&
           film->filter_sigma_px == .75f && film->filter_radius_px == 3,
       "gaussian, by default of sigma 0.5");
    ok(filtered("{\"type\": \"blackman_harris\"}") && film->filter == FILTER_BLACKMAN_HARRIS &&
           film->filter_radius_px == 1.5f,
       "blackman_harris");
    ok(filtered("{\"type\": \"mitchell\"}") && film->filter == FILTER_MITCHELL &&
           film->filter_b == 1 / 3.f && film->filter_c == 1 / 3.f && film->filter_radius_px == 2 &&
           filtered("{\"type\": \"mitchell\", \"c\": 0.5, \"b\": 0}") && film->filter_b == 0 &&
           film->filter_c == .5f,
       "mitchell, by default of b = c = 1/3");
    ok(parse("{\"smalti\": 1, \"film\": {\"width\": 16384, \"height\": 16384, \"crop\": "
             "[16000, 16000, 16384, 16384]}, " CAMERA ", \"materials\": {}, \"shapes\": []}"),
       "the limit of pixels counts those that are rendered");
    ok(parse("{\"smalti\": 1, \"film\": {\"width\": 9, \"height\": 9, \"layers\": [\"material\", "
             "\"albedo\"], \"bounces\": 3}, " CAMERA ", \"materials\": {}, \"shapes\": []}") &&
           scene.film.layers == layers_make(LAYER_MATERIAL | LAYER_ALBEDO, 3),
       "layers are a set, bounces a count");
}

static void methods(void)
{
    const struct scene_settings *s = &scene.settings;
    ok(parse(HEAD "\"materials\": {}, \"shapes\": [], \"settings\": {\"integrator\": \"direct\", "
                  "\"strategy\": \"bsdf\", \"sampler\": \"stratified\"}}") &&
           s->integrator == INTEGRATOR_DIRECT && s->strategy == STRATEGY_BSDF &&
           s->sampler == SAMPLER_STRATIFIED,
       "direct light, by directions, stratified");
    ok(parse(PLAIN("\"strategy\": \"light\"")) && s->integrator == INTEGRATOR_PATH &&
           s->strategy == STRATEGY_LIGHT,
       "a strategy alone is of paths");
    ok(parse(PLAIN("\"seed\": 1")) && s->integrator == INTEGRATOR_AUTO,
       "other settings leave the method to a plan");
    ok(parse(HEAD "\"materials\": {}, \"shapes\": [], \"settings\": {\"integrator\": \"whitted\", "
                  "\"strategy\": \"light\", \"sampler\": \"independent\"}}") &&
           s->integrator == INTEGRATOR_WHITTED && s->strategy == STRATEGY_LIGHT &&
           s->sampler == SAMPLER_INDEPENDENT,
       "whitted, by lights, independent");
}

static void camera(void)
{
    parse(HEAD "\"materials\": {}, \"shapes\": []}");
    const struct xform *x = &scene.camera.to_world;
    near((double)scene.camera.fov_y_rad, 1.5707963267948966, 1e-7, "90 degrees are pi/2");
    ok(near_point(x, (double[]){0, 0, 0}, (double[]){1, 2, 3}), "the camera stands at `from`");
    ok(near_point(x, (double[]){0, 0, -3}, (double[]){1, 2, 0}), "it looks at `to` along its -z");
    ok(near_point(x, (double[]){1, 1, 0}, (double[]){2, 3, 3}), "x is right, y is up");
    ok(parse("{\"smalti\": 1, " FILM ", \"camera\": {\"type\": \"perspective\", \"fov_deg\": 1, "
             "\"look_at\": {\"from\": [0, 0, 0], \"to\": [0, -2, 0], \"up\": [0, 5, -7]}}, "
             "\"materials\": {}, \"shapes\": []}"),
       "up need not be perpendicular");
    ok(near_point(x, (double[]){0, 0, -1}, (double[]){0, -1, 0}) &&
           near_point(x, (double[]){0, 1, 0}, (double[]){0, 0, -1}) &&
           near_point(x, (double[]){1, 0, 0}, (double[]){1, 0, 0}),
       "it is made so");
    ok(parse("{\"smalti\": 1, " FILM ", \"camera\": {\"type\": \"perspective\", \"fov_deg\": 1, "
             "\"matrix\": [0.707107, 0, 0.707107, 4, 0, 1, 0, 5, -0.707107, 0, 0.707107, 6, "
             "0, 0, 0, 1]}, \"materials\": {}, \"shapes\": []}"),
       "a matrix of six digits is rigid enough");
    const double h = sqrt(.5);
    ok(near_point(x, (double[]){1, 0, 0}, (double[]){4 + h, 5, 6 - h}), "and is made exact");
}

static bool seen_by(const char *camera)
{
    char json[1024];
    snprintf(json, sizeof json,
             "{\"smalti\": 1, " FILM ", \"camera\": {\"look_at\": {\"from\": [1, 2, 3], \"to\": "
             "[1, 2, 0]}, %s}, \"materials\": {}, \"shapes\": []}",
             camera);
    return parse(json);
}

static void cameras(void)
{
    const struct scene_camera *c = &scene.camera;
    ok(seen_by("\"type\": \"thin_lens\", \"fov_deg\": 90, \"aperture_radius\": 0.25, "
               "\"focus_distance\": 4") &&
           c->kind == CAMERA_THIN_LENS && c->lens_radius == .25f && c->focus == 4 && !c->blades &&
           fabsf(c->fov_y_rad - 1.5707963f) < 1e-6f,
       "thin lens, round by default");
    ok(seen_by("\"type\": \"thin_lens\", \"fov_deg\": 90, \"aperture_radius\": 4, "
               "\"focus_distance\": 4, \"blades\": 7, \"blade_angle_deg\": -90") &&
           c->blades == 7 && c->blades_turn == .75f,
       "as wide as its focus is far; seven blades, turned");
    ok(seen_by("\"type\": \"orthographic\", \"width\": 2.5") && c->kind == CAMERA_ORTHOGRAPHIC &&
           c->width == 2.5f && c->height == 0,
       "orthographic by its width");
    ok(seen_by("\"type\": \"orthographic\", \"height\": 2") && c->width == 0 && c->height == 2,
       "or its height");
    ok(seen_by("\"type\": \"panoramic\"") && c->kind == CAMERA_PANORAMIC &&
           near_point(&c->to_world, (double[]){0, 0, -3}, (double[]){1, 2, 0}),
       "panoramic");
}

static void materials(void)
{
    ok(parse(HEAD
             "\"materials\": {\"z\": {\"type\": \"diffuse\", \"albedo\": [0.1, 0.2, 1]}, "
             "\"a\": {\"type\": \"mirror\"}, \"m\": {\"type\": \"dielectric\", \"ior\": 1.5}, "
             "\"b\": {\"type\": \"conductor\", \"eta\": [0.2, 0.4, 1.4], \"k\": 3, \"alpha\": "
             "0}}, \"shapes\": [{\"type\": \"sphere\", \"material\": \"m\", \"center\": [1, 2, "
             "3], \"radius\": 4}]}"),
       "every kind of material");
    const struct material *m = scene.materials;
    ok(scene.material_count == 4 && !strcmp(m[0].name, "z") && !strcmp(m[3].name, "b"),
       "materials keep their order");
    ok(m[0].kind == MATERIAL_DIFFUSE && is_rgb(m[0].diffuse.albedo, .1, .2, 1), "diffuse");
    ok(m[1].kind == MATERIAL_MIRROR && is_rgb(m[1].mirror.reflectance, 1, 1, 1),
       "mirror, white by default");
    ok(m[2].kind == MATERIAL_DIELECTRIC && m[2].dielectric.ior == 1.5f &&
           m[2].dielectric.alpha == 0,
       "dielectric, smooth by default");
    ok(m[3].kind == MATERIAL_CONDUCTOR && is_rgb(m[3].conductor.eta, .2, .4, 1.4) &&
           is_rgb(m[3].conductor.k, 3, 3, 3) && m[3].conductor.alpha == 0,
       "conductor; one number is gray");
    ok(scene.shapes[0].material == 2, "a shape finds its material by name");
    ok(parse(HEAD "\"materials\": {\"m\": {\"type\": \"dielectric\", \"alpha\": 0.25, \"ior\": "
                  "2}}, \"shapes\": []}") &&
           scene.materials[0].dielectric.alpha == .25f,
       "rough dielectric");
}

static void shapes(void)
{
    ok(parse(
           HEAD GRAY
           "\"shapes\": [{\"type\": \"sphere\", \"material\": \"gray\", \"center\": [1, 2, -0], "
           "\"radius\": 4, \"emission\": [1, 2, 3]}, "
           "{\"type\": \"disc\", \"material\": \"gray\", \"center\": [0, 1, 0], \"normal\": [0, "
           "-2, 0], \"radius\": 0.5}, "
           "{\"type\": \"quad\", \"material\": \"gray\", \"vertices\": [[0, 0, 0], [1, 0, 0], "
           "[2, 3, 0], [0, 1, 0]]}, "
           "{\"type\": \"mesh\", \"material\": \"gray\", \"vertices\": [[0, 0, 0], [1, 0, 0], [0, "
           "1, 0], [0, 0, 1]], \"triangles\": [[0, 1, 2], [3, 2, 1]]}, "
           "{\"type\": \"mesh\", \"material\": \"gray\", \"file\": \"a/b.OBJ\"}, "
           "{\"type\": \"mesh\", \"material\": \"gray\", \"format\": \"ply\", \"asset\": "
           "\"0123456789abcdef0123456789abcdef0123456789abcdef0123456789abcdef\"}, "
           "{\"type\": \"cylinder\", \"material\": \"gray\", \"from\": [100, 0, 7], \"to\": "
           "[100.0000001, 0, 7.0000002], \"radius\": 0.5, \"emission\": 2}]}"),
       "every kind of shape");
    const struct shape *s = scene.shapes;
    ok(s[0].kind == SHAPE_SPHERE && is_vec(s[0].sphere.center, 1, 2, 0) &&
           s[0].sphere.radius == 4 && is_rgb(s[0].emission, 1, 2, 3),
       "sphere, which shines");
    ok(!signbit(s[0].sphere.center[2]), "minus zero is zero");
    ok(s[1].kind == SHAPE_DISC && is_vec(s[1].disc.normal, 0, -1, 0) && s[1].disc.radius == .5f,
       "disc; its normal is made a unit");
    ok(rgb_is_black(s[1].emission), "shapes are dark by default");
    ok(s[2].kind == SHAPE_QUAD && is_vec(s[2].quad.vertices[2], 2, 3, 0), "quad");
    ok(s[6].kind == SHAPE_CYLINDER && is_vec(s[6].cylinder.from, 100, 0, 7) &&
           s[6].cylinder.radius == .5f && is_rgb(s[6].emission, 2, 2, 2),
       "cylinder");
    near((double)(s[6].cylinder.axis[2] / s[6].cylinder.axis[0]), 2, 1e-6,
         "whose axis is not that of its rounded ends");
    const struct mesh *m = scene.meshes;
    ok(scene.mesh_count == 3 && s[3].mesh.mesh == 0 && s[5].mesh.mesh == 2,
       "meshes are numbered in document order");
    ok(m[0].format == MESH_INLINE && m[0].vertex_count == 4 && m[0].triangle_count == 2 &&
           is_vec(m[0].vertices + 9, 0, 0, 1) && m[0].indices[3] == 3,
       "mesh in the document");
    ok(m[1].format == MESH_OBJ && !strcmp(m[1].file, "a/b.OBJ") && !*m[1].asset,
       "mesh in a file; its format by the ending, in any case");
    ok(m[2].format == MESH_PLY && !m[2].file && !strncmp(m[2].asset, "0123456789ab", 12),
       "mesh in an asset");
}

static bool sphere_at(const char *transform)
{
    char json[1024];
    snprintf(json, sizeof json,
             HEAD GRAY
             "\"shapes\": [{\"type\": \"sphere\", \"material\": \"gray\", \"center\": [0, "
             "0, 0], \"radius\": 1, \"transform\": %s}]}",
             transform);
    return parse(json);
}

static void transforms(void)
{
    const double p[3] = {1, 2, 3};
    ok(sphere_at("[]") && near_point(&scene.shapes[0].to_world, p, p), "no steps: nothing moves");
    ok(sphere_at("[{\"translate\": [1, 0, 0]}, {\"scale\": 2}]") &&
           near_point(&scene.shapes[0].to_world, p, (double[]){4, 4, 6}),
       "steps are applied first to last");
    ok(sphere_at("[{\"scale\": 2}, {\"translate\": [1, 0, 0]}]") &&
           near_point(&scene.shapes[0].to_world, p, (double[]){3, 4, 6}),
       "in either order");
    ok(sphere_at("[{\"scale\": [-1, 1, 1]}]"), "a sphere may be mirrored");
    ok(sphere_at("[0, -2, 0, 5, 2, 0, 0, 6, 0, 0, 2, 7, 0, 0, 0, 1]") &&
           near_point(&scene.shapes[0].to_world, p, (double[]){1, 8, 13}),
       "a matrix is by rows");
    ok(sphere_at("[{\"rotate_deg\": {\"axis\": [0, 0, 7], \"angle\": 90}}]") &&
           near_point(&scene.shapes[0].to_world, p, (double[]){-2, 1, 3}),
       "a rotation is counter-clockwise against its axis");
    const struct xform *x = &scene.shapes[0].to_world; /* of the last document parsed */
    ok(x->m[0][0] == 0 && x->m[0][1] == -1 && x->m[1][0] == 1, "a quarter turn is exact");
    double worst = 0;
    for (int deg = -725; deg <= 725; deg += 5) {
        char step[128];
        snprintf(step, sizeof step, "[{\"rotate_deg\": {\"axis\": [1, 2, 2], \"angle\": %d.5}}]",
                 deg);
        if (!sphere_at(step))
            worst = (double)INFINITY;
        x = &scene.shapes[0].to_world;
        const double a = (deg < 0 ? deg - .5 : deg + .5) * acos(-1) / 180, c = cos(a), s = sin(a);
        const double k[3] = {1. / 3, 2. / 3, 2. / 3};
        worst = fmax(worst, fabs((double)x->m[0][1] - ((1 - c) * k[0] * k[1] - s * k[2])));
        worst = fmax(worst, fabs((double)x->m[2][2] - (c + (1 - c) * k[2] * k[2])));
    }
    near(worst, 0, 6e-8, "rotations agree with libm to the last bit of a float");
    ok(sphere_at("[{\"rotate_deg\": {\"axis\": [0, 1, 0], \"angle\": 36000000030}}]") &&
           fabs((double)scene.shapes[0].to_world.m[0][2] - .5) < 1e-7,
       "turns without number are none");
}

static void lights(void)
{
    ok(parse(
           HEAD
           "\"materials\": {}, \"shapes\": [], \"lights\": [{\"type\": \"sky\", "
           "\"radiance\": [1, 2, 3]}, {\"type\": \"point\", \"position\": [4, 5, 6], "
           "\"intensity\": 7}, {\"type\": \"distant\", \"direction\": [0, -3, -4], "
           "\"irradiance\": 0}, {\"type\": \"spot\", \"position\": [1, 2, 3], \"direction\": "
           "[0, 0, 2], \"intensity\": [4, 5, 6], \"inner_deg\": 30, \"outer_deg\": 60}, "
           "{\"type\": \"sun\", \"direction\": [0, -1, 0], \"diameter_deg\": 2, \"radiance\": 3}, "
           "{\"type\": \"sun\", \"direction\": [0, -1, 0], \"diameter_deg\": 180, "
           "\"irradiance\": 4}, {\"type\": \"environment\", \"file\": \"a.EXR\", "
           "\"scale\": [1, 2, 3], \"transform\": [{\"rotate_deg\": {\"axis\": [0, 1, 0], "
           "\"angle\": 90}}]}]}"),
       "every kind of light");
    const struct light *l = scene.lights;
    ok(scene.light_count == 7 && l[0].kind == LIGHT_SKY && is_rgb(l[0].sky.radiance, 1, 2, 3),
       "sky");
    ok(l[1].kind == LIGHT_POINT && is_vec(l[1].point.position, 4, 5, 6) &&
           is_rgb(l[1].point.intensity, 7, 7, 7),
       "point");
    ok(l[2].kind == LIGHT_DISTANT && is_vec(l[2].distant.direction, 0, -.6, -.8), "distant");
    ok(l[3].kind == LIGHT_SPOT && is_vec(l[3].spot.position, 1, 2, 3) &&
           is_vec(l[3].spot.direction, 0, 0, 1) && is_rgb(l[3].spot.intensity, 4, 5, 6) &&
           fabs((double)l[3].spot.inner_rad - .5235987756) < 1e-7 &&
           fabs((double)l[3].spot.outer_rad - 1.0471975512) < 1e-7,
       "spot");
    ok(l[4].kind == LIGHT_SUN && fabs((double)l[4].sun.radius_rad - .0174532925) < 1e-9 &&
           is_rgb(l[4].sun.radiance, 3, 3, 3) && is_rgb(l[4].sun.irradiance, 0, 0, 0) &&
           is_rgb(l[5].sun.irradiance, 4, 4, 4) && is_rgb(l[5].sun.radiance, 0, 0, 0),
       "suns by radiance and by irradiance");
    ok(l[6].kind == LIGHT_ENVIRONMENT && l[6].environment.image == 0 && scene.image_count == 1 &&
           is_rgb(l[6].environment.scale, 1, 2, 3) && l[6].environment.to_world.m[0][2] == 1 &&
           l[6].environment.to_world.m[2][0] == -1,
       "environment");
}

static bool one_error(enum err_code code, const char *where, const char *what)
{
    const struct scene_error *e = errors.list;
    const bool same =
        errors.count == 1 && e->code == code && !strcmp(e->where, where) && !strcmp(e->what, what);
    if (!same && errors.count)
        diag("got %s: %s", e->where, e->what);
    return same;
}

static void text_append(struct buf *b, const char *text)
{
    buf_append(b, text, strlen(text));
}

/* HEAD, then `before`, `count` times `item`, `after`. */
static bool parse_many(const char *before, const char *item, size_t count, const char *after)
{
    struct buf b = {0};
    text_append(&b, HEAD);
    text_append(&b, before);
    for (size_t i = 0; i < count; i++) {
        char text[64];
        snprintf(text, sizeof text, "%s", i ? "," : "");
        text_append(&b, text);
        if (strstr(item, "%zu")) {
            snprintf(text, sizeof text, "\"m%zu\": {\"type\": \"mirror\"}", i);
            text_append(&b, text);
        } else {
            text_append(&b, item);
        }
    }
    text_append(&b, after);
    const bool good =
        scene_parse(&scene, (const char *)b.data, b.size, SCENE_FROM_DISK, &arena, &errors);
    buf_release(&b);
    return good;
}

static void limits(void)
{
    char *spaces = malloc(SCENE_MAX_BYTES + 1);
    memset(spaces, ' ', SCENE_MAX_BYTES + 1);
    ok(!scene_parse(&scene, spaces, SCENE_MAX_BYTES + 1, SCENE_FROM_DISK, &arena, &errors) &&
           one_error(ERR_LIMIT, "", "expected a document of at most 4194304 bytes, got 4194305"),
       "a document of too many bytes is not even looked at");
    memset(spaces, '[', SCENE_MAX_BYTES);
    ok(!scene_parse(&scene, spaces, SCENE_MAX_BYTES, SCENE_FROM_DISK, &arena, &errors) &&
           one_error(ERR_LIMIT, "line 1, column 33", "nested deeper than 32 levels"),
       "neither is the bottom of a deep one");
    free(spaces);

    ok(!parse_many("\"materials\": {}, \"shapes\": [", "0", SCENE_MAX_SHAPES + 1, "]}") &&
           one_error(ERR_LIMIT, "/shapes",
                     "expected an array of at most 100000 shapes, got an array of 100001"),
       "too many shapes");
    ok(!parse_many("\"materials\": {}, \"shapes\": [], \"lights\": [", "0", SCENE_MAX_LIGHTS + 1,
                   "]}") &&
           one_error(ERR_LIMIT, "/lights",
                     "expected an array of at most 100000 lights, got an array of 100001"),
       "too many lights");
    ok(!parse_many("\"shapes\": [], \"materials\": {", "%zu", SCENE_MAX_MATERIALS + 1, "}}") &&
           one_error(ERR_LIMIT, "/materials", "expected at most 10000 materials, got 10001"),
       "too many materials");
    ok(parse_many("\"shapes\": [{\"type\": \"sphere\", \"material\": \"m9999\", \"center\": [0, 0, "
                  "0], \"radius\": 1}], \"materials\": {",
                  "%zu", SCENE_MAX_MATERIALS, "}}") &&
           scene.shapes[0].material == 9999,
       "as many as allowed are");
    ok(parse_many("\"materials\": {}, \"shapes\": [], \"lights\": [",
                  "{\"type\":\"sky\",\"radiance\":0}", SCENE_MAX_LIGHTS, "]}") &&
           scene.light_count == SCENE_MAX_LIGHTS,
       "lights, too");
}

/* Every example document is valid. */
static void examples(void)
{
    struct dirent **list;
    const int count = scandir("scenes", &list, NULL, alphasort);
    int seen = 0;
    for (int i = 0; i < count; i++) {
        const char *dot = strrchr(list[i]->d_name, '.');
        if (dot && !strcmp(dot, ".json")) {
            char path[512];
            struct err err;
            struct buf b = {0};
            snprintf(path, sizeof path, "scenes/%s", list[i]->d_name);
            const bool read = buf_read_file(&b, path, SCENE_MAX_BYTES, &err);
            buf_append(&b, "", 1);
            ok(read && parse((const char *)b.data), "%s is valid", path);
            buf_release(&b);
            seen++;
        }
        free(list[i]);
    }
    free(list);
    ok(seen >= 4, "there are examples (%d)", seen);
}

static void specification(void)
{
    struct buf b = {0};
    struct err err;
    const bool read = buf_read_file(&b, "docs/scene.md", SCENE_MAX_BYTES, &err);
    buf_append(&b, "", 1);
    char *begin = read ? strstr((char *)b.data, "```json\n") : NULL;
    char *end = begin ? strstr(begin + 8, "```") : NULL;
    if (end)
        *end = '\0';
    ok(end && parse(begin + 8) && scene.shape_count == 3, "the example of docs/scene.md is valid");
    buf_release(&b);
}

int main(void)
{
    defaults();
    film_and_settings();
    methods();
    camera();
    cameras();
    materials();
    shapes();
    transforms();
    lights();
    limits();
    examples();
    specification();
    arena_release(&arena);
    return tap_done();
}
