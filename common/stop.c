/* SPDX-License-Identifier: MIT */
#include "common/stop.h"

#include "common/estimate.h"

static uint32_t least_spp(const struct film *f)
{
    uint32_t least = UINT32_MAX;
    for (size_t i = 0; i < tile_rect_pixels(f->window); i++)
        least = min_u32(least, f->spp[i]);
    return least;
}

static struct block all_blocks(const struct film *f)
{
    struct block all = {0};
    for (size_t i = 0; i < block_count(f->window); i++)
        block_merge(&all, &f->blocks[i]);
    return all;
}

bool stop_is_due(const struct film *f, double target)
{
    if (!(estimate_error(f) <= target) || !(estimate_interval(f).high <= STOP_SLACK * target))
        return false;
    const struct block all = all_blocks(f);
    if (!(all.sum > 0))
        return all.met == 0 || least_spp(f) >= STOP_DARK_SPP;
    return all.sum * (all.sum / all.square) >= STOP_LEAST_NEFF;
}
