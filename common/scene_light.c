/* Lights that are no shapes.
 * SPDX-License-Identifier: MIT */
#include "common/scene_check.h"
#include "common/scene_read.h"

static const struct scene_range brightness = {0, SCENE_MAX_ABS, false};
static const struct scene_range coordinate = {-SCENE_MAX_ABS, SCENE_MAX_ABS, false};
static const double radians = 3.14159265358979323846 / 180; /* of a degree */

static bool read_direction(struct scene_doc *doc, const struct scene_at *at, const char *key,
                           float out[3])
{
    double v[3] = {0, 0, 1};
    if (!scene_key_numbers(doc, at, key, coordinate, v, 3))
        return false;
    const double length = scene_length(v);
    if (!(length > 0)) {
        struct scene_at member;
        return scene_at_member(at, key, &member) &&
               scene_doc_fault(doc, &member, ERR_INPUT, "expected a direction, got [0, 0, 0]");
    }
    for (int i = 0; i < 3; i++)
        out[i] = (float)(v[i] / length);
    return true;
}

static void read_position(struct scene_doc *doc, const struct scene_at *at, float out[3])
{
    double p[3] = {0};
    scene_key_numbers(doc, at, "position", coordinate, p, 3);
    for (int i = 0; i < 3; i++)
        out[i] = (float)p[i];
}

static void read_spot(struct scene_doc *doc, const struct scene_at *at, struct light *l)
{
    static const struct scene_key keys[] = {{"type", true},       {"position", true},
                                            {"direction", true},  {"intensity", true},
                                            {"inner_deg", false}, {"outer_deg", true}};
    double inner = 0, outer = 180;
    struct scene_at inner_at;
    scene_doc_object(doc, at, "a spot light", keys, countof(keys));
    read_position(doc, at, l->spot.position);
    read_direction(doc, at, "direction", l->spot.direction);
    scene_key_rgb(doc, at, "intensity", brightness, &l->spot.intensity);
    scene_key_number(doc, at, "inner_deg", (struct scene_range){0, 180, false}, &inner);
    scene_key_number(doc, at, "outer_deg", (struct scene_range){.01, 180, false}, &outer);
    if (inner > outer && scene_at_member(at, "inner_deg", &inner_at))
        scene_doc_fault(doc, &inner_at, ERR_INPUT,
                        "expected a number of at most \"outer_deg\", %.16g, got %.16g", outer,
                        inner);
    l->spot.inner_rad = (float)(inner * radians);
    l->spot.outer_rad = (float)(outer * radians);
}

static void read_sun(struct scene_doc *doc, const struct scene_at *at, struct light *l)
{
    static const struct scene_key keys[] = {{"type", true},
                                            {"direction", true},
                                            {"diameter_deg", true},
                                            {"radiance", false},
                                            {"irradiance", false}};
    double diameter = 1;
    struct scene_at found;
    scene_doc_object(doc, at, "a sun", keys, countof(keys));
    read_direction(doc, at, "direction", l->sun.direction);
    scene_key_number(doc, at, "diameter_deg", (struct scene_range){.01, 180, false}, &diameter);
    const bool has_radiance = scene_at_member(at, "radiance", &found);
    if (has_radiance == scene_at_member(at, "irradiance", &found))
        scene_doc_fault(doc, at, ERR_INPUT, "a sun needs \"radiance\" or \"irradiance\", got %s",
                        has_radiance ? "both" : "neither");
    scene_key_rgb(doc, at, "radiance", brightness, &l->sun.radiance);
    scene_key_rgb(doc, at, "irradiance", brightness, &l->sun.irradiance);
    l->sun.radius_rad = (float)(diameter / 2 * radians);
}

static void read_environment(struct scene_doc *doc, const struct scene_at *at, struct scene *scene,
                             struct light *l)
{
    static const struct scene_key keys[] = {{"type", true},   {"file", false},
                                            {"asset", false}, {"format", false},
                                            {"scale", false}, {"transform", false}};
    struct scene_xform x = scene_xform_identity();
    struct scene_at member;
    struct err err;
    scene_doc_object(doc, at, "an environment", keys, countof(keys));
    if (scene_read_image(doc, at, "an environment", scene, &l->environment.image) &&
        scene->images[l->environment.image].format != IMAGE_FORMAT_EXR &&
        (scene_at_member(at, "file", &member) || scene_at_member(at, "format", &member)))
        scene_doc_expected(doc, &member, ERR_INPUT, "an OpenEXR image");
    l->environment.scale = rgb_gray(1);
    scene_key_rgb(doc, at, "scale", brightness, &l->environment.scale);
    if (scene_at_member(at, "transform", &member) && scene_read_transform(doc, &member, &x)) {
        if (!scene_check_rigid(&x, &err))
            scene_doc_fault(doc, &member, err.code, "%s", err.text);
        else if (x.m[0][3] != 0 || x.m[1][3] != 0 || x.m[2][3] != 0)
            scene_doc_fault(doc, &member, ERR_INPUT,
                            "expected a rotation, got one that moves: an environment is far away");
    }
    l->environment.to_world = scene_xform_round(&x);
}

static void read_light(struct scene_doc *doc, const struct scene_at *at, struct scene *scene,
                       struct light *l)
{
    static const char *const kinds[] = {
        [LIGHT_SKY] = "sky",   [LIGHT_POINT] = "point", [LIGHT_DISTANT] = "distant",
        [LIGHT_SPOT] = "spot", [LIGHT_SUN] = "sun",     [LIGHT_ENVIRONMENT] = "environment"};
    static const struct scene_key sky[] = {{"type", true}, {"radiance", true}};
    static const struct scene_key point[] = {
        {"type", true}, {"position", true}, {"intensity", true}};
    static const struct scene_key distant[] = {
        {"type", true}, {"direction", true}, {"irradiance", true}};
    size_t kind;
    if (!scene_doc_kind(doc, at, "a light", kinds, countof(kinds), &kind))
        return;
    l->kind = (enum light_kind)kind;
    switch (l->kind) {
    case LIGHT_SKY:
        scene_doc_object(doc, at, "a sky light", sky, countof(sky));
        scene_key_rgb(doc, at, "radiance", brightness, &l->sky.radiance);
        return;
    case LIGHT_POINT:
        scene_doc_object(doc, at, "a point light", point, countof(point));
        read_position(doc, at, l->point.position);
        scene_key_rgb(doc, at, "intensity", brightness, &l->point.intensity);
        return;
    case LIGHT_DISTANT:
        scene_doc_object(doc, at, "a distant light", distant, countof(distant));
        read_direction(doc, at, "direction", l->distant.direction);
        scene_key_rgb(doc, at, "irradiance", brightness, &l->distant.irradiance);
        return;
    case LIGHT_SPOT:
        read_spot(doc, at, l);
        return;
    case LIGHT_SUN:
        read_sun(doc, at, l);
        return;
    case LIGHT_ENVIRONMENT:
        read_environment(doc, at, scene, l);
        return;
    }
}

/* One is enough for anything, and each may be a gigabyte. */
static void check_environments(struct scene_doc *doc, const struct scene_at *at,
                               const struct scene *scene)
{
    bool has = false;
    for (uint32_t i = 0; i < scene->light_count; i++) {
        if (scene->lights[i].kind != LIGHT_ENVIRONMENT)
            continue;
        const struct scene_at item = scene_at_item(at, i);
        if (has)
            scene_doc_fault(doc, &item, ERR_LIMIT, "expected one environment at most");
        has = true;
    }
}

void scene_read_lights(struct scene_doc *doc, const struct scene_at *at, struct scene *scene)
{
    if (!scene_doc_array(doc, at, "lights", 0, SCENE_MAX_LIGHTS))
        return;
    const size_t count = scene_at_count(at);
    scene->lights = arena_new(doc->arena, struct light, count);
    scene->light_count = (uint32_t)count;
    for (size_t i = 0; i < count; i++) {
        const struct scene_at item = scene_at_item(at, i);
        read_light(doc, &item, scene, &scene->lights[i]);
    }
    check_environments(doc, at, scene);
}
