/* SPDX-License-Identifier: MIT */
#include "common/trace/render.h"

#include <assert.h>

#include "common/trace/camera.h"
#include "common/trace/path.h"
#include "common/trace/rng.h"

/* A sample above this is taken for an error. SCENE_MAX_SPP = 2^24 samples below it add up to less
 * than 2^127, so that no sum leaves the range of float. */
#define RENDER_MAX_RADIANCE 0x1p+102f

/* A pixel's eight samples that differ in their replicate only: what they have in common is done
 * once, and their rays in the lanes of vectors. */
struct octet {
    const struct stage *stage;
    uint32_t x_px, y_px;
    struct rng_pixel rng;
    struct camera_rays rays;
    uint32_t elder;                           /* whose rays they are; UINT32_MAX: nobody's */
    bool begun[FILM_REPLICATES];              /* start is the elder's, too */
    struct path_start start[FILM_REPLICATES]; /* for two siblings each */
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
    const struct sobol8_square q = rng_pixel_filter(&o->rng);
    const f32x8 x = (float)o->x_px + 0.5f + camera_filter(&s->film, q.u);
    const f32x8 y = (float)o->y_px + 0.5f + camera_filter(&s->film, q.v);
    camera_rays(&s->camera, x, y, &o->rays);
    for (int i = 0; i < FILM_REPLICATES; i++)
        o->begun[i] = false;
}

static rgb octet_sample(struct octet *o, uint32_t replicate)
{
    const struct stage *s = o->stage;
    struct path_start *start = &o->start[replicate];
    switch (s->settings.integrator) {
    case INTEGRATOR_PATH:
        if (!o->begun[replicate]) {
            path_begin(s, camera_rays_at(&s->camera, &o->rays, replicate), start);
            o->begun[replicate] = true;
        }
        return path_radiance(s, start, &o->rng.replicate[replicate], PATH_ROULETTE_BEGIN);
    }
    __builtin_unreachable();
}

rgb render_sample(const struct stage *s, uint32_t x_px, uint32_t y_px, uint32_t sample)
{
    struct octet o;
    octet_init(&o, s, x_px, y_px);
    octet_go(&o, sample / FILM_REPLICATES);
    return octet_sample(&o, sample % FILM_REPLICATES);
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
    for (uint32_t i = out->pass.s_begin; i < out->pass.s_end; i++) {
        const uint32_t replicate = i % FILM_REPLICATES;
        if (replicate == 0 || i == out->pass.s_begin)
            octet_go(&octet, i / FILM_REPLICATES);
        const rgb c = octet_sample(&octet, replicate);
        if (!is_valid(c)) {
            film_samples_note_invalid(out, (struct film_key){x_px, y_px, i});
            continue;
        }
        exact[replicate] += f64x4_of(c);
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
