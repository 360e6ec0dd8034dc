/* Lights that are no shapes.
 * SPDX-License-Identifier: MIT */
#include "common/scene_check.h"
#include "common/scene_read.h"

static const struct scene_range brightness = {0, SCENE_MAX_ABS, false};
static const struct scene_range coordinate = {-SCENE_MAX_ABS, SCENE_MAX_ABS, false};

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

static void read_light(struct scene_doc *doc, const struct scene_at *at, struct light *l)
{
    static const char *const kinds[] = {
        [LIGHT_SKY] = "sky", [LIGHT_POINT] = "point", [LIGHT_DISTANT] = "distant"};
    static const struct scene_key sky[] = {{"type", true}, {"radiance", true}};
    static const struct scene_key point[] = {
        {"type", true}, {"position", true}, {"intensity", true}};
    static const struct scene_key distant[] = {
        {"type", true}, {"direction", true}, {"irradiance", true}};
    size_t kind;
    double p[3] = {0};
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
        scene_key_numbers(doc, at, "position", coordinate, p, 3);
        for (int i = 0; i < 3; i++)
            l->point.position[i] = (float)p[i];
        scene_key_rgb(doc, at, "intensity", brightness, &l->point.intensity);
        return;
    case LIGHT_DISTANT:
        scene_doc_object(doc, at, "a distant light", distant, countof(distant));
        read_direction(doc, at, "direction", l->distant.direction);
        scene_key_rgb(doc, at, "irradiance", brightness, &l->distant.irradiance);
        return;
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
        read_light(doc, &item, &scene->lights[i]);
    }
}
