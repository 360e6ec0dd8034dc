/* SPDX-License-Identifier: MIT */
#include "common/trace/render.h"

#include <assert.h>

#include "common/trace/camera.h"
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
    uint32_t elder;                            /* whose rays they are; UINT32_MAX: nobody's */
    uint32_t begun;                            /* bit i: starts[i] is the elder's, too */
    struct path_start starts[FILM_REPLICATES]; /* for two siblings each */
};

static void octet_init(struct octet *o, const struct stage *s, uint32_t x_px, uint32_t y_px)
{
    o->stage = s;
    o->x_px = x_px;
    o->y_px = y_px;
    o->elder = UINT32_MAX;
    rng_pixel_init(&o->rng, s->settings.seed, x_px, y_px);
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
    camera_rays(&s->camera, x, y, &o->rays);
}

/* The camera rays of replicates [begin, end). */
static void octet_begin(struct octet *o, uint32_t begin, uint32_t end)
{
    struct ray rays[FILM_REPLICATES];
    const uint32_t wanted = (1u << end) - (1u << begin);
    if ((o->begun & wanted) == wanted)
        return;
    for (uint32_t i = begin; i < end; i++)
        rays[i - begin] = camera_rays_at(&o->stage->camera, &o->rays, i);
    path_begin(o->stage, rays, &o->rng.replicate[begin], end - begin, &o->starts[begin]);
    o->begun |= wanted;
}

/* Radiance of those with replicates [begin, end). */
static void octet_radiance(struct octet *o, uint32_t begin, uint32_t end, rgb radiance[])
{
    const struct stage *s = o->stage;
    switch (s->settings.integrator) {
    case INTEGRATOR_PATH:
        octet_begin(o, begin, end);
        path_radiance(s, &o->starts[begin], &o->rng.replicate[begin], end - begin,
                      PATH_ROULETTE_BEGIN, radiance);
        return;
    }
    __builtin_unreachable();
}

rgb render_sample(const struct stage *s, uint32_t x_px, uint32_t y_px, uint32_t sample)
{
    const uint32_t replicate = sample % FILM_REPLICATES;
    struct octet o;
    rgb radiance;
    octet_init(&o, s, x_px, y_px);
    octet_go(&o, sample / FILM_REPLICATES);
    octet_radiance(&o, replicate, replicate + 1, &radiance);
    return radiance;
}

/* False for a NaN. */
static bool is_valid(rgb c)
{
    const rgb least = rgb_gray(0), most = rgb_gray(RENDER_MAX_RADIANCE);
    return (i32x4_mask((c >= least) & (c <= most)) & 7) == 7;
}

static void render_pixel(const struct stage *s, struct film_samples *out, uint32_t x_px,
                         uint32_t y_px, float sums[FILM_CHANNELS])
{
    f64x4 exact[FILM_REPLICATES] = {{0}};
    struct octet octet;
    octet_init(&octet, s, x_px, y_px);
    for (uint32_t i = out->pass.s_begin, end; i < out->pass.s_end; i = end) {
        const uint32_t begin = i % FILM_REPLICATES, first = i - begin;
        rgb radiance[FILM_REPLICATES];
        end = first + FILM_REPLICATES;
        if (end > out->pass.s_end)
            end = out->pass.s_end;
        octet_go(&octet, first / FILM_REPLICATES);
        octet_radiance(&octet, begin, end - first, radiance);
        for (uint32_t k = i; k < end; k++) {
            const rgb c = radiance[k - i];
            if (is_valid(c))
                exact[k % FILM_REPLICATES] += f64x4_of(c);
            else
                film_samples_note_invalid(out, (struct film_key){x_px, y_px, k});
        }
    }
    for (int i = 0; i < FILM_REPLICATES; i++)
        vec3_store(sums + 3 * i, f64x4_round(exact[i]));
}

void render_row(const struct stage *s, struct film_samples *out, uint32_t y_px)
{
    const struct tile_rect r = out->rect;
    assert(y_px >= r.y_begin && y_px < r.y_end);
    float *row = out->sums + (size_t)(y_px - r.y_begin) * (r.x_end - r.x_begin) * FILM_CHANNELS;
    for (uint32_t x = r.x_begin; x < r.x_end; x++, row += FILM_CHANNELS)
        render_pixel(s, out, x, y_px, row);
}

void render_tile(const struct stage *s, struct film_samples *out)
{
    for (uint32_t y = out->rect.y_begin; y < out->rect.y_end; y++)
        render_row(s, out, y);
}
