/* SPDX-License-Identifier: MIT */
#include "common/tile.h"

#include <assert.h>

struct tile_grid tile_grid_make(struct tile_rect window, uint32_t tile_px)
{
    assert(tile_px_is_sane(tile_px));
    assert(window.x_begin < window.x_end && window.y_begin < window.y_end);
    return (struct tile_grid){
        .window = window,
        .tile_px = tile_px,
        .columns = (window.x_end - window.x_begin + tile_px - 1) / tile_px,
        .rows = (window.y_end - window.y_begin + tile_px - 1) / tile_px,
    };
}

uint32_t tile_count(const struct tile_grid *g)
{
    return g->columns * g->rows;
}

struct tile_rect tile_rect_of(const struct tile_grid *g, uint32_t tile)
{
    assert(tile < tile_count(g));
    const uint32_t x = g->window.x_begin + tile % g->columns * g->tile_px;
    const uint32_t y = g->window.y_begin + tile / g->columns * g->tile_px;
    return (struct tile_rect){x, y, min_u32(x + g->tile_px, g->window.x_end),
                              min_u32(y + g->tile_px, g->window.y_end)};
}

enum { FIRST_END = 8, STEP = 256, DOUBLINGS = 5 }; /* 8 << DOUBLINGS == STEP */

/* Where pass `pass` begins in a job without end. */
static uint64_t pass_begin(uint32_t pass)
{
    if (pass == 0)
        return 0;
    if (pass <= DOUBLINGS + 1)
        return (uint64_t)FIRST_END << (pass - 1);
    return (uint64_t)STEP * (pass - DOUBLINGS);
}

uint32_t tile_pass_count(uint32_t spp)
{
    assert(spp >= 1);
    if (spp > STEP)
        return DOUBLINGS + (spp + STEP - 1) / STEP;
    uint32_t n = 1;
    while (pass_begin(n) < spp)
        n++;
    return n;
}

struct tile_pass tile_pass_of(uint32_t pass, uint32_t spp)
{
    assert(pass < tile_pass_count(spp));
    const uint64_t end = pass_begin(pass + 1);
    return (struct tile_pass){(uint32_t)pass_begin(pass), end < spp ? (uint32_t)end : spp};
}
