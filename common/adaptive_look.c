/* SPDX-License-Identifier: MIT */
#include "common/adaptive.h"

#include <assert.h>
#include <float.h>
#include <math.h>

#include "common/estimate.h"
#include "common/evidence.h"

/* Effective samples a pixel: below, a seventh of the pixels and more have seen nothing. */
enum { THIN = 2 };

/* The upper end of a block's interval may be above its error by so much, as a square. Of the blocks
 * that stop 3 % are off by more than 1.2 of the target, at 1.21 4 %, at 1 2 %: for the same work at
 * the same error of the image, but the less, the further below the target it ends. */
static const double slack = 1.1;

/* Of the film, whatever a worker may have sent. */
static float sane(double x)
{
    return x <= (double)FLT_MAX ? (float)x : FLT_MAX;
}

static float effective(const struct film *f, size_t i, struct evidence_block e, uint32_t spp)
{
    if (f->blocks[i].sum > 0)
        return e.verdict == EVIDENCE_HEAVY ? -sane((double)e.neff) : sane((double)e.neff);
    const bool fine = e.verdict == EVIDENCE_TRUSTED || spp >= ADAPTIVE_DARK_SPP;
    return fine ? INFINITY : 0;
}

/* Of luminances of pixels: the mean of their squares. */
static double mean_square(const struct film *f, struct tile_rect part)
{
    const struct tile_rect w = f->window;
    double sum = 0;
    for (uint32_t y = part.y_begin; y < part.y_end; y++)
        for (uint32_t x = part.x_begin; x < part.x_end; x++) {
            double mean[3];
            film_mean(f, (size_t)(y - w.y_begin) * (w.x_end - w.x_begin) + (x - w.x_begin), mean);
            const double l = film_luminance(mean);
            sum += l * l;
        }
    return sum / tile_rect_pixels(part);
}

/* The squared error of a pixel of the block that knows no more than all of them together; 0 where
 * most know enough by themselves. */
static double together(const struct film *f, size_t i, struct evidence_block e, double least)
{
    const struct tile_rect part = block_rect_of(f->window, i);
    const double pixels = tile_rect_pixels(part), spp = film_block_spp(f, i);
    if (!(f->blocks[i].sum > 0) || (double)e.neff >= THIN * pixels)
        return 0;
    const double y = f->blocks[i].sum / (spp * pixels);
    const double variance = f->blocks[i].square / (spp * pixels) - mean_square(f, part);
    return variance > 0 ? variance / spp / (y * y + least * least) : 0;
}

static struct adaptive_block look_at(const struct film *f, size_t i, struct evidence_block e,
                                     const struct adaptive_look *l)
{
    const struct estimate_part part = estimate_part(f, block_rect_of(f->window, i), l->least);
    const double g = max_f64(max_f64(part.error2, part.high / slack), together(f, i, e, l->least));
    return (struct adaptive_block){sane(g), effective(f, i, e, l->spp)};
}

/* Those that have been flagged in each round from the pilot to this one: none of them has stopped,
 * whatever the target. NULL: that is not to be asked yet, all are equal. */
static const bool *held(const struct adaptive *a, uint32_t spp, struct arena *arena)
{
    if (spp <= ADAPTIVE_PILOT_SPP)
        return NULL;
    bool *is_held = arena_new(arena, bool, a->count);
    for (size_t i = 0; i < a->count; i++) {
        is_held[i] = true;
        for (uint32_t r = ADAPTIVE_PILOT_ROUND; is_held[i] && r < a->rounds && a->spp[r] < spp; r++)
            is_held[i] = a->blocks[r * a->count + i].neff < 0;
    }
    return is_held;
}

struct adaptive_look adaptive_look(const struct film *f, uint32_t spp, const struct adaptive *a,
                                   struct arena *arena)
{
    assert(adaptive_judges(spp) && (spp <= ADAPTIVE_PILOT_SPP || a->rounds > ADAPTIVE_PILOT_ROUND));
    struct adaptive_look l = {spp, spp > ADAPTIVE_PILOT_SPP ? a->least : estimate_least(f),
                              arena_new(arena, struct adaptive_block, a->count)};
    const struct evidence e = evidence_among(f, held(a, spp, arena), arena);
    for (size_t i = 0; i < a->count; i++)
        l.blocks[i] = film_block_spp(f, i) == spp ? look_at(f, i, e.blocks[i], &l)
                                                  : (struct adaptive_block){.error2 = -1};
    return l;
}
