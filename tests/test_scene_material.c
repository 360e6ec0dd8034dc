/* What valid documents say of diffuse surfaces, layers and materials made of others, and what
 * defaults these get. The rest of the reader: test_scene.c.
 * SPDX-License-Identifier: MIT */
#include "common/scene.h"

#include <stdio.h>
#include <string.h>

#include "tests/tap.h"

static struct arena arena;
static struct scene scene;

static bool parse(const char *materials)
{
    static char json[4096];
    struct scene_errors errors;
    snprintf(json, sizeof json,
             "{\"smalti\": 1, \"film\": {\"width\": 64, \"height\": 48}, \"camera\": {\"type\": "
             "\"perspective\", \"fov_deg\": 90, \"look_at\": {\"from\": [1, 2, 3], \"to\": [1, 2, "
             "0]}}, \"shapes\": [], \"materials\": {%s}}",
             materials);
    const bool good = scene_parse(&scene, json, strlen(json), SCENE_FROM_DISK, &arena, &errors);
    for (size_t i = 0; !good && i < errors.count && i < 5; i++)
        diag("%s: %s", errors.list[i].where, errors.list[i].what);
    return good;
}

static bool is_rgb(rgb c, double r, double g, double b)
{
    return c[0] == (float)r && c[1] == (float)g && c[2] == (float)b;
}

static void diffuse(void)
{
    ok(parse("\"a\": {\"type\": \"rough_diffuse\", \"albedo\": [0.1, 0.2, 1], \"roughness\": "
             "0.5}, \"b\": {\"type\": \"retroreflector\", \"alpha\": 0.25}, \"c\": {\"type\": "
             "\"leaf\", \"reflectance\": 0.1, \"transmittance\": [0.9, 0.5, 0]}"),
       "rough diffuse, retroreflector, leaf");
    const struct material *m = scene.materials;
    ok(m[0].kind == MATERIAL_ROUGH_DIFFUSE && is_rgb(m[0].rough_diffuse.albedo, .1, .2, 1) &&
           m[0].rough_diffuse.roughness == .5f,
       "rough diffuse");
    ok(m[1].kind == MATERIAL_RETROREFLECTOR && is_rgb(m[1].retro.reflectance, 1, 1, 1) &&
           m[1].retro.alpha == .25f,
       "a retroreflector, white by default");
    ok(m[2].kind == MATERIAL_LEAF && is_rgb(m[2].leaf.reflectance, .1, .1, .1) &&
           is_rgb(m[2].leaf.transmittance, .9, .5, 0),
       "a leaf; parts that add up to 1 are not too much");
}

static void coats(void)
{
    ok(parse("\"a\": {\"type\": \"plastic\", \"albedo\": 0.5}, \"b\": {\"type\": \"plastic\", "
             "\"albedo\": 1, \"ior\": 1.1, \"alpha\": 0.25}"),
       "plastic");
    const struct material *m = scene.materials;
    ok(m[0].kind == MATERIAL_PLASTIC && m[0].plastic.albedo[1] == .5f && m[0].plastic.ior == 1.5f &&
           m[0].plastic.alpha == 0,
       "smooth, and of 1.5, by default");
    ok(parse("\"a\": {\"type\": \"cloth\", \"albedo\": 0.5}") &&
           scene.materials[0].kind == MATERIAL_CLOTH && scene.materials[0].cloth.color[0] == 1 &&
           scene.materials[0].cloth.roughness == .3f,
       "cloth, velvet by default");
    ok(parse("\"a\": {\"type\": \"cloth\", \"albedo\": 0.5, \"color\": 0.25, \"roughness\": 1}") &&
           scene.materials[0].cloth.color[2] == .25f && scene.materials[0].cloth.roughness == 1,
       "or as it says");
}

static void plastics(void)
{
    ok(parse("\"a\": {\"type\": \"mirror\"}, \"b\": {\"type\": \"plastic\", "
             "\"albedo\": 1, \"ior\": 1.1, \"alpha\": 0.25}"),
       "a rough plastic");
    const struct material *m = scene.materials;
    ok(m[1].plastic.ior == 1.1f && m[1].plastic.alpha == .25f, "or as it says");
}

static void made_of_others(void)
{
    ok(parse("\"m\": {\"type\": \"mix\", \"first\": \"t\", \"second\": \"k\", \"amount\": 0.25}, "
             "\"k\": {\"type\": \"mask\", \"material\": \"a\", \"opacity\": 0.5}, "
             "\"t\": {\"type\": \"two_sided\", \"front\": \"a\", \"back\": \"b\"}, "
             "\"a\": {\"type\": \"mirror\"}, \"b\": {\"type\": \"diffuse\", \"albedo\": 1}"),
       "mix, mask, two sided; before what they are made of");
    const struct material *m = scene.materials;
    ok(m[0].kind == MATERIAL_MIX && m[0].mix.first == 2 && m[0].mix.second == 1 &&
           m[0].mix.amount == .25f,
       "a mix finds both by name");
    ok(m[1].kind == MATERIAL_MASK && m[1].mask.of == 3 && m[1].mask.opacity == .5f, "a mask");
    ok(m[2].kind == MATERIAL_TWO_SIDED && m[2].two_sided.front == 3 && m[2].two_sided.back == 4,
       "two sides");
    ok(parse("\"0\": {\"type\": \"mirror\"}, "
             "\"1\": {\"type\": \"mask\", \"material\": \"0\", \"opacity\": 1}, "
             "\"2\": {\"type\": \"mask\", \"material\": \"1\", \"opacity\": 1}, "
             "\"3\": {\"type\": \"mask\", \"material\": \"2\", \"opacity\": 1}, "
             "\"4\": {\"type\": \"mask\", \"material\": \"3\", \"opacity\": 1}, "
             "\"5\": {\"type\": \"mask\", \"material\": \"4\", \"opacity\": 1}, "
             "\"6\": {\"type\": \"mask\", \"material\": \"5\", \"opacity\": 1}, "
             "\"7\": {\"type\": \"mask\", \"material\": \"6\", \"opacity\": 1}, "
             "\"8\": {\"type\": \"mask\", \"material\": \"7\", \"opacity\": 1}"),
       "eight deep");
}

static void principled(void)
{
    ok(parse("\"a\": {\"type\": \"principled\", \"base_color\": 0.5}, \"b\": {\"type\": "
             "\"principled\", \"base_color\": [1, 0.5, 0], \"metallic\": 0.25, \"roughness\": 0, "
             "\"ior\": 2, \"transmission\": 0.5, \"clearcoat\": 0.75, \"clearcoat_roughness\": 1, "
             "\"sheen_color\": [0.25, 0.5, 1], \"sheen_roughness\": 1}"),
       "principled");
    const struct material *m = scene.materials;
    ok(m[0].kind == MATERIAL_PRINCIPLED && m[0].principled.base_color[0] == .5f &&
           m[0].principled.metallic == 0 && m[0].principled.roughness == .5f &&
           m[0].principled.ior == 1.5f && m[0].principled.transmission == 0 &&
           m[0].principled.clearcoat == 0 && rgb_is_black(m[0].principled.sheen_color),
       "by default a plain plastic");
    ok(is_rgb(m[1].principled.base_color, 1, .5, 0) && m[1].principled.metallic == .25f &&
           m[1].principled.roughness == 0 && m[1].principled.ior == 2 &&
           m[1].principled.transmission == .5f && m[1].principled.clearcoat == .75f &&
           m[1].principled.clearcoat_roughness == 1 &&
           is_rgb(m[1].principled.sheen_color, .25, .5, 1) && m[1].principled.sheen_roughness == 1,
       "or as it says");
}

int main(void)
{
    diffuse();
    coats();
    plastics();
    principled();
    made_of_others();
    arena_release(&arena);
    return tap_done();
}
