/* scene_share.c: shares of light above 1 are faults, or with settings.rescale become 1 with a
 * warning each; and how a job's status says it. SPDX-License-Identifier: MIT */
#include <stdio.h>
#include <string.h>

#include <jansson.h>

#include "common/scene.h"
#include "server/status_warnings.h"
#include "tests/tap.h"

static struct arena arena;
static struct scene scene;
static struct scene_errors errors;

static bool parse(const char *materials, const char *settings)
{
    static char text[65536];
    snprintf(text, sizeof text,
             "{\"smalti\": 1, \"film\": {\"width\": 64, \"height\": 48}, \"camera\": {\"type\": "
             "\"perspective\", \"fov_deg\": 90, \"look_at\": {\"from\": [1, 2, 3], \"to\": [1, 2, "
             "0]}}, \"textures\": {\"t\": {\"type\": \"checker\", \"colors\": [1, 0]}}, "
             "\"materials\": {%s}, \"shapes\": [], \"settings\": {%s}}",
             materials, settings);
    return scene_parse(&scene, text, strlen(text), SCENE_FROM_NET, &arena, &errors);
}

static bool is_rgb(rgb c, float r, float g, float b)
{
    return c[0] == r && c[1] == g && c[2] == b;
}

static bool warns(uint32_t i, const char *where, float was, float became)
{
    const struct scene_warning *w = &scene.warnings[i];
    return i < scene.warning_count && !strcmp(w->where, where) && w->was[0] == was &&
           w->became[0] == became;
}

static const char many[] =
    "\"a\": {\"type\": \"diffuse\", \"albedo\": [2, 1, 0.5]},"
    "\"b\": {\"type\": \"leaf\", \"reflectance\": [0.5, 0.5, 0], \"transmittance\": [1.5, 0, 0]},"
    "\"c\": {\"type\": \"principled\", \"base_color\": 4, \"sheen_color\": 1},"
    "\"d\": {\"type\": \"plastic\", \"albedo\": {\"texture\": \"t\", \"scale\": 3}},"
    "\"e\": {\"type\": \"leaf\", \"reflectance\": {\"texture\": \"t\"}, \"transmittance\": 0.7}";

static void refused(void)
{
    ok(!parse(many, "\"rescale\": false") && errors.count == 3 &&
           !strcmp(errors.list[0].where, "/materials/a/albedo/0") &&
           !strcmp(errors.list[0].what, "expected a number in [0, 1], got 2"),
       "unless asked for, every share above 1 is a fault (%zu)", errors.count);
    ok(!parse("\"a\": {\"type\": \"leaf\", \"reflectance\": 0.7, \"transmittance\": 0.7}", "") &&
           !strcmp(errors.list[0].what,
                   "expected reflectance + transmittance of at most 1 in every "
                   "channel, got 1.4, 1.4, 1.4"),
       "and so are two that are more than 1 together");
}

static void rescaled(void)
{
    const bool good = parse(many, "\"rescale\": true");
    ok(good && scene.warning_count == 4, "asked for, each is rescaled with a warning (%u)",
       scene.warning_count);
    if (!good)
        return;
    const struct material *m = scene.materials;
    ok(is_rgb(m[0].diffuse.albedo, 1, .5f, .25f) && warns(0, "/materials/a/albedo", 2, 1) &&
           !strcmp(scene.warnings[0].what, "more light than there is: was 2, 1, 0.5, became 1, "
                                           "0.5, 0.25"),
       "a colour keeps its hue: %s", scene.warnings[0].what);
    ok(is_rgb(m[1].leaf.reflectance, .25f, .25f, 0) &&
           is_rgb(m[1].leaf.transmittance, .75f, 0, 0) &&
           warns(1, "/materials/b/reflectance", .5f, .25f) &&
           warns(2, "/materials/b/transmittance", 1.5f, .75f),
       "two that share the light, by the same factor");
    ok(is_rgb(m[2].principled.base_color, 1, 1, 1) && warns(3, "/materials/c/base_color", 4, 1) &&
           is_rgb(m[2].principled.sheen_color, 1, 1, 1),
       "what is 1 stays as it is");
    ok(is_rgb(m[3].plastic.albedo, 1, 1, 1) && scene.slots[0].hi == 1,
       "textures are kept below 1 where they are looked at");
}

static void limits(void)
{
    ok(!parse("\"a\": {\"type\": \"diffuse\", \"albedo\": -0.1}", "\"rescale\": true") &&
           !strcmp(errors.list[0].what, "expected a number in [0, 1000000], got -0.1"),
       "less than nothing is a fault all the same");
    ok(!parse("\"a\": {\"type\": \"diffuse\", \"albedo\": 1}", "\"rescale\": 1") &&
           !strcmp(errors.list[0].where, "/settings/rescale") &&
           !strcmp(errors.list[0].what, "expected true or false, got 1"),
       "rescale is true or false");
    ok(!parse("\"a\": {\"type\": \"principled\", \"base_color\": 1, \"metallic\": 1.5}",
              "\"rescale\": true"),
       "what is no share of light is not rescaled");
    ok(parse("\"a\": {\"type\": \"diffuse\", \"albedo\": 1}", "\"rescale\": true") &&
           scene.warning_count == 0,
       "nothing above 1, no warning");
}

static void told(void)
{
    static char materials[32768], text[2048], small[450];
    ok(parse(many, "\"rescale\": true"), "the document again");
    status_warnings_print(&scene, text, sizeof text);
    json_t *list = json_loads(text, 0, NULL), *second = json_array_get(list, 1);
    ok(json_array_size(list) == 4 &&
           !strcmp(json_string_value(json_object_get(second, "pointer")),
                   "/materials/b/reflectance") &&
           json_real_value(json_array_get(json_object_get(second, "was"), 0)) == .5 &&
           json_real_value(json_array_get(json_object_get(second, "became"), 0)) == .25,
       "a status has them as JSON");
    json_decref(list);
    size_t n = 0;
    for (int i = 0; i < 300; i++)
        n += (size_t)snprintf(materials + n, sizeof materials - n,
                              "%s\"m%d\": {\"type\": \"diffuse\", \"albedo\": 2}", i ? "," : "", i);
    ok(parse(materials, "\"rescale\": true") && scene.warning_count == 300, "300 of them");
    status_warnings_print(&scene, small, sizeof small);
    list = json_loads(small, 0, NULL);
    const json_t *last = json_array_get(list, json_array_size(list) - 1);
    ok(json_array_size(list) == 3 &&
           !strcmp(json_string_value(json_object_get(last, "detail")), "and 298 more warnings"),
       "of too many the first, and how many there are besides: %s", small);
    json_decref(list);
    ok(parse("", "") && (status_warnings_print(&scene, small, sizeof small), !*small),
       "of none, nothing");
}

int main(void)
{
    refused();
    rescaled();
    limits();
    told();
    arena_release(&arena);
    return tap_done();
}
