/* SPDX-License-Identifier: MIT */
#include "tests/stability/trial.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "common/trace/path.h"
#include "common/trace/prep.h"
#include "common/trace/render.h"
#include "tests/scale.h"
#include "tests/scenes.h"

enum { SIDE = 8, SPP = 16 };

const char *const trial_names[TRIALS] = {
    [TRIAL_VALID] = "valid",     [TRIAL_ALONE] = "alone",   [TRIAL_LANES] = "lanes",
    [TRIAL_SCALED] = "scaled",   [TRIAL_BRIGHT] = "bright", [TRIAL_LAYERS] = "layers",
    [TRIAL_FURNACE] = "furnace", [TRIAL_MEANS] = "means"};

struct trial_counts trial_counts;

const struct stage *trial_stage(const struct scene *scene, struct arena *arena)
{
    const struct stage *stage = NULL;
    struct arena scratch = {0};
    struct err err;
    const bool fine = prep_stage(scene, NULL, arena, &scratch, &stage, &err);
    arena_release(&scratch);
    return fine ? stage : NULL;
}

static void render(const struct scene *scene, uint32_t spp, struct film *film)
{
    struct arena arena = {0};
    scenes_render(trial_stage(scene, &arena), spp, film);
    arena_release(&arena);
}

/* --- valid --- */

static bool is_valid(const struct film *f, bool is_signed)
{
    for (size_t i = 0; i < SIDE * SIDE * FILM_CHANNELS; i++)
        if (!isfinite(f->replicate[i]) || (!is_signed && f->replicate[i] < 0))
            return false;
    return f->invalid_count == 0;
}

static bool valid(const struct wild *w, char why[240])
{
    struct film film;
    render(&w->scene, 4 * SPP, &film);
    const bool fine = is_valid(&film, w->traits & WILD_SIGNED);
    const struct film_key k = film.keys[0];
    if (!fine)
        snprintf(why, 240, "%lu invalid, the first at %u, %u, sample %u",
                 (unsigned long)film.invalid_count, k.x_px, k.y_px, k.sample);
    film_release(&film);
    return fine;
}

/* --- alone --- */

static bool same_samples(const struct film_samples *whole, const struct film_samples *part)
{
    for (uint32_t y = part->rect.y_begin; y < part->rect.y_end; y++)
        for (uint32_t x = part->rect.x_begin; x < part->rect.x_end; x++) {
            const uint32_t width = part->rect.x_end - part->rect.x_begin;
            const uint32_t i = (y - part->rect.y_begin) * width + x - part->rect.x_begin;
            if (memcmp(whole->sums + (size_t)(SIDE * y + x) * FILM_CHANNELS,
                       part->sums + (size_t)i * FILM_CHANNELS, FILM_CHANNELS * sizeof(float)) != 0)
                return false;
        }
    return true;
}

/* With a filter that has no weights. Each replicate has one sample of a pass of eight. */
static bool same_as_samples(const struct stage *s, const struct film_samples *whole)
{
    for (uint32_t i = 0; i < 32; i++) {
        const uint32_t x = i % SIDE, y = 3 * i % SIDE, sample = i % FILM_REPLICATES;
        const rgb one = render_sample(s, x, y, sample);
        const float *sum = whole->sums + (size_t)(SIDE * y + x) * FILM_CHANNELS + 3 * sample;
        if (memcmp(&one, sum, 3 * sizeof(float)) != 0)
            return false;
    }
    return true;
}

static struct film_samples part_of(const struct stage *s, struct tile_rect rect, uint32_t spp,
                                   struct arena *arena)
{
    struct film_samples part = film_samples_make(rect, tile_pass_of(0, spp), arena);
    render_tile(s, &part);
    return part;
}

static bool alone(const struct wild *w, char why[240])
{
    static const struct tile_rect rects[] = {{0, 5, SIDE, 6}, {3, 0, 4, SIDE}, {2, 1, 7, 5}};
    struct arena arena = {0};
    struct scene scene = w->scene;
    scene.settings.sampler = (enum sampler_kind)(w->seed % 3);
    scene.settings.strategy = (enum strategy_kind)(w->seed / 3 % 3);
    const struct stage *s = trial_stage(&scene, &arena);
    const struct film_samples whole = part_of(s, (struct tile_rect){0, 0, SIDE, SIDE}, 8, &arena);
    bool fine = true;
    for (size_t i = 0; fine && i < countof(rects); i++) {
        const struct film_samples part = part_of(s, rects[i], 8, &arena);
        fine = same_samples(&whole, &part);
        snprintf(why, 240, "tile %zu", i);
    }
    if (fine && !(w->traits & WILD_SIGNED) && !same_as_samples(s, &whole)) {
        fine = false;
        snprintf(why, 240, "samples");
    }
    arena_release(&arena);
    return fine;
}

/* --- lanes --- */

static bool lanes(const struct wild *w, char why[240])
{
    struct arena arena = {0};
    struct scene scene = w->scene;
    scene.settings.strategy = (enum strategy_kind)(w->seed / 2 % 3);
    const struct stage *s = trial_stage(&scene, &arena);
    bool fine = true;
    for (uint32_t i = 0; fine && i < SIDE * SIDE * SPP; i++) {
        const uint32_t x = i % SIDE, y = i / SIDE % SIDE, sample = i / (SIDE * SIDE);
        const rgb one = trial_path(s, x, y, sample, PATH_ROULETTE_BEGIN);
        const rgb wave = render_sample(s, x, y, sample);
        fine = !memcmp(&one, &wave, 3 * sizeof(float));
        snprintf(why, 240, "at %u, %u, sample %u: %.9g is %.9g", x, y, sample, (double)one[1],
                 (double)wave[1]);
    }
    arena_release(&arena);
    return fine;
}

/* --- scaled, bright --- */

/* A scene of its own to change, but for meshes and images. */
static struct scene copy_of(const struct scene *from, struct arena *arena)
{
    struct scene s = *from;
    s.shapes = arena_new(arena, struct shape, s.shape_count + 1);
    s.lights = arena_new(arena, struct light, s.light_count + 1);
    s.materials = arena_new(arena, struct material, s.material_count + 1);
    memcpy(s.shapes, from->shapes, s.shape_count * sizeof *s.shapes);
    memcpy(s.lights, from->lights, s.light_count * sizeof *s.lights);
    memcpy(s.materials, from->materials, s.material_count * sizeof *s.materials);
    return s;
}

/* b is a, each value times k; but where numbers are so small that they lose bits by being so. */
static bool same_film(const struct film *a, const struct film *b, float k, char why[240])
{
    for (size_t i = 0; i < SIDE * SIDE * FILM_CHANNELS; i++)
        if (a->replicate[i] * k != b->replicate[i] && !(fabsf(a->replicate[i]) < 0x1p-100f)) {
            snprintf(why, 240, "at %zu, %zu: %.9g is %.9g", i / FILM_CHANNELS % SIDE,
                     i / FILM_CHANNELS / SIDE, (double)a->replicate[i],
                     (double)(b->replicate[i] / k));
            return false;
        }
    return true;
}

static bool as_before(const struct wild *w, const struct scene *changed, float k, char why[240])
{
    struct film a, b;
    render(&w->scene, SPP, &a);
    render(changed, SPP, &b);
    const bool fine = same_film(&a, &b, k, why);
    film_release(&a);
    film_release(&b);
    return fine;
}

/* Towards 1, so that nothing leaves the range of float by it. */
static bool scaled(const struct wild *w, char why[240])
{
    struct arena arena = {0};
    struct scene s = copy_of(&w->scene, &arena);
    scale_lengths(&s, w->unit > 1 ? 0x1p-11f : 0x1p+11f);
    const bool fine = as_before(w, &s, 1, why);
    arena_release(&arena);
    return fine;
}

static bool bright(const struct wild *w, char why[240])
{
    struct arena arena = {0};
    struct scene s = copy_of(&w->scene, &arena);
    const float k = w->gain > 1 ? 0x1p-20f : 0x1p+20f;
    scale_radiance(&s, k);
    const bool fine = as_before(w, &s, k, why);
    arena_release(&arena);
    return fine;
}

/* --- layers --- */

/* The terms of light, in floats, add up to the image. Of a filter with a negative part each is a
 * difference by itself, and keeps fewer digits. */
static bool adds_up(const struct film *f, bool is_signed, char why[240])
{
    const double tolerance = is_signed ? 1e-3 : 1e-5;
    const uint32_t channels = layers_channels(f->layers), at = layers_bounces_at(f->layers);
    for (size_t i = 0; i < SIDE * SIDE; i++)
        for (uint32_t c = 0; c < 3; c++) {
            double sum = 0, size = 0;
            for (uint32_t k = 0; k <= layers_bounces(f->layers); k++) {
                const double term = f->layer[i * channels + at + 3 * k + c];
                sum += term;
                size += fabs(term);
            }
            if (fabs(sum - f->sum[3 * i + c]) > tolerance * size) {
                snprintf(why, 240, "at %zu, %zu: terms add up to %.9g of %.9g", i % SIDE, i / SIDE,
                         sum, f->sum[3 * i + c]);
                return false;
            }
        }
    return true;
}

static bool finite_layers(const struct film *f, char why[240])
{
    for (size_t i = 0; i < SIDE * SIDE * layers_channels(f->layers); i++)
        if (!isfinite(f->layer[i])) {
            snprintf(why, 240, "layer channel %zu is no finite number",
                     i % layers_channels(f->layers));
            return false;
        }
    return true;
}

static bool layers(const struct wild *w, char why[240])
{
    struct film a, b;
    struct scene s = w->scene;
    render(&s, SPP, &a);
    s.film.layers = layers_make(LAYER_SURFACE, 1 + w->seed % LAYERS_MAX_BOUNCES);
    render(&s, SPP, &b);
    const bool fine = same_film(&a, &b, 1, why) && adds_up(&b, w->traits & WILD_SIGNED, why) &&
                      finite_layers(&b, why);
    film_release(&a);
    film_release(&b);
    return fine;
}

enum trial_verdict trial_run(enum trial trial, const struct wild *w, uint32_t rounds, char why[240])
{
    static bool (*const exact[])(const struct wild *, char[240]) = {
        [TRIAL_VALID] = valid,   [TRIAL_ALONE] = alone,   [TRIAL_LANES] = lanes,
        [TRIAL_SCALED] = scaled, [TRIAL_BRIGHT] = bright, [TRIAL_LAYERS] = layers};
    if (trial == TRIAL_FURNACE)
        return trial_furnace(w, rounds, why);
    if (trial == TRIAL_MEANS)
        return trial_means(w, rounds, why);
    return exact[trial](w, why) ? TRIAL_HOLDS : TRIAL_FAILS;
}
