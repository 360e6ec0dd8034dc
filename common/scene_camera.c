/* The camera.
 * SPDX-License-Identifier: MIT */
#include "common/scene_check.h"
#include "common/scene_read.h"

#include <math.h>

static const struct scene_range coordinate = {-SCENE_MAX_ABS, SCENE_MAX_ABS, false};
static const struct scene_range length = {SCENE_MIN_LENGTH, SCENE_MAX_ABS, false};

static bool read_look_at(struct scene_doc *doc, const struct scene_at *at, struct scene_xform *x)
{
    static const struct scene_key keys[] = {{"from", true}, {"to", true}, {"up", false}};
    double from[3], to[3], up[3] = {0, 1, 0};
    bool good = scene_doc_object(doc, at, "look_at", keys, countof(keys));
    good &= scene_key_numbers(doc, at, "from", coordinate, from, 3);
    good &= scene_key_numbers(doc, at, "to", coordinate, to, 3);
    good &= scene_key_numbers(doc, at, "up", coordinate, up, 3);
    if (!good)
        return false;
    if (from[0] == to[0] && from[1] == to[1] && from[2] == to[2])
        return scene_doc_fault(doc, at, ERR_INPUT,
                               "expected two different points, \"from\" and \"to\" are both "
                               "[%g, %g, %g]",
                               to[0], to[1], to[2]);
    if (scene_length(up) == 0)
        return scene_doc_fault(doc, at, ERR_INPUT, "expected an \"up\" with a length, got 0");
    if (!scene_xform_look_at(x, from, to, up))
        return scene_doc_fault(doc, at, ERR_INPUT,
                               "expected an \"up\" that is not along the view, got [%g, %g, %g]",
                               up[0], up[1], up[2]);
    return true;
}

static bool read_camera_matrix(struct scene_doc *doc, const struct scene_at *at,
                               struct scene_xform *x)
{
    struct err err;
    if (!scene_read_matrix(doc, at, x))
        return false;
    return scene_check_rigid(x, &err) || scene_doc_fault(doc, at, err.code, "%s", err.text);
}

/* The one of two keys that is to be given, or NULL after a fault. */
static const char *either(struct scene_doc *doc, const struct scene_at *at, const char *const of[2])
{
    struct scene_at member;
    const bool first = scene_at_member(at, of[0], &member);
    const bool second = scene_at_member(at, of[1], &member);
    if (first != second)
        return of[first ? 0 : 1];
    scene_doc_fault(doc, at, ERR_INPUT, "the camera needs \"%s\" or \"%s\", got %s", of[0], of[1],
                    first ? "both" : "neither");
    return NULL;
}

static void read_place(struct scene_doc *doc, const struct scene_at *at, struct scene_camera *out)
{
    static const char *const ways[2] = {"look_at", "matrix"};
    struct scene_xform x = scene_xform_identity();
    struct scene_at member;
    const char *way = either(doc, at, ways);
    if (way && scene_at_member(at, way, &member)) {
        if (way == ways[0])
            read_look_at(doc, &member, &x);
        else
            read_camera_matrix(doc, &member, &x);
    }
    out->to_world = scene_xform_round(&x);
}

static void read_fov(struct scene_doc *doc, const struct scene_at *at, struct scene_camera *out)
{
    double fov_deg = 1;
    scene_key_number(doc, at, "fov_deg", (struct scene_range){.001, 179.9, false}, &fov_deg);
    out->fov_y_rad = (float)(fov_deg * (3.14159265358979323846 / 180));
}

/* A lens wider than its focus is far would be faster than f / 0.5, which no lens in air is. */
static void read_lens(struct scene_doc *doc, const struct scene_at *at, struct scene_camera *out)
{
    double radius = 0, focus = 1, angle_deg = 0;
    uint64_t blades = 0;
    struct scene_at member;
    bool good = scene_key_number(doc, at, "aperture_radius",
                                 (struct scene_range){0, SCENE_MAX_ABS, false}, &radius);
    good &= scene_at_member(at, "focus_distance", &member) &&
            scene_key_number(doc, at, "focus_distance", length, &focus);
    if (good && radius > focus && scene_at_member(at, "aperture_radius", &member))
        scene_doc_fault(doc, &member, ERR_INPUT, "expected at most the focus_distance, %g, got %g",
                        focus, radius);
    scene_key_integer(doc, at, "blades", (struct scene_range){3, SCENE_MAX_BLADES, false}, &blades);
    scene_key_number(doc, at, "blade_angle_deg", (struct scene_range){-360, 360, false},
                     &angle_deg);
    if (scene_at_member(at, "blade_angle_deg", &member) && !scene_at_member(at, "blades", &member))
        scene_doc_fault(doc, at, ERR_INPUT, "\"blade_angle_deg\" needs \"blades\" beside it");
    const double turns = angle_deg / 360;
    out->lens_radius = (float)radius;
    out->focus = (float)focus;
    out->blades = (uint32_t)blades;
    out->blades_turn = (float)(turns - floor(turns));
}

static void read_extent(struct scene_doc *doc, const struct scene_at *at, struct scene_camera *out)
{
    static const char *const sides[2] = {"width", "height"};
    static const struct scene_range extent = {SCENE_MIN_LENGTH, 1e14, false};
    double size[2] = {0, 0};
    either(doc, at, sides);
    for (int i = 0; i < 2; i++)
        scene_key_number(doc, at, sides[i], extent, &size[i]);
    out->width = (float)size[0];
    out->height = (float)size[1];
}

void scene_read_camera(struct scene_doc *doc, const struct scene_at *at, struct scene_camera *out)
{
    static const char *const kinds[] = {[CAMERA_PERSPECTIVE] = "perspective",
                                        [CAMERA_THIN_LENS] = "thin_lens",
                                        [CAMERA_ORTHOGRAPHIC] = "orthographic",
                                        [CAMERA_PANORAMIC] = "panoramic"};
    static const struct scene_key perspective[] = {
        {"type", true}, {"fov_deg", true}, {"look_at", false}, {"matrix", false}};
    static const struct scene_key thin_lens[] = {
        {"type", true},           {"fov_deg", true}, {"aperture_radius", true},
        {"focus_distance", true}, {"blades", false}, {"blade_angle_deg", false},
        {"look_at", false},       {"matrix", false}};
    static const struct scene_key orthographic[] = {
        {"type", true}, {"width", false}, {"height", false}, {"look_at", false}, {"matrix", false}};
    static const struct scene_key panoramic[] = {
        {"type", true}, {"look_at", false}, {"matrix", false}};
    size_t kind;
    if (!scene_doc_kind(doc, at, "the camera", kinds, countof(kinds), &kind))
        return;
    out->kind = (enum camera_kind)kind;
    switch (out->kind) {
    case CAMERA_PERSPECTIVE:
        scene_doc_object(doc, at, "the camera", perspective, countof(perspective));
        read_fov(doc, at, out);
        break;
    case CAMERA_THIN_LENS:
        scene_doc_object(doc, at, "a thin lens", thin_lens, countof(thin_lens));
        read_fov(doc, at, out);
        read_lens(doc, at, out);
        break;
    case CAMERA_ORTHOGRAPHIC:
        scene_doc_object(doc, at, "an orthographic camera", orthographic, countof(orthographic));
        read_extent(doc, at, out);
        break;
    case CAMERA_PANORAMIC:
        scene_doc_object(doc, at, "a panoramic camera", panoramic, countof(panoramic));
        break;
    }
    read_place(doc, at, out);
}
