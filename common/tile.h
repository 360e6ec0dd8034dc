/* tile.h - a frame cut into tiles, and its samples into passes.
 *
 * Tiles cover the crop window in rows from the top left; the last of a row or column
 * may be smaller. Passes cut the sample indices [0, spp) of every pixel at fixed
 * places, the same for every tile and job:
 *
 *     0  8  16  32  64  128  256  512  768  1024 ...
 *
 * doubling, so that a first image comes at once and an error estimate exists at
 * each power of two, then a step of 256, so that a lease stays short. A job of n samples
 * ends the list with n. Because the places never move, a job that was stopped at n
 * by the clock has the same sums as a job that asked for n (P1).
 * Pure functions; no allocation.
 * SPDX-License-Identifier: MIT */
#ifndef COMMON_TILE_H
#define COMMON_TILE_H

#include "common/base.h"

struct tile_rect { /* pixels of the whole frame, half-open */
    uint32_t x_begin, y_begin, x_end, y_end;
};

static inline uint32_t tile_rect_pixels(struct tile_rect r)
{
    return (r.x_end - r.x_begin) * (r.y_end - r.y_begin);
}

/* Sides are multiples of TILE_STEP_PX, so that blocks of pixels (block.h) do not depend on them. */
enum { TILE_MIN_PX = 8, TILE_STEP_PX = 8, TILE_MAX_PX = 256, TILE_DEFAULT_PX = 64 };

static inline bool tile_px_is_sane(uint64_t tile_px)
{
    return tile_px >= TILE_MIN_PX && tile_px <= TILE_MAX_PX && tile_px % TILE_STEP_PX == 0;
}

struct tile_grid {
    struct tile_rect window; /* what the tiles cover: the crop window */
    uint32_t tile_px;        /* side of a full tile */
    uint32_t columns, rows;
};

struct tile_grid tile_grid_make(struct tile_rect window, uint32_t tile_px);
uint32_t tile_count(const struct tile_grid *);
struct tile_rect tile_rect_of(const struct tile_grid *, uint32_t tile); /* tile < tile_count */

struct tile_pass { /* sample indices, half-open */
    uint32_t s_begin, s_end;
};

uint32_t tile_pass_count(uint32_t spp); /* passes of a job of spp >= 1 samples per pixel */
struct tile_pass tile_pass_of(uint32_t pass, uint32_t spp); /* pass < tile_pass_count(spp) */

#endif
