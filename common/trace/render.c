/* SPDX-License-Identifier: MIT */
#include "common/trace/render.h"

#include <assert.h>

#include "common/trace/camera.h"
#include "common/trace/path.h"
#include "common/trace/rng.h"

/* A sample above this is taken for an error. SCENE_MAX_SPP = 2^24 samples below it add up to less
 * than 2^127, so that no sum leaves the range of float. */
#define RENDER_MAX_RADIANCE 0x1p+102f

rgb render_sample(const struct stage *s, uint32_t x_px, uint32_t y_px, uint32_t sample)
{
    const struct rng rng = rng_make(s->settings.seed, x_px, y_px, sample);
    const struct square q = rng_pair(&rng, RNG_FILTER);
    const float x = (float)x_px + 0.5f + camera_filter(&s->film, q.u);
    const float y = (float)y_px + 0.5f + camera_filter(&s->film, q.v);
    const struct ray ray = camera_ray(&s->camera, x, y);
    switch (s->settings.integrator) {
    case INTEGRATOR_PATH:
        return path_radiance(s, ray, &rng, PATH_ROULETTE_BEGIN);
    }
    __builtin_unreachable();
}

/* False for a NaN. */
static bool is_valid(rgb c)
{
    return c[0] >= 0 && c[1] >= 0 && c[2] >= 0 && rgb_max(c) <= RENDER_MAX_RADIANCE;
}

static void render_pixel(const struct stage *s, struct film_samples *out, uint32_t x_px,
                         uint32_t y_px, float sums[FILM_CHANNELS])
{
    double exact[FILM_REPLICATES][3] = {{0}};
    for (uint32_t i = out->pass.s_begin; i < out->pass.s_end; i++) {
        const rgb c = render_sample(s, x_px, y_px, i);
        if (!is_valid(c)) {
            film_samples_note_invalid(out, (struct film_key){x_px, y_px, i});
            continue;
        }
        double *sum = exact[i % FILM_REPLICATES];
        for (int k = 0; k < 3; k++)
            sum[k] += (double)c[k];
    }
    for (int i = 0; i < FILM_CHANNELS; i++)
        sums[i] = (float)exact[i / 3][i % 3];
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
