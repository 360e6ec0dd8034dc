/* SPDX-License-Identifier: MIT */
#include "tests/fake_job.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "server/round.h"

struct store_job fake_job_row(uint32_t width_px, uint32_t height_px, struct scene_target target)
{
    static uint64_t last = 0xfedcba9800000000; /* as large as ids get */
    last++;
    struct store_job row = {
        .id = last,
        .number = last & 0xffffffff,
        .width_px = width_px,
        .height_px = height_px,
        .tile_px = 8,
        .crop = {0, 0, width_px, height_px},
        .target = target,
        .error = -1,
    };
    hash_hex("fake", 4, row.document);
    snprintf(row.title, sizeof row.title, "fake");
    return row;
}

struct job *fake_job_of(const struct store_job *row)
{
    struct job *j = job_new(row);
    struct film film;
    struct adaptive none;
    film_init(&film, row->crop);
    film_add_layers(&film, row->layers);
    adaptive_init(&none, row->crop);
    job_open(j, &film, &none, 0);
    return j;
}

struct job *fake_job_open(uint32_t width_px, uint32_t height_px, struct scene_target target)
{
    const struct store_job row = fake_job_row(width_px, height_px, target);
    return fake_job_of(&row);
}

/* As if all samples of a replicate had its mean. */
static void add_evidence(struct film_samples *s, uint32_t x, uint32_t y, const float *sums)
{
    struct block *b = &s->blocks[(y - s->rect.y_begin) / BLOCK_PX * block_columns(s->rect) +
                                 (x - s->rect.x_begin) / BLOCK_PX];
    for (uint32_t r = 0; r < FILM_REPLICATES; r++) {
        const uint32_t n =
            film_replicate_spp(s->pass.s_end, r) - film_replicate_spp(s->pass.s_begin, r);
        const float *sum = sums + 3 * r;
        for (uint32_t i = 0; i < n; i++)
            block_add(b, rgb_luminance((rgb){sum[0], sum[1], sum[2], 0} / (float)n));
    }
    b->met += s->pass.s_end - s->pass.s_begin;
}

static void fill_pixel(struct film_samples *s, uint32_t x, uint32_t y, float noise)
{
    const struct tile_rect t = s->rect;
    const size_t at = (size_t)(y - t.y_begin) * (t.x_end - t.x_begin) + (x - t.x_begin);
    float *sums = s->sums + at * FILM_CHANNELS;
    const bool quiet = x >= 2 * BLOCK_PX;
    const float most = noise * (quiet ? .125f : 1) / sqrtf((float)s->pass.s_end / 8);
    for (uint32_t r = 0; r < FILM_REPLICATES; r++)
        for (uint32_t c = 0; c < 3; c++) {
            const float n = (float)(film_replicate_spp(s->pass.s_end, r) -
                                    film_replicate_spp(s->pass.s_begin, r));
            const float level = (float)(1 + (x * 7 + y * 13 + c * 5) % 11);
            const float wobble = (float)((x + y * 3 + r * 17 + s->pass.s_end * 29) % 19) / 19;
            sums[3 * r + c] = n * (level + most * wobble);
        }
    add_evidence(s, x, y, sums);
}

void fake_job_fill(struct film_samples *s, float noise)
{
    for (uint32_t y = s->rect.y_begin; y < s->rect.y_end; y++)
        for (uint32_t x = s->rect.x_begin, end; film_samples_run(s, y, &x, &end);)
            for (; x < end; x++)
                fill_pixel(s, x, y, noise);
}

struct wire_samples fake_job_payload(const struct job *j, uint32_t tile, uint32_t pass, float noise,
                                     struct arena *arena)
{
    struct wire_samples w = {
        .job = j->row.id,
        .tile = tile,
        .pass = pass,
        .cpu_us = 1000,
        .samples = film_samples_make(tile_rect_of(&j->grid, tile),
                                     tile_pass_of(pass, j->row.target.spp), arena),
    };
    if (job_in_window(j, tile, pass) && round_lacks(j, tile, pass)) {
        const struct block_set lacking = round_blocks(j, tile, pass);
        film_samples_restrict(&w.samples, &lacking);
    }
    fake_job_fill(&w.samples, noise);
    return w;
}
