/* SPDX-License-Identifier: MIT */
#include "common/trace/render.h"

#include <assert.h>
#include <string.h>

#include "common/trace/camera.h"
#include "common/trace/layer.h"
#include "common/trace/path.h"
#include "common/trace/rng.h"

/* A sample above this is taken for an error. SCENE_MAX_SPP = 2^24 samples below it add up to less
 * than 2^127, so that no sum leaves the range of float. */
#define RENDER_MAX_RADIANCE 0x1p+102f

_Static_assert((int)FILM_REPLICATES == (int)PATH_WAVE, "an octet is a wave");

/* A pixel's eight samples that differ in their replicate only: what they have in common is done
 * once, and their rays in the lanes of vectors. */
struct octet {
    const struct stage *stage;
    uint32_t x_px, y_px;
    struct rng_pixel rng;
    struct camera_rays rays;
    uint32_t elder;            /* whose rays they are; UINT32_MAX: nobody's */
    uint32_t begun;            /* bit i: starts[i] is the elder's, too */
    struct path_starts starts; /* for two siblings each */
};

static void octet_init(struct octet *o, const struct stage *s, uint32_t x_px, uint32_t y_px)
{
    o->stage = s;
    o->x_px = x_px;
    o->y_px = y_px;
    o->elder = UINT32_MAX;
    rng_pixel_init(&o->rng, s->settings.seed, x_px, y_px);
}

/* Through the lens, if there is one. Apart, so that the pinhole's way stays short. */
__attribute__((noinline)) static void octet_aim(struct octet *o, f32x8 x, f32x8 y)
{
    struct sobol8_square lens = {{0}, {0}};
    if (o->stage->camera.kind == CAMERA_THIN_LENS)
        lens = rng_pixel_lens(&o->rng);
    camera_rays_through(&o->stage->camera, x, y, &lens, &o->rays);
}

/* Samples [8 index, 8 index + 8). */
static void octet_go(struct octet *o, uint32_t index)
{
    const struct stage *s = o->stage;
    rng_pixel_go(&o->rng, index);
    if (o->elder == index / 2)
        return;
    o->elder = index / 2;
    o->begun = 0;
    const struct sobol8_square q = rng_pixel_filter(&o->rng);
    const f32x8 x = (float)o->x_px + 0.5f + camera_filter(&s->film, q.u);
    const f32x8 y = (float)o->y_px + 0.5f + camera_filter(&s->film, q.v);
    if (s->camera.kind == CAMERA_PERSPECTIVE)
        camera_rays(&s->camera, x, y, &o->rays);
    else
        octet_aim(o, x, y);
}

/* The camera rays of the replicates whose bit is set in `which`. */
static void octet_begin(struct octet *o, uint32_t which)
{
    struct ray rays[FILM_REPLICATES];
    if (!(which & ~o->begun))
        return;
    for (uint32_t i = 0; i < FILM_REPLICATES; i++)
        rays[i] = camera_rays_at(&o->stage->camera, &o->rays, i);
    path_begin(o->stage, which, rays, &o->starts);
    o->begun = which;
}

/* Radiance of those, by replicate, and its terms if they are asked for. */
static void octet_radiance(struct octet *o, uint32_t which, rgb radiance[FILM_REPLICATES],
                           struct path_terms *terms)
{
    const struct stage *s = o->stage;
    octet_begin(o, which);
    switch (s->settings.integrator) {
    case INTEGRATOR_PATH:
        path_radiance(s, which, &o->starts, o->rng.replicate, PATH_ROULETTE_BEGIN, terms, radiance);
        return;
    }
    __builtin_unreachable();
}

rgb render_sample(const struct stage *s, uint32_t x_px, uint32_t y_px, uint32_t sample)
{
    const uint32_t replicate = sample % FILM_REPLICATES;
    struct octet o;
    rgb radiance[FILM_REPLICATES];
    octet_init(&o, s, x_px, y_px);
    octet_go(&o, sample / FILM_REPLICATES);
    octet_radiance(&o, 1u << replicate, radiance, NULL);
    return radiance[replicate];
}

/* False for a NaN. */
static bool is_valid(rgb c)
{
    const rgb least = rgb_gray(0), most = rgb_gray(RENDER_MAX_RADIANCE);
    return (i32x4_mask((c >= least) & (c <= most)) & 7) == 7;
}

/* One pixel's pass. */
struct pixel {
    f64x4 sums[FILM_REPLICATES];
    double layers[LAYERS_MAX_CHANNELS];
    struct path_terms terms;
};

/* What one octet adds: the samples [begin, end), all of it. */
static void add_octet(struct octet *o, struct pixel *to, struct film_samples *out, uint32_t begin,
                      uint32_t end)
{
    const uint32_t first = begin % FILM_REPLICATES, which = (1u << (end - begin)) - 1;
    rgb radiance[FILM_REPLICATES];
    octet_go(o, begin / FILM_REPLICATES);
    octet_radiance(o, which << first, radiance, to->terms.count ? &to->terms : NULL);
    for (uint32_t sample = begin; sample < end; sample++) {
        const uint32_t i = sample % FILM_REPLICATES;
        if (out->layers)
            layer_surface(o->stage, out->layers, &o->starts, &o->rng.replicate[i], sample,
                          to->layers);
        if (!is_valid(radiance[i])) {
            film_samples_note_invalid(out, (struct film_key){o->x_px, o->y_px, sample});
            continue;
        }
        to->sums[i] += f64x4_of(radiance[i]);
        if (to->terms.count)
            layer_bounces(out->layers, &to->terms, i, radiance[i], to->layers);
    }
}

static void render_pixel(const struct stage *s, struct film_samples *out, uint32_t x_px,
                         uint32_t y_px, float sums[FILM_CHANNELS], float layers[])
{
    const uint32_t channels = layers_channels(out->layers);
    struct pixel pixel;
    struct octet octet;
    memset(pixel.sums, 0, sizeof pixel.sums);
    memset(pixel.layers, 0, channels * sizeof pixel.layers[0]);
    pixel.terms.count = layers_bounces(out->layers);
    octet_init(&octet, s, x_px, y_px);
    for (uint32_t i = out->pass.s_begin, end; i < out->pass.s_end; i = end) {
        end = i - i % FILM_REPLICATES + FILM_REPLICATES;
        if (end > out->pass.s_end)
            end = out->pass.s_end;
        add_octet(&octet, &pixel, out, i, end);
    }
    for (int i = 0; i < FILM_REPLICATES; i++)
        vec3_store(sums + 3 * i, f64x4_round(pixel.sums[i]));
    for (uint32_t i = 0; i < channels; i++)
        layers[i] = (float)pixel.layers[i];
}

void render_row(const struct stage *s, struct film_samples *out, uint32_t y_px)
{
    const struct tile_rect r = out->rect;
    assert(y_px >= r.y_begin && y_px < r.y_end);
    const size_t channels = layers_channels(out->layers);
    const size_t before = (size_t)(y_px - r.y_begin) * (r.x_end - r.x_begin);
    float *sums = out->sums + before * FILM_CHANNELS;
    float *layers = channels ? out->layer_sums + before * channels : NULL;
    for (uint32_t x = r.x_begin; x < r.x_end; x++, sums += FILM_CHANNELS) {
        render_pixel(s, out, x, y_px, sums, layers);
        if (layers)
            layers += channels;
    }
}

void render_tile(const struct stage *s, struct film_samples *out)
{
    for (uint32_t y = out->rect.y_begin; y < out->rect.y_end; y++)
        render_row(s, out, y);
}
