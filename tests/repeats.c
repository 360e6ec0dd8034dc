/* SPDX-License-Identifier: MIT */
#include "tests/repeats.h"

#include <math.h>
#include <string.h>

#include "common/trace/render.h"

static void take(struct repeats *to, struct repeats_look *look, const struct film *f)
{
    struct arena scratch = {0};
    const struct evidence e = evidence_make(f, &scratch);
    look->mean = arena_new(&to->arena, float, 3 * to->pixels);
    look->error = arena_new(&to->arena, float, 3 * to->pixels);
    look->verdict = arena_new(&to->arena, enum evidence_verdict, to->pixels);
    for (size_t i = 0; i < to->pixels; i++) {
        double mean[3], error[3];
        film_mean(f, i, mean);
        estimate_pixel(f, i, error);
        for (size_t c = 0; c < 3; c++) {
            look->mean[3 * i + c] = (float)mean[c];
            look->error[3 * i + c] = (float)error[c];
        }
    }
    for (size_t b = 0; b < (size_t)e.columns * e.rows; b++) {
        const struct tile_rect r = block_rect_of(f->window, b);
        const uint32_t width = f->window.x_end - f->window.x_begin;
        for (uint32_t y = r.y_begin; y < r.y_end; y++)
            for (uint32_t x = r.x_begin; x < r.x_end; x++)
                look->verdict[(size_t)(y - f->window.y_begin) * width + x - f->window.x_begin] =
                    e.blocks[b].verdict;
    }
    look->interval = estimate_interval(f);
    look->estimate = estimate_error(f);
    arena_release(&scratch);
}

static void repeat(struct repeats *to, uint32_t number, const struct stage *stage)
{
    const struct scene_film *w = &stage->film;
    const struct tile_rect window = {0, 0, w->width_px, w->height_px};
    const uint32_t most = to->spp[to->levels - 1];
    struct arena arena = {0};
    struct film f;
    film_init(&f, window);
    for (uint32_t p = 0, level = 0; level < to->levels; p++) {
        struct film_samples s = film_samples_make(window, tile_pass_of(p, most), &arena);
        render_tile(stage, &s);
        film_merge(&f, &s);
        if (s.pass.s_end == to->spp[level])
            take(to, &to->look[level++][number], &f);
        arena_reset(&arena);
    }
    for (size_t i = 0; i < 3 * to->pixels; i++)
        to->total[i] += (double)to->look[to->levels - 1][number].mean[i];
    film_release(&f);
    arena_release(&arena);
}

/* A stage's seed may be set in a copy of it. */
void repeats_make(struct repeats *to, const struct stage *stage)
{
    struct arena arena = {0};
    struct stage *copy = arena_alloc(&arena, stage->bytes, 1, STAGE_ALIGN);
    memcpy(copy, stage, stage->bytes);
    to->arena = (struct arena){0};
    to->pixels = (size_t)stage->film.width_px * stage->film.height_px;
    to->total = arena_new(&to->arena, double, 3 * to->pixels);
    copy->settings.target.spp = to->spp[to->levels - 1];
    for (uint32_t i = 0; i < to->count; i++) {
        copy->settings.seed = 1000 + i;
        repeat(to, i, copy);
    }
    arena_release(&arena);
}

void repeats_release(struct repeats *r)
{
    arena_release(&r->arena);
}

double repeats_others(const struct repeats *s, uint32_t r, size_t at)
{
    return (s->total[at] - (double)s->look[s->levels - 1][r].mean[at]) / (s->count - 1);
}

double repeats_wider(const struct repeats *s, uint32_t level)
{
    return 1 + (double)s->spp[level] / ((s->count - 1) * (double)s->spp[s->levels - 1]);
}

bool repeats_is_noisy(const struct repeats *s, uint32_t level, size_t at)
{
    const double mean = s->total[at] / s->count;
    for (uint32_t r = 0; r < s->count; r++)
        if (fabs((double)s->look[level][r].mean[at] - mean) > REPEATS_ROUNDING * mean)
            return true;
    return false;
}

double repeats_relmse(const struct repeats *s, uint32_t level, uint32_t r)
{
    const double n = 3 * (double)s->pixels;
    double least = 0, sum = 0;
    for (size_t at = 0; at < 3 * s->pixels; at++)
        least += .01 * repeats_others(s, r, at) / n;
    for (size_t at = 0; at < 3 * s->pixels; at++) {
        const double y = repeats_others(s, r, at), off = (double)s->look[level][r].mean[at] - y;
        if (off != 0)
            sum += off * off / (y * y + least * least);
    }
    return sum / (repeats_wider(s, level) * n);
}
