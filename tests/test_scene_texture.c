/* scene_texture.c, scene_image.c, scene_param.c: textures of a document, and what they drive.
 * SPDX-License-Identifier: MIT */
#include "common/scene.h"

#include <stdio.h>
#include <string.h>

#include "tests/tap.h"

static struct arena arena;
static struct scene scene;

static bool parse(const char *textures, const char *materials)
{
    struct scene_errors errors;
    const char *json = arena_printf(
        &arena,
        "{\"smalti\": 1, \"film\": {\"width\": 8, \"height\": 8}, \"camera\": {\"type\": "
        "\"perspective\", \"fov_deg\": 40, \"look_at\": {\"from\": [0, 0, 5], \"to\": [0, 0, 0]}}, "
        "\"shapes\": [], \"materials\": {%s}, \"textures\": {%s}}",
        materials, textures);
    if (scene_parse(&scene, json, strlen(json), SCENE_FROM_DISK, &arena, &errors))
        return true;
    diag("%s: %s", errors.list[0].where, errors.list[0].what);
    return false;
}

static void reads_images(void)
{
    ok(parse("\"a\": {\"type\": \"image\", \"file\": \"x.JPEG\"}, "
             "\"b\": {\"type\": \"image\", \"file\": \"x.exr\", \"wrap\": \"clamp\", \"uv_scale\": "
             "2}, "
             "\"c\": {\"type\": \"image\", \"file\": \"x.JPEG\", \"color_space\": \"linear\", "
             "\"filter\": \"nearest\", \"uv_scale\": [3, -4], \"uv_offset\": [0.5, 1]}",
             ""),
       "textures are read");
    const struct texture *t = scene.textures;
    ok(scene.texture_count == 3 && scene.image_count == 2 && t[0].image.image == 0 &&
           t[1].image.image == 1 && t[2].image.image == 0 &&
           scene.images[0].format == IMAGE_FORMAT_JPEG && !strcmp(scene.images[1].file, "x.exr") &&
           !strcmp(scene.images[1].where, "/textures/b"),
       "who names the same image shares it");
    ok(t[0].image.space == TEXTURE_SRGB && t[1].image.space == TEXTURE_LINEAR &&
           t[2].image.space == TEXTURE_LINEAR && t[0].image.wrap == TEXTURE_REPEAT &&
           t[1].image.wrap == TEXTURE_CLAMP && t[0].image.filter == TEXTURE_TRILINEAR &&
           t[2].image.filter == TEXTURE_NEAREST,
       "colour space by format, repeat and trilinear unless said otherwise");
    ok(t[0].uv_scale[1] == 1 && t[1].uv_scale[0] == 2 && t[1].uv_scale[1] == 2 &&
           t[2].uv_scale[1] == -4 && t[2].uv_offset[0] == .5f && t[0].uv_offset[1] == 0,
       "uv are scaled and shifted");
}

static void drives_parameters(void)
{
    ok(parse("\"wood\": {\"type\": \"image\", \"file\": \"x.png\"}, \"tiles\": {\"type\": "
             "\"checker\", "
             "\"colors\": [[0.1, 0.2, 0.3], 0.9]}, \"paint\": {\"type\": \"vertex_color\"}",
             "\"plain\": {\"type\": \"mirror\"}, "
             "\"metal\": {\"type\": \"conductor\", \"eta\": {\"texture\": \"tiles\"}, \"k\": 3, "
             "\"alpha\": {\"texture\": \"wood\", \"scale\": 0.5, \"channel\": \"g\"}}, "
             "\"chalk\": {\"type\": \"diffuse\", \"albedo\": {\"texture\": \"paint\", \"scale\": "
             "[0.5, 1, 2]}}"),
       "textured parameters are read");
    const struct material *m = scene.materials;
    const struct material_slot *s = scene.slots;
    ok(scene.slot_count == 4 && m[0].slot_begin == m[0].slot_end && m[1].slot_begin == 0 &&
           m[1].slot_end == 3 && m[2].slot_begin == 3 && m[2].slot_end == 4,
       "each is a slot of its material");
    ok(s[0].is_rgb && s[0].texture == 1 && s[0].lo == 1e-3f && s[0].hi == 100 &&
           s[0].member == offsetof(struct material, conductor.eta),
       "of the member it drives, with the parameter's range");
    ok(!s[1].is_rgb && s[1].texture == 0 && s[1].channel == MATERIAL_CHANNEL_G &&
           s[1].scale[0] == .5f && s[1].member == offsetof(struct material, conductor.alpha) &&
           s[1].lo == 0 && s[1].hi == 1,
       "or of a number, from one channel");
    ok(m[0].needs == 0 && m[1].needs == MATERIAL_NEEDS_UV && m[2].needs == MATERIAL_NEEDS_COLOR,
       "and what it needs of the surface is known");
    ok(m[2].diffuse.albedo[0] == .5f && m[2].diffuse.albedo[2] == 1 && m[1].conductor.alpha == .5f,
       "in the material stands what white would make of it");
}

/* 1 and 1 are as much as textures may say; where they are looked at they are scaled (textured.h). */
static void takes_leaves(void)
{
    ok(parse("\"bark\": {\"type\": \"checker\", \"colors\": [0, 1]}",
             "\"a\": {\"type\": \"leaf\", \"reflectance\": {\"texture\": \"bark\"}, "
             "\"transmittance\": {\"texture\": \"bark\"}}, "
             "\"b\": {\"type\": \"leaf\", \"reflectance\": 0.5, "
             "\"transmittance\": {\"texture\": \"bark\"}}"),
       "what a leaf reflects and lets through is not added up where a texture drives it");
}

static void reads_reliefs(void)
{
    ok(parse("\"n\": {\"type\": \"image\", \"file\": \"n.png\", \"color_space\": \"linear\"}, "
             "\"h\": {\"type\": \"image\", \"file\": \"h.png\"}",
             "\"plain\": {\"type\": \"mirror\"}, "
             "\"brick\": {\"type\": \"diffuse\", \"albedo\": 0.5, \"normal_map\": {\"texture\": "
             "\"n\", \"scale\": 2}}, "
             "\"hammered\": {\"type\": \"mask\", \"material\": \"plain\", \"opacity\": 0.5, "
             "\"bump\": {\"texture\": \"h\", \"scale\": -0.5, \"channel\": \"b\"}}"),
       "reliefs are read");
    const struct material *m = scene.materials;
    const struct material_relief *r = scene.reliefs;
    ok(scene.relief_count == 2 && m[0].relief == 0 && m[1].relief == 1 && m[2].relief == 2 &&
           m[0].needs == 0 && m[1].needs == MATERIAL_NEEDS_UV && m[2].needs == MATERIAL_NEEDS_UV,
       "each is of its material, and wants uv");
    ok(r[0].normal_map == 0 && r[0].strength == 2 && r[0].bump == SCENE_NO_TEXTURE &&
           r[1].normal_map == SCENE_NO_TEXTURE && r[1].bump == 1 && r[1].height == -.5f &&
           r[1].channel == MATERIAL_CHANNEL_B,
       "a map, or a bump");
}

int main(void)
{
    reads_images();
    drives_parameters();
    takes_leaves();
    reads_reliefs();
    arena_release(&arena);
    return tap_done();
}
