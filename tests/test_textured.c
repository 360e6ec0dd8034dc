/* Materials with textures: what the bsdf sees, and what the picture shows.
 * SPDX-License-Identifier: MIT */
#include "common/trace/textured.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "common/estimate.h"
#include "common/trace/fmath.h"
#include "common/trace/wave.h"
#include "tests/local.h"
#include "tests/stat/stat.h"
#include "tests/tap.h"
#include "tests/textures.h"

/* --- the seam --- */

static void values_stay_in_range(void)
{
    static const float pixels[] = {-3, .25f, 7, .5f};
    struct scenes s;
    scenes_init(&s, 8, 8);
    const uint32_t m = scenes_metal(&s, rgb_gray(.2f), rgb_gray(3), .3f);
    struct material *metal = &s.scene.materials[m];
    const struct texture *t = textures_image(&s, IMAGE_DEPTH_FLOAT, 1, 1, 4, pixels);
    textures_drive(&s, &metal->conductor.eta, true, t)->lo = .001f;
    textures_drive(&s, &metal->conductor.alpha, false, t)->channel = MATERIAL_CHANNEL_A;
    struct material_slot *k = textures_drive(&s, &metal->conductor.k, true, t);
    k->hi = 100;
    k->scale[1] = 8;
    scenes_sphere(&s, m, vec3_make(0, 0, -3), 1);
    const struct stage *stage = scenes_stage(&s);
    const struct material *of_stage = stage_at(stage, stage->materials);
    struct material scratch;
    const struct texture_point at = {.5f, .5f, 0, {0}};
    const struct material *got = textured_material(stage, of_stage, &at, &scratch);
    ok(got == &scratch && !textured_has(got) && got->kind == MATERIAL_CONDUCTOR,
       "a textured material becomes a plain one");
    ok(got->conductor.eta[0] == .001f && got->conductor.eta[1] == .25f &&
           got->conductor.eta[2] == 1 && got->conductor.alpha == .5f,
       "values beyond the parameter's range are the nearest in it");
    ok(got->conductor.k[0] == 0 && got->conductor.k[1] == 2 && got->conductor.k[2] == 7,
       "the scale goes before the range");
    struct material plain = *of_stage;
    plain.slot_end = plain.slot_begin;
    ok(textured_material(stage, &plain, &at, &scratch) == &plain,
       "one without slots stays where it is");
    scenes_release(&s);
}

/* --- pictures --- */

enum { SIDE = 12 };

/* A ball and a floor under a sky; one material is what the test is about. */
static struct material *begin(struct scenes *s)
{
    scenes_init(s, SIDE, SIDE);
    scenes_look(s, vec3_make(0, 1.5f, 4), vec3_make(0, .5f, 0), .8);
    scenes_quad(s, scenes_diffuse(s, rgb_gray(.4f)), vec3_make(-4, 0, 4), vec3_make(8, 0, 0),
                vec3_make(0, 0, -8));
    scenes_sky(s, vec3_make(1, .9f, .8f));
    const uint32_t m = scenes_diffuse(s, vec3_make(.5f, .25f, .75f));
    scenes_sphere(s, m, vec3_make(0, .7f, 0), .7f);
    return &s->scene.materials[m];
}

static void films_equal(struct scenes *s, struct scenes *t, const char *name)
{
    struct film a, b;
    scenes_render(scenes_stage(s), 32, &a);
    scenes_render(scenes_stage(t), 32, &b);
    const size_t bytes = (size_t)SIDE * SIDE * 3 * sizeof *a.sum;
    ok(!memcmp(a.sum, b.sum, bytes), "%s: the same bits as with the constant", name);
    film_release(&a);
    film_release(&b);
    scenes_release(s);
    scenes_release(t);
}

static void constants(void)
{
    static const float one[] = {.5f, .25f, .75f};
    static const unsigned char white[] = {255, 255, 255, 255};
    static float many[8 * 8 * 4];
    for (int i = 0; i < 8 * 8; i++)
        memcpy(many + 4 * i, (const float[]){.5f, .25f, .75f, (float)i}, 4 * sizeof *many);
    struct scenes s, t;
    begin(&s);
    struct material *m = begin(&t);
    textures_drive(&t, &m->diffuse.albedo, true,
                   textures_image(&t, IMAGE_DEPTH_FLOAT, 1, 1, 3, one));
    films_equal(&s, &t, "an image of one pixel");
    begin(&s);
    m = begin(&t);
    textures_drive(&t, &m->diffuse.albedo, true,
                   textures_image(&t, IMAGE_DEPTH_FLOAT, 8, 8, 4, many));
    films_equal(&s, &t, "an image of 64 equal colours, at any level");
    begin(&s);
    m = begin(&t);
    struct texture *bytes = textures_image(&t, IMAGE_DEPTH_U8, 2, 2, 1, white);
    bytes->image.space = TEXTURE_SRGB;
    memcpy(textures_drive(&t, &m->diffuse.albedo, true, bytes)->scale, one, sizeof one);
    films_equal(&s, &t, "white, scaled");
    begin(&s);
    m = begin(&t);
    textures_drive(&t, &m->diffuse.albedo, true,
                   textures_checker(&t, vec3_make(.5f, .25f, .75f), vec3_make(.5f, .25f, .75f), 4));
    films_equal(&s, &t, "a checker of one colour");
}

/* Nothing but a plate under an even sky: its pixels are sky times albedo, and their mean the sky
 * times the mean of the texture. */
static void plate(struct scenes *s, float distance)
{
    scenes_init(s, 8, 8);
    scenes_look(s, vec3_make(.5f, .5f, distance), vec3_make(.5f, .5f, 0),
                2 * atan(.5 / (double)distance)); /* just the plate */
    scenes_quad(s, scenes_diffuse(s, rgb_gray(0)), vec3_make(0, 0, 0), vec3_make(1, 0, 0),
                vec3_make(0, 1, 0));
    scenes_sky(s, rgb_gray(2));
}

static struct scenes_mean plate_mean(struct scenes *s, uint32_t spp)
{
    struct film film;
    scenes_render(scenes_stage(s), spp, &film);
    const struct scenes_mean mean = scenes_mean(&film, 0);
    film_release(&film);
    scenes_release(s);
    return mean;
}

static void means_are_right(void)
{
    struct scenes s;
    plate(&s, 3);
    struct material *m = &s.scene.materials[0];
    textures_drive(&s, &m->diffuse.albedo, true,
                   textures_checker(&s, rgb_gray(.1f), rgb_gray(.7f), 5));
    const struct scenes_mean checker = plate_mean(&s, 8192);
    const double want = 2 * (.1 * 13 + .7 * 12) / 25;
    near(checker.mean, want, stat_z_limit(.001) * checker.error + 1e-6,
         "a checker of 5 x 5 squares is its mean: %.5f, not %.5f", checker.mean, want);

    static unsigned char pixels[256 * 256];
    for (int i = 0; i < 256 * 256; i++)
        pixels[i] = (i + i / 256) % 2 ? 255 : 51;
    double spread[2], mean[2];
    for (int filter = 0; filter < 2; filter++) {
        plate(&s, 3);
        m = &s.scene.materials[0];
        struct texture *t = textures_image(&s, IMAGE_DEPTH_U8, 256, 256, 1, pixels);
        t->image.filter = filter ? TEXTURE_BILINEAR : TEXTURE_TRILINEAR;
        textures_drive(&s, &m->diffuse.albedo, true, t);
        const struct scenes_mean got = plate_mean(&s, 64);
        spread[filter] = got.error;
        mean[filter] = got.mean;
    }
    ok(fabs(mean[0] / 1.2 - 1) < 5e-4 && fabs(mean[1] - 1.2) < 4 * spread[1],
       "an image of fine squares is its mean, filtered (%.5f) or not (%.5f)", mean[0], mean[1]);
    ok(spread[0] * 10 < spread[1], "and filtered it is not noisy: %.1e, unfiltered %.1e", spread[0],
       spread[1]);
}

/* The same plate in a mirror twice as far away: the cone goes on. */
static void mirrors_keep_the_footprint(void)
{
    static float pixels[64 * 64];
    for (int i = 0; i < 64 * 64; i++)
        pixels[i] = (float)((i + i / 64) % 2);
    double spread[2];
    for (int seen = 0; seen < 2; seen++) {
        struct scenes s;
        plate(&s, 40);
        struct material *m = &s.scene.materials[0];
        textures_drive(&s, &m->diffuse.albedo, true,
                       textures_image(&s, IMAGE_DEPTH_FLOAT, 64, 64, 1, pixels));
        if (seen) { /* look the other way, at a mirror behind */
            scenes_look(&s, vec3_make(.5f, .5f, 20), vec3_make(.5f, .5f, 40), 2 * atan(.5 / 60));
            scenes_quad(&s, scenes_mirror(&s, rgb_gray(1)), vec3_make(-5, -5, 40),
                        vec3_make(0, 11, 0), vec3_make(11, 0, 0));
        }
        const struct scenes_mean got = plate_mean(&s, 64);
        spread[seen] = got.error / got.mean;
    }
    ok(spread[0] < 2e-3 && spread[1] < 2e-3,
       "fine squares are not noisy from afar (%.1e), nor in a mirror (%.1e)", spread[0], spread[1]);
}

/* A plate that a checker makes of two others, or that it makes holes into. */
static void mixes_and_masks(void)
{
    struct scenes s;
    plate(&s, 3);
    const uint32_t dark = scenes_diffuse(&s, rgb_gray(.1f)),
                   light = scenes_diffuse(&s, rgb_gray(.7f));
    const uint32_t mix =
        scenes_material(&s, (struct material){.kind = MATERIAL_MIX, .mix = {dark, light, 1}});
    const struct texture *t = textures_checker(&s, rgb_gray(0), rgb_gray(1), 5);
    textures_drive(&s, &s.scene.materials[mix].mix.amount, false, t);
    s.scene.shapes[0].material = mix;
    const double want = 2 * (.1 * 13 + .7 * 12) / 25;
    const struct scenes_mean mixed = plate_mean(&s, 8192);
    near(mixed.mean, want, stat_z_limit(.001) * mixed.error + 1e-6,
         "a checker of two materials is their mean: %.5f, not %.5f", mixed.mean, want);

    plate(&s, 3); /* black squares before the sky */
    const uint32_t mask =
        scenes_material(&s, (struct material){.kind = MATERIAL_MASK, .mask = {0, 1}});
    t = textures_checker(&s, rgb_gray(0), rgb_gray(1), 5);
    textures_drive(&s, &s.scene.materials[mask].mask.opacity, false, t);
    s.scene.shapes[0].material = mask;
    const struct scenes_mean seen = plate_mean(&s, 8192);
    near(seen.mean, 2 * 13. / 25, stat_z_limit(.001) * seen.error + 1e-6,
         "through a checker of holes is seen what is behind: %.5f, not %.5f", seen.mean,
         2 * 13. / 25);
}

/* The sun straight above a checker of holes, the floor below it. */
static void shadows_have_holes(void)
{
    struct scenes s;
    scenes_init(&s, 8, 8);
    scenes_quad(&s, scenes_diffuse(&s, rgb_gray(1)), vec3_make(0, 0, 0), vec3_make(1, 0, 0),
                vec3_make(0, 1, 0));
    const uint32_t mask =
        scenes_material(&s, (struct material){.kind = MATERIAL_MASK, .mask = {0, 1}});
    textures_drive(&s, &s.scene.materials[mask].mask.opacity, false,
                   textures_checker(&s, rgb_gray(0), rgb_gray(1), 2));
    scenes_quad(&s, mask, vec3_make(0, 0, 1), vec3_make(1, 0, 0), vec3_make(0, 1, 0));
    struct light *sun = scenes_light(&s, LIGHT_DISTANT);
    sun->distant.direction[2] = -1;
    sun->distant.irradiance = rgb_gray((float)FMATH_PI);
    s.scene.settings.max_bounces = 1;
    const struct stage *stage = scenes_stage(&s);
    bool good = true;
    for (int q = 0; q < 4; q++) { /* the floor's quarters, seen from below the plate's edge */
        struct rng rng = rng_make(3, 0, 0, 0);
        const vec3 at = vec3_make(.25f + .5f * (float)(q % 2), .25f + .5f * (float)(q / 2), .5f);
        const struct ray ray = {at, vec3_make(0, 0, -1), INFINITY, 0, 0};
        struct wave_starts starts;
        struct wave wave;
        rgb radiance;
        wave_begin(stage, 1, &ray, &rng, &starts);
        wave_init(&wave, stage, UINT32_MAX, NULL, &radiance);
        wave_put(&wave, 1, &starts, &rng, 0);
        wave_finish(&wave);
        good &= fabs((double)radiance[0] - (q == 0 || q == 3)) < 1e-5;
    }
    ok(good, "shadows of a checker of holes have its holes");
    scenes_release(&s);
}

static void leaves_keep_energy(void)
{
    static const float bright[] = {.9f, .5f, .25f};
    struct scenes s;
    scenes_init(&s, 8, 8);
    const uint32_t m = scenes_material(&s, (struct material){.kind = MATERIAL_LEAF});
    struct material *leaf = &s.scene.materials[m];
    const struct texture *t = textures_image(&s, IMAGE_DEPTH_FLOAT, 1, 1, 3, bright);
    textures_drive(&s, &leaf->leaf.reflectance, true, t);
    textures_drive(&s, &leaf->leaf.transmittance, true, t);
    scenes_sphere(&s, m, vec3_make(0, 0, -3), 1);
    const struct stage *stage = scenes_stage(&s);
    struct material scratch;
    const struct texture_point at = {.5f, .5f, 0, {0}};
    const struct material *got =
        textured_material(stage, stage_at(stage, stage->materials), &at, &scratch);
    const rgb sum = got->leaf.reflectance + got->leaf.transmittance;
    ok(fabsf(sum[0] - 1) < 1e-6f && sum[1] == 1 && sum[2] == .5f &&
           got->leaf.reflectance[0] == got->leaf.transmittance[0],
       "what a leaf reflects and lets through is at most 1 together");
    scenes_release(&s);
}

/* The document in which every parameter of every material is textured. */
static void everything_at_once(void)
{
    struct local l;
    struct film film;
    local_open(&l, "tests/textured.json");
    const struct scene *scene = &l.disk.scene;
    uint32_t bare = 0, bad = 0, bright = 0;
    for (uint32_t i = 0; i < scene->material_count; i++)
        bare += !textured_has(&scene->materials[i]);
    local_render(&l, 8, 1, &film);
    for (size_t i = 0; i < (size_t)64 * 3; i++) {
        bad += !(film.sum[i] >= 0 && film.sum[i] < 1e6);
        bright += film.sum[i] > 1.03 * 16;
    }
    ok(scene->material_count == 13 && bare == 0 && scene->slot_count == 32,
       "all parameters of all materials are textured: %u slots", scene->slot_count);
    ok(bad == 0 && bright == 0, "and in a furnace none returns more than it gets (%u, %u)", bad,
       bright);
    film_release(&film);
    local_release(&l);
}

static void orientation(void)
{
    static const unsigned char rows[] = {255, 0, 0, 0, 255, 0, 0, 0, 255, 255, 255, 255};
    struct scenes s;
    struct film film;
    plate(&s, 3);
    struct material *m = &s.scene.materials[0];
    struct texture *t = textures_image(&s, IMAGE_DEPTH_U8, 2, 2, 3, rows);
    t->image.filter = TEXTURE_NEAREST;
    textures_drive(&s, &m->diffuse.albedo, true, t);
    scenes_render(scenes_stage(&s), 16, &film);
    static const size_t at[] = {9, 14, 49, 54}; /* the quarters' middles, from the top left */
    bool good = true;
    for (int q = 0; q < 4; q++) {
        double c[3];
        film_mean(&film, at[q], c);
        for (int k = 0; k < 3; k++)
            good &= fabs(c[k] - 2 * rows[3 * q + k] / 255.) < 1e-5;
    }
    ok(good, "an image on a quad is seen as it is in the file");
    film_release(&film);
    scenes_release(&s);
}

int main(void)
{
    values_stay_in_range();
    constants();
    means_are_right();
    mirrors_keep_the_footprint();
    mixes_and_masks();
    shadows_have_holes();
    leaves_keep_energy();
    everything_at_once();
    orientation();
    return tap_done();
}
