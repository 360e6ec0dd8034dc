/* texture.c, prep_texture.c, half.h, color.h: what is kept of an image, and what is looked up.
 * SPDX-License-Identifier: MIT */
#include "common/trace/texture.h"

#include <math.h>
#include <string.h>

#include "common/trace/half.h"
#include "tests/dice.h"
#include "tests/tap.h"
#include "tests/textures.h"

/* --- numbers --- */

static void srgb_is_right(void)
{
    double worst = 0;
    uint32_t back = 0;
    for (int i = 0; i < 65536; i++) {
        const double v = i / 65535., got = srgb_linear(v);
        const double want = v <= 0.04045 ? v / 12.92 : pow((v + 0.055) / 1.055, 2.4);
        worst = fmax(worst, fabs(got - want) / fmax(want, 1e-12));
    }
    for (int i = 0; i < 256; i++) {
        const double l = (double)(float)srgb_linear(i / 255.);
        const double e = l <= 0.0031308 ? 12.92 * l : 1.055 * pow(l, 1 / 2.4) - 0.055;
        back += lrint(e * 255) == i;
    }
    ok(worst < 2e-15, "sRGB is IEC 61966-2-1's to %.1e of the value, at all 65536 places", worst);
    ok(srgb_linear(0) == 0 && srgb_linear(1) == 1 && back == 256, "each byte comes back");
}

static void halves_are_right(void)
{
    uint32_t same = 0, finite = 0, near_by = 0, tries = 0;
    for (uint32_t h = 0; h < 0x10000; h++)
        if ((h & 0x7c00) != 0x7c00 && h != 0x8000) {
            finite++;
            same += half_make(half_load((uint16_t)h)) == h;
        }
    ok(same == finite, "every half comes back");
    ok(half_load(0x3c00) == 1 && half_load(0x0001) == 0x1p-24f && half_load(0x7bff) == HALF_MAX &&
           half_load(0x0400) == 0x1p-14f && half_load(0xc500) == -5,
       "halves are what the standard says");
    struct dice dice = dice_make(5);
    for (int i = 0; i < 200000; i++) {
        const float v = ldexpf((float)dice_unit(&dice), (int)(dice_unit(&dice) * 43) - 28);
        const uint16_t h = half_make(v);
        const double error = fabs((double)half_load(h) - (double)v);
        tries++;
        near_by += error <= fabs((double)half_load((uint16_t)(h + 1)) - (double)v) &&
                   (h == 0 || error <= fabs((double)half_load((uint16_t)(h - 1)) - (double)v));
    }
    ok(near_by == tries && half_make(1 + 0x1p-11f) == 0x3c00 && half_make(1 + 0x3p-11f) == 0x3c02 &&
           half_make(1e9f) == 0x7bff && half_make(-1e-9f) == 0x8000,
       "the nearest half, ties to even, none beyond the largest");
}

/* --- a scene with one textured material, to look its textures up in --- */

static struct scenes scenes;
static const struct stage *stage;

static void begin(void)
{
    scenes_init(&scenes, 16, 16);
    scenes_sphere(&scenes, scenes_diffuse(&scenes, rgb_gray(.5f)), vec3_make(0, 0, -3), 1);
}

static struct texture *image(enum image_depth depth, uint32_t width, uint32_t height,
                             uint32_t channels, const void *pixels)
{
    struct texture *t = textures_image(&scenes, depth, width, height, channels, pixels);
    textures_drive(&scenes, &scenes.scene.materials[0].diffuse.albedo, true, t);
    return t;
}

static void make(void)
{
    stage = scenes_stage(&scenes);
}

static struct texture_value look(uint32_t texture, float u, float v, float area)
{
    return texture_at(stage, texture, &(struct texture_point){u, v, area, rgb_gray(.25f)});
}

static bool is(float got, double want)
{
    if (got == (float)want)
        return true;
    diag("got %.9g, expected %.9g", (double)got, want);
    return false;
}

/* --- decoding --- */

static void decodes(void)
{
    static const unsigned char bytes[] = {0, 51, 128, 255, 188, 40, 7, 127};
    static const uint16_t words[] = {0, 32896, 65535, 1};
    static const float floats[] = {-1, 0, 70000, .1f};
    begin();
    image(IMAGE_DEPTH_U8, 2, 1, 4, bytes)->image.space = TEXTURE_SRGB;
    image(IMAGE_DEPTH_U8, 2, 1, 4, bytes);
    image(IMAGE_DEPTH_U8, 4, 1, 2, bytes)->image.space = TEXTURE_SRGB;
    image(IMAGE_DEPTH_U16, 4, 1, 1, words);
    image(IMAGE_DEPTH_U16, 4, 1, 1, words)->image.space = TEXTURE_SRGB;
    image(IMAGE_DEPTH_FLOAT, 4, 1, 1, floats);
    for (uint32_t i = 0; i < 6; i++)
        scenes.scene.textures[i].image.filter = TEXTURE_NEAREST;
    make();
    const struct texture_value a = look(0, .25f, .5f, 0), b = look(1, .75f, .5f, 0),
                               c = look(2, .3f, .5f, 0);
    ok(is(a.color[0], 0) && is(a.color[1], srgb_linear(.2)) &&
           is(a.color[2], srgb_linear(128 / 255.)) && is(a.alpha, 1),
       "8 bits of sRGB, alpha as it is");
    ok(is(b.color[0], 188 / 255.) && is(b.color[2], 7 / 255.) && is(b.alpha, 127 / 255.),
       "8 bits that are linear");
    ok(is(c.color[0], srgb_linear(128 / 255.)) && c.color[1] == c.color[0] && is(c.alpha, 1),
       "gray and alpha");
    ok(is(look(3, .3f, .5f, 0).color[1], 32896 / 65535.) &&
           is(look(3, .9f, .5f, 0).color[2], 1 / 65535.) && is(look(3, .9f, .5f, 0).alpha, 1),
       "16 bits that are linear");
    near((double)look(4, .3f, .5f, 0).color[0], srgb_linear(32896 / 65535.), 1.2e-4,
         "16 bits of sRGB, to the precision of a half");
    ok(is(look(5, .1f, .5f, 0).color[0], -1) && is(look(5, .6f, .5f, 0).color[0], 70000) &&
           is(look(5, .9f, .5f, 0).color[0], (double).1f),
       "floats, of any sign and size");
    scenes_release(&scenes);
}

/* --- wrapping and filters --- */

static const unsigned char row[] = {0, 51, 102, 153};

static void wraps(void)
{
    static const float at[] = {.1f, .9f, 1.1f, 1.9f, 2.1f, -.1f, -.9f, -1.1f, 1001.1f};
    static const unsigned char repeat[] = {0, 153, 0, 153, 0, 153, 0, 153, 0};
    static const unsigned char clamp[] = {0, 153, 153, 153, 153, 0, 0, 0, 153};
    static const unsigned char mirror[] = {0, 153, 153, 0, 0, 0, 153, 153, 153};
    const unsigned char *const want[] = {
        [TEXTURE_REPEAT] = repeat, [TEXTURE_CLAMP] = clamp, [TEXTURE_MIRROR] = mirror};
    static const char *const names[] = {"repeat", "clamp", "mirror"};
    begin();
    for (uint32_t i = 0; i < 3; i++) {
        struct texture *t = image(IMAGE_DEPTH_U8, 4, 1, 1, row);
        t->image.wrap = (enum texture_wrap)i;
        t->image.filter = TEXTURE_NEAREST;
    }
    make();
    for (uint32_t wrap = 0; wrap < 3; wrap++) {
        bool good = true;
        for (size_t i = 0; i < countof(at); i++)
            good &= is(look(wrap, at[i], .5f, 0).color[0], want[wrap][i] / 255.);
        ok(good, "%s, to the left and to the right", names[wrap]);
    }
    scenes_release(&scenes);
}

static void filters(void)
{
    static const unsigned char rows[] = {0, 51, 102, 153}; /* 2 x 2, the upper row first */
    begin();
    struct texture *t = image(IMAGE_DEPTH_U8, 2, 2, 1, rows);
    t->image.filter = TEXTURE_BILINEAR;
    t->image.wrap = TEXTURE_CLAMP;
    t = image(IMAGE_DEPTH_U8, 2, 2, 1, rows);
    t->image.filter = TEXTURE_BILINEAR;
    t->uv_scale[0] = 2;
    t->uv_offset[1] = .25f;
    make();
    ok(is(look(0, .25f, .75f, 0).color[0], 0) && is(look(0, .75f, .75f, 0).color[0], .2) &&
           is(look(0, .25f, .25f, 0).color[0], .4) && is(look(0, .75f, .25f, 0).color[0], .6),
       "in the middle of a texel it is that texel; v grows upwards");
    near((double)look(0, .5f, .5f, 0).color[0], .3, 1e-7, "in the middle of four, their mean");
    near((double)look(0, .375f, .75f, 0).color[0], .05, 1e-7, "a quarter of the way, a quarter");
    ok(is(look(0, 0, 1, 0).color[0], 0) && is(look(0, 1, 0, 0).color[0], .6), "the corners");
    near((double)look(1, 0, 0, 0).color[0], .5, 1e-7,
         "repeated, the edge is between first and last");
    near((double)look(1, .125f, 0, 0).color[0], .4, 1e-7, "uv are scaled, then shifted");
    scenes_release(&scenes);
}

static void far_uv(void)
{
    static const float far[] = {1e30f, -1e30f, INFINITY, -INFINITY, NAN, 4194303.5f, -4194303.5f};
    begin();
    for (int wrap = 0; wrap < 3; wrap++)
        image(IMAGE_DEPTH_U8, 4, 1, 1, row)->image.wrap = (enum texture_wrap)wrap;
    textures_checker(&scenes, rgb_gray(.25f), rgb_gray(.5f), 1e6f);
    make();
    bool good = true;
    for (size_t i = 0; i < countof(far); i++)
        for (uint32_t texture = 0; texture < 4; texture++)
            for (int areas = 0; areas < 3; areas++) {
                const float areas_of[] = {0, 1, INFINITY};
                const float c = look(texture, far[i], -far[i], areas_of[areas]).color[0];
                good &= c >= 0 && c <= .61f;
            }
    ok(good, "uv beyond all measure have a value");
    scenes_release(&scenes);
}

/* --- pyramids --- */

enum { WIDE = 37, HIGH = 21 };

static double level_mean(const struct stage_pyramid *p, uint32_t level)
{
    const uint32_t w = texture_level_px(p->width_px, level),
                   h = texture_level_px(p->height_px, level);
    double sum = 0;
    for (uint32_t y = 0; y < h; y++)
        for (uint32_t x = 0; x < w; x++)
            sum += (double)texture_texel(stage, p, level, x, y)[0];
    return sum / (w * h);
}

static void levels_keep_the_mean(void)
{
    static unsigned char noise[WIDE * HIGH * 3];
    static float floats[WIDE * HIGH];
    struct dice dice = dice_make(3);
    for (size_t i = 0; i < countof(noise); i++)
        noise[i] = (unsigned char)(dice_unit(&dice) * 255);
    for (size_t i = 0; i < countof(floats); i++)
        floats[i] = (float)(dice_unit(&dice) * 100);
    begin();
    image(IMAGE_DEPTH_U8, WIDE, HIGH, 3, noise)->image.space = TEXTURE_SRGB;
    image(IMAGE_DEPTH_FLOAT, WIDE, HIGH, 1, floats);
    make();
    const struct stage_pyramid *p = stage_at(stage, stage->pyramids);
    double worst[2] = {0};
    for (int i = 0; i < 2; i++)
        for (uint32_t level = 1; level < p[i].level_count; level++)
            worst[i] = fmax(worst[i], fabs(level_mean(&p[i], level) / level_mean(&p[i], 0) - 1));
    ok(p[0].level_count == 6 && worst[0] < 5e-4 && worst[1] < 1e-6,
       "levels of any size have the image's mean: within %.1e in halves, %.1e in floats", worst[0],
       worst[1]);
    scenes_release(&scenes);
}

static void checkers_fade(void)
{
    static unsigned char pixels[64 * 64];
    for (int i = 0; i < 64 * 64; i++)
        pixels[i] = (i + i / 64) % 2 ? 255 : 0;
    begin();
    image(IMAGE_DEPTH_U8, 64, 64, 1, pixels)->image.space = TEXTURE_SRGB;
    make();
    const struct stage_pyramid *p = stage_at(stage, stage->pyramids);
    bool half = p->level_count == 7;
    for (uint32_t level = 1; level < p->level_count; level++)
        half &= level_mean(p, level) == .5 && texture_texel(stage, p, level, 0, 0)[0] == .5f;
    ok(half, "every level of a black and white checker is their linear mean");
    ok(look(0, .3f, .4f, 1).color[0] == .5f && look(0, .3f, .4f, INFINITY).color[0] == .5f,
       "and so is what a wide footprint sees");
    scenes_release(&scenes);
}

static void levels_go_over_into_each_other(void)
{
    static float pixels[32 * 32];
    struct dice dice = dice_make(9);
    for (size_t i = 0; i < countof(pixels); i++)
        pixels[i] = (float)dice_unit(&dice);
    begin();
    image(IMAGE_DEPTH_FLOAT, 32, 32, 1, pixels);
    image(IMAGE_DEPTH_FLOAT, 32, 32, 1, pixels)->image.filter = TEXTURE_BILINEAR;
    make();
    double jump = 0;
    float last = look(0, .2f, .7f, 0).color[0];
    for (int i = 0; i < 20000; i++) {
        const float now =
            look(0, .2f, .7f, ldexpf(1, -12) * powf(2, 15.f * (float)i / 20000)).color[0];
        jump = fmax(jump, fabs((double)now - (double)last));
        last = now;
    }
    ok(jump < 1e-3, "a growing footprint never jumps: at most %.1e in a step of 1/1333 octave",
       jump);
    const struct stage_pyramid *p = stage_at(stage, stage->pyramids);
    const float middle = .5f / 8 + 3.f / 8; /* of texel 3 of 8, and of row 8 - 1 - 3 */
    ok(is(look(0, middle, middle, 16.f / (32 * 32)).color[0],
          (double)texture_texel(stage, p, 2, 3, 4)[0]),
       "a footprint 4 texels wide is level 2");
    ok(look(0, .21f, .73f, .9f / (32 * 32)).color[0] == look(1, .21f, .73f, 100).color[0],
       "one narrower than a texel is level 0, and bilinear always is");
    scenes_release(&scenes);
}

static void memory_is_small(void)
{
    static unsigned char pixels[64 * 64 * 3], plain[64 * 64 * 3];
    for (size_t i = 0; i < sizeof pixels; i++)
        pixels[i] = (unsigned char)i;
    memset(plain, 200, sizeof plain);
    begin();
    struct texture *t = image(IMAGE_DEPTH_U8, 64, 64, 3, pixels);
    make();
    const uint64_t one = stage->texels.count;
    scenes_release(&scenes);
    ok(one >= 64 * 64 * 3 && one < 64 * 64 * 3 * 17 / 10, "three bytes a texel, and %.2f more",
       (double)one / (64 * 64) - 3);

    begin();
    t = image(IMAGE_DEPTH_U8, 64, 64, 3, pixels);
    struct texture *again = image(IMAGE_DEPTH_U8, 1, 1, 3, pixels);
    again->image.image = t->image.image;
    again->image.wrap = TEXTURE_MIRROR;
    image(IMAGE_DEPTH_U8, 64, 64, 3, plain);
    textures_image(&scenes, IMAGE_DEPTH_U8, 64, 64, 3, pixels); /* drives nothing */
    make();
    ok(stage->texels.count == one + 64 && stage->pyramids.count == 2,
       "an image is kept once, one of a single colour as a texel, an unused one not at all");
    ok(is(look(2, .3f, .3f, 0).color[1], 200 / 255.) &&
           is(look(1, 1.3f, .2f, 0).color[0], (double)look(0, .7f, .2f, 0).color[0]),
       "and they are what they were");
    scenes_release(&scenes);

    begin();
    textures_image(&scenes, IMAGE_DEPTH_U8, 64, 64, 3, pixels);
    make();
    ok(stage->texels.count == 0 && stage->pyramids.count == 0 && stage->bytes8.count == 0,
       "a scene that uses no image keeps none");
    scenes_release(&scenes);
}

static void checkers(void)
{
    begin();
    textures_checker(&scenes, rgb_gray(.25f), rgb_gray(.5f), 2);
    textures_vertex_color(&scenes);
    make();
    bool good = true;
    for (int y = -5; y < 5; y++)
        for (int x = -5; x < 5; x++) {
            const float u = ((float)x + .3f) / 2, v = ((float)y + .8f) / 2;
            good &= is(look(0, u, v, INFINITY).color[1], (x + y) % 2 ? .5 : .25);
        }
    ok(good, "a checker's squares take turns, on both sides of 0");
    ok(is(look(1, 3, 4, 1).color[2], .25), "vertex colours are the mesh's");
    scenes_release(&scenes);
}

int main(void)
{
    srgb_is_right();
    halves_are_right();
    decodes();
    wraps();
    filters();
    far_uv();
    levels_keep_the_mean();
    checkers_fade();
    levels_go_over_into_each_other();
    memory_is_small();
    checkers();
    return tap_done();
}
