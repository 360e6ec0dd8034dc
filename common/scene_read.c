/* The document as a whole: film, settings; the rest in files of their own.
 * SPDX-License-Identifier: MIT */
#include "common/scene_read.h"

#include "common/layers.h"
#include "common/scene_check.h"
#include "common/scene_share.h"

static void read_crop(struct scene_doc *doc, const struct scene_at *at, bool size_known,
                      struct scene_film *film)
{
    static const struct scene_range px = {0, SCENE_MAX_SIDE_PX, false};
    if (scene_at_type(at) != SCENE_ARRAY || scene_at_count(at) != 4) {
        scene_doc_expected(doc, at, ERR_INPUT, "[x_begin, y_begin, x_end, y_end]");
        return;
    }
    uint64_t v[4];
    bool good = true;
    for (size_t i = 0; i < 4; i++) {
        const struct scene_at item = scene_at_item(at, i);
        good &= scene_doc_integer(doc, &item, px, &v[i]);
    }
    if (!good || !size_known)
        return;
    film->crop_x_begin = (uint32_t)v[0];
    film->crop_y_begin = (uint32_t)v[1];
    film->crop_x_end = (uint32_t)v[2];
    film->crop_y_end = (uint32_t)v[3];
    struct err err;
    if (!scene_check_crop(film, &err)) {
        scene_doc_fault(doc, at, err.code, "%s", err.text);
        film->crop_x_begin = film->crop_x_end = 0; /* nothing to count */
    }
}

/* The set that "layers" and "bounces" ask for. */
static uint32_t read_layers(struct scene_doc *doc, const struct scene_at *film)
{
    static const char *const names[] = {"albedo", "normal", "depth", "position", "material"};
    struct scene_at at;
    uint64_t bounces = 0;
    uint32_t set = 0;
    if (scene_at_member(film, "layers", &at) &&
        scene_doc_array(doc, &at, "layers", 0, countof(names)))
        for (size_t i = 0; i < scene_at_count(&at); i++) {
            const struct scene_at item = scene_at_item(&at, i);
            size_t layer;
            if (!scene_doc_choice(doc, &item, names, countof(names), &layer))
                continue;
            if (set >> layer & 1)
                scene_doc_fault(doc, &item, ERR_INPUT, "the layer \"%s\" is there already",
                                names[layer]);
            set |= 1u << layer;
        }
    if (scene_key_integer(doc, film, "bounces", (struct scene_range){0, LAYERS_MAX_BOUNCES, true},
                          &bounces))
        return layers_make(set, (uint32_t)bounces);
    return set;
}

static void read_film(struct scene_doc *doc, const struct scene_at *at, struct scene_film *film)
{
    static const struct scene_key keys[] = {{"width", true}, {"height", true},  {"filter", false},
                                            {"crop", false}, {"layers", false}, {"bounces", false}};
    static const struct scene_range side = {1, SCENE_MAX_SIDE_PX, true};
    uint64_t width = 0, height = 0;
    scene_doc_object(doc, at, "the film", keys, countof(keys));
    bool size_known = scene_key_integer(doc, at, "width", side, &width);
    size_known &= scene_key_integer(doc, at, "height", side, &height);
    size_known &= width && height;
    *film = (struct scene_film){.width_px = (uint32_t)width,
                                .height_px = (uint32_t)height,
                                .crop_x_end = (uint32_t)width,
                                .crop_y_end = (uint32_t)height,
                                .filter = FILTER_BOX,
                                .filter_radius_px = .5f};
    film->layers = read_layers(doc, at);
    struct scene_at member;
    if (scene_at_member(at, "filter", &member))
        scene_read_filter(doc, &member, film);
    if (scene_at_member(at, "crop", &member))
        read_crop(doc, &member, size_known, film);
    struct err err;
    if (size_known && !scene_check_pixels(film, &err))
        scene_doc_fault(doc, at, err.code, "%s", err.text);
}

static void read_target(struct scene_doc *doc, const struct scene_at *at, struct scene_target *out)
{
    static const struct scene_key keys[] = {{"error", false}, {"spp", false}, {"seconds", false}};
    if (scene_at_type(at) == SCENE_OBJECT && scene_at_count(at) == 0) {
        scene_doc_fault(doc, at, ERR_INPUT,
                        "the target needs at least one of \"error\", \"spp\" and \"seconds\"");
        return;
    }
    scene_doc_object(doc, at, "the target", keys, countof(keys));
    uint64_t spp = SCENE_MAX_SPP;
    scene_key_number(doc, at, "error", (struct scene_range){1e-5, 1, false}, &out->error);
    scene_key_integer(doc, at, "spp", (struct scene_range){1, SCENE_MAX_SPP, true}, &spp);
    scene_key_number(doc, at, "seconds", (struct scene_range){.01, 1e7, true}, &out->seconds);
    out->spp = (uint32_t)spp;
}

static void read_method(struct scene_doc *doc, const struct scene_at *at,
                        struct scene_settings *out)
{
    static const char *const integrators[] = {[INTEGRATOR_PATH] = "path",
                                              [INTEGRATOR_DIRECT] = "direct",
                                              [INTEGRATOR_WHITTED] = "whitted",
                                              [INTEGRATOR_AUTO] = "auto"};
    static const char *const strategies[] = {
        [STRATEGY_MIS] = "mis", [STRATEGY_LIGHT] = "light", [STRATEGY_BSDF] = "bsdf"};
    static const char *const samplers[] = {[SAMPLER_SOBOL] = "sobol",
                                           [SAMPLER_INDEPENDENT] = "independent",
                                           [SAMPLER_STRATIFIED] = "stratified"};
    struct scene_at member;
    size_t integrator = INTEGRATOR_AUTO, strategy = STRATEGY_MIS, sampler = SAMPLER_SOBOL;
    if (scene_at_member(at, "strategy", &member)) /* who says how lights are found means paths */
        integrator = INTEGRATOR_PATH;
    if (scene_at_member(at, "integrator", &member))
        scene_doc_choice(doc, &member, integrators, countof(integrators), &integrator);
    if (scene_at_member(at, "sampler", &member))
        scene_doc_choice(doc, &member, samplers, countof(samplers), &sampler);
    if (scene_at_member(at, "strategy", &member) &&
        scene_doc_choice(doc, &member, strategies, countof(strategies), &strategy)) {
        if (integrator == INTEGRATOR_WHITTED && strategy != STRATEGY_LIGHT)
            scene_doc_expected(doc, &member, ERR_INPUT, "\"light\" (\"whitted\" has no other)");
        if (integrator == INTEGRATOR_AUTO)
            scene_doc_fault(doc, &member, ERR_INPUT, "\"auto\" chooses the strategy itself");
    }
    out->integrator = (enum integrator_kind)integrator;
    out->strategy = (enum strategy_kind)strategy;
    out->sampler = (enum sampler_kind)sampler;
}

static void read_settings(struct scene_doc *doc, const struct scene_at *at,
                          struct scene_settings *out)
{
    static const struct scene_key keys[] = {
        {"integrator", false}, {"strategy", false}, {"sampler", false}, {"max_bounces", false},
        {"clamp", false},      {"seed", false},     {"target", false},  {"rescale", false}};
    struct scene_at member;
    uint64_t bounces = out->max_bounces;
    double clamp = 0;
    scene_doc_object(doc, at, "the settings", keys, countof(keys));
    read_method(doc, at, out);
    scene_key_integer(doc, at, "max_bounces", (struct scene_range){0, SCENE_MAX_BOUNCES, true},
                      &bounces);
    scene_key_number(doc, at, "clamp", (struct scene_range){1e-9, 1e30, false}, &clamp);
    /* To 2^53 - 1: beyond, two whole numbers may read as one. */
    scene_key_integer(doc, at, "seed", (struct scene_range){0, 9007199254740991., false},
                      &out->seed);
    if (scene_at_member(at, "rescale", &member) && scene_at_type(&member) != SCENE_BOOLEAN)
        scene_doc_expected(doc, &member, ERR_INPUT, "true or false");
    if (scene_at_member(at, "target", &member))
        read_target(doc, &member, &out->target);
    out->max_bounces = (uint32_t)bounces;
    out->clamp = (float)clamp;
}

static void read_version(struct scene_doc *doc, const struct scene_at *whole)
{
    struct scene_at at;
    if (!scene_at_member(whole, "smalti", &at))
        return;
    if (scene_at_type(&at) != SCENE_NUMBER || scene_at_number(&at) != 1)
        scene_doc_expected(doc, &at, ERR_INPUT, "1 (the version of this format)");
}

void scene_read(struct scene_doc *doc, const struct scene_at *whole, struct scene *scene)
{
    static const struct scene_key keys[] = {
        {"smalti", true}, {"title", false},    {"film", true},
        {"camera", true}, {"textures", false}, {"materials", true},
        {"shapes", true}, {"lights", false},   {"settings", false}};
    scene->title = "";
    doc->rescale = scene_share_wanted(whole);
    scene->settings = (struct scene_settings){
        .integrator = INTEGRATOR_AUTO, .max_bounces = 64, .target = {.spp = 64}};
    scene_doc_object(doc, whole, "the document", keys, countof(keys));
    read_version(doc, whole);
    struct scene_at at;
    struct scene_names names = {0}, textures = {.one = "texture", .known = true};
    if (scene_at_member(whole, "title", &at))
        scene_doc_text(doc, &at, 0, SCENE_MAX_NAME, &scene->title);
    if (scene_at_member(whole, "film", &at))
        read_film(doc, &at, &scene->film);
    if (scene_at_member(whole, "camera", &at))
        scene_read_camera(doc, &at, &scene->camera);
    if (scene_at_member(whole, "textures", &at))
        textures = scene_read_textures(doc, &at, scene);
    if (scene_at_member(whole, "materials", &at))
        names = scene_read_materials(doc, &at, &textures, scene);
    if (scene_at_member(whole, "shapes", &at))
        scene_read_shapes(doc, &at, &(struct scene_known){&names, &textures}, scene);
    if (scene_at_member(whole, "lights", &at))
        scene_read_lights(doc, &at, scene);
    if (scene_at_member(whole, "settings", &at))
        read_settings(doc, &at, &scene->settings);
}
