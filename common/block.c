/* SPDX-License-Identifier: MIT */
#include "common/block.h"

struct tile_rect block_rect_of(struct tile_rect r, size_t i)
{
    const uint32_t columns = block_columns(r);
    const uint32_t x = r.x_begin + (uint32_t)(i % columns) * BLOCK_PX;
    const uint32_t y = r.y_begin + (uint32_t)(i / columns) * BLOCK_PX;
    return (struct tile_rect){x, y, min_u32(x + BLOCK_PX, r.x_end), min_u32(y + BLOCK_PX, r.y_end)};
}

void block_keep(struct block *b, float x)
{
    uint32_t at = BLOCK_TOP - 1;
    for (; at > 0 && x > b->top[at - 1]; at--)
        b->top[at] = b->top[at - 1];
    b->top[at] = x;
}

void block_merge(struct block *b, const struct block *more)
{
    b->sum += more->sum;
    b->square += more->square;
    b->clamped += more->clamped;
    b->cut += more->cut;
    b->met += more->met;
    for (uint32_t i = 0; i < BLOCK_TOP && more->top[i] > b->top[BLOCK_TOP - 1]; i++)
        block_keep(b, more->top[i]);
}

double block_variance(const struct block *b, double n)
{
    const double mean = b->sum / n, v = b->square / n - mean * mean;
    return v > 0 ? v : 0;
}
