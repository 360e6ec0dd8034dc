/* SPDX-License-Identifier: MIT */
#include "tests/adapt.h"

#include "common/trace/render.h"

void adapt_init(struct adapt *a, struct tile_rect window, uint32_t tile_px)
{
    *a = (struct adapt){.tile_px = tile_px};
    film_init(&a->film, window);
    adaptive_init(&a->adaptive, window);
}

void adapt_release(struct adapt *a)
{
    film_release(&a->film);
    adaptive_release(&a->adaptive);
}

/* Whether there was anything to do. */
static bool merge_round(struct adapt *a, struct tile_pass pass, adapt_fill *fill,
                        const void *context)
{
    const struct tile_grid grid = tile_grid_make(a->film.window, a->tile_px);
    struct arena arena = {0};
    bool any = false;
    for (uint32_t t = 0; t < tile_count(&grid); t++) {
        const struct tile_rect rect = tile_rect_of(&grid, t);
        const struct block_set lacking = adaptive_blocks(&a->adaptive, &a->film, rect, pass);
        if (block_set_count(&lacking) == 0)
            continue;
        struct film_samples s = film_samples_make(rect, pass, &arena);
        film_samples_restrict(&s, &lacking);
        fill(context, &s);
        film_merge(&a->film, &s);
        arena_reset(&arena);
        any = true;
    }
    arena_release(&arena);
    return any;
}

static void write_down(struct adapt *a)
{
    struct arena arena = {0};
    const struct adaptive_look look = adaptive_look(&a->film, a->spp, &a->adaptive, &arena);
    adaptive_add(&a->adaptive, &look);
    arena_release(&arena);
}

bool adapt_run(struct adapt *a, double target, uint32_t spp, adapt_fill *fill, const void *context)
{
    adaptive_aim(&a->adaptive, target);
    for (uint32_t p = 0; p < tile_pass_count(spp); p++) {
        const struct tile_pass pass = tile_pass_of(p, spp);
        const bool merged = merge_round(a, pass, fill, context);
        a->spp = pass.s_end;
        if (target > 0 && merged && adaptive_judges(a->spp))
            write_down(a);
        if (adaptive_is_due(&a->adaptive, a->spp)) /* also where nothing was lacking */
            return true;
    }
    return false;
}

void adapt_render(const void *stage, struct film_samples *s)
{
    render_tile(stage, s);
}

double adapt_mean_spp(const struct adapt *a)
{
    const size_t pixels = tile_rect_pixels(a->film.window);
    double sum = 0;
    for (size_t i = 0; i < pixels; i++)
        sum += a->film.spp[i];
    return sum / (double)pixels;
}
