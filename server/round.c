/* SPDX-License-Identifier: MIT */
#include "server/round.h"

/* ---- what a pass lacks ---- */

struct block_set round_blocks(const struct job *j, uint32_t tile, uint32_t pass)
{
    return adaptive_blocks(&j->adaptive, &j->film, tile_rect_of(&j->grid, tile),
                           tile_pass_of(pass, j->row.target.spp));
}

bool round_lacks(const struct job *j, uint32_t tile, uint32_t pass)
{
    const struct block_set lacking = round_blocks(j, tile, pass);
    return block_set_count(&lacking) > 0;
}

static uint64_t pixels_of(const struct job *j, uint32_t tile, uint32_t pass)
{
    const struct block_set lacking = round_blocks(j, tile, pass);
    return block_set_pixels(&lacking, tile_rect_of(&j->grid, tile));
}

uint64_t round_pixels(const struct job *j, uint32_t pass)
{
    uint64_t n = 0;
    for (uint32_t t = 0; t < j->tile_count; t++)
        n += pixels_of(j, t, pass);
    return n;
}

uint64_t round_owed(const struct job *j, uint32_t pass)
{
    uint64_t n = 0;
    for (uint32_t t = 0; t < j->tile_count; t++)
        for (uint32_t p = j->tiles[t].merged; p < pass; p++) {
            const struct tile_pass range = tile_pass_of(p, j->row.target.spp);
            n += pixels_of(j, t, p) * (range.s_end - range.s_begin);
        }
    return n;
}

/* Of the tile's block that has the fewest. */
static uint32_t least_spp(const struct job *j, uint32_t tile)
{
    const struct tile_rect r = tile_rect_of(&j->grid, tile), w = j->film.window;
    const size_t width = w.x_end - w.x_begin;
    uint32_t least = UINT32_MAX;
    for (uint32_t y = r.y_begin; y < r.y_end; y += BLOCK_PX)
        for (uint32_t x = r.x_begin; x < r.x_end; x += BLOCK_PX)
            least = min_u32(least, j->film.spp[(y - w.y_begin) * width + (x - w.x_begin)]);
    return least;
}

uint32_t round_passes_of(const struct job *j, uint32_t tile, uint32_t most)
{
    const uint32_t spp = least_spp(j, tile);
    uint32_t pass = spp ? tile_pass_count(spp) : 0;
    while (pass < most && !round_lacks(j, tile, pass))
        pass++;
    return pass;
}

/* ---- rounds come to their end ---- */

bool round_is_open(const struct job *j, uint32_t pass)
{
    return j->row.target.error <= 0 || pass <= j->rounds_judged;
}

void round_count(struct job *j, uint32_t merged)
{
    j->tiles_ahead += merged == j->rounds_done + 1;
    if (j->tiles_ahead < j->tile_count)
        return;
    j->rounds_done++;
    j->row.spp_done = round_spp(j);
    j->tiles_ahead = 0;
    for (uint32_t t = 0; t < j->tile_count; t++)
        j->tiles_ahead += j->tiles[t].merged > j->rounds_done;
}

bool round_is_last(const struct job *j)
{
    return j->open && j->rounds_done >= job_passes(j);
}

uint32_t round_spp(const struct job *j)
{
    return j->rounds_done ? tile_pass_of(j->rounds_done - 1, j->row.target.spp).s_end : 0;
}

static bool is_new(const struct job *j)
{
    return j->open && j->row.target.error > 0 && j->rounds_done > j->rounds_judged;
}

bool round_wants_judge(const struct job *j)
{
    return is_new(j) && adaptive_judges(round_spp(j));
}

bool round_goes_on(const struct job *j)
{
    return is_new(j) && !adaptive_judges(round_spp(j));
}
