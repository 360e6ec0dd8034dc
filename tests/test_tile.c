/* tile.c: every pixel and sample index is covered once; passes have fixed places.
 * SPDX-License-Identifier: MIT */
#include "common/tile.h"

#include <stdlib.h>

#include "tests/tap.h"

static void tiles_cover_window_once(struct tile_rect w, uint32_t tile_px)
{
    const struct tile_grid g = tile_grid_make(w, tile_px);
    unsigned char *seen = calloc((size_t)w.x_end * w.y_end, 1);
    bool once = true;
    for (uint32_t t = 0; t < tile_count(&g); t++) {
        const struct tile_rect r = tile_rect_of(&g, t);
        once &= r.x_begin < r.x_end && r.y_begin < r.y_end && r.x_end <= w.x_end &&
                r.y_end <= w.y_end && r.x_begin >= w.x_begin && r.y_begin >= w.y_begin;
        for (uint32_t y = r.y_begin; y < r.y_end; y++)
            for (uint32_t x = r.x_begin; x < r.x_end; x++)
                once &= seen[(size_t)y * w.x_end + x]++ == 0;
    }
    size_t covered = 0;
    for (size_t i = 0; i < (size_t)w.x_end * w.y_end; i++)
        covered += seen[i];
    free(seen);
    ok(once && covered == tile_rect_pixels(w), "tiles of %u px cover [%u,%u)x[%u,%u) once", tile_px,
       w.x_begin, w.x_end, w.y_begin, w.y_end);
}

static void passes_cover_samples_once(uint32_t spp)
{
    uint32_t next = 0;
    bool in_order = true;
    for (uint32_t p = 0; p < tile_pass_count(spp); p++) {
        const struct tile_pass r = tile_pass_of(p, spp);
        in_order &= r.s_begin == next && r.s_begin < r.s_end;
        next = r.s_end;
    }
    ok(in_order && next == spp, "passes of %u spp cover [0, %u) in order", spp, spp);
}

int main(void)
{
    ok(tile_px_is_sane(8) && tile_px_is_sane(24) && tile_px_is_sane(256) && !tile_px_is_sane(0) &&
           !tile_px_is_sane(33) && !tile_px_is_sane(264) && !tile_px_is_sane(4),
       "sides are multiples of 8, from 8 to 256");
    tiles_cover_window_once((struct tile_rect){0, 0, 1, 1}, 64);
    tiles_cover_window_once((struct tile_rect){0, 0, 100, 70}, 16);
    tiles_cover_window_once((struct tile_rect){13, 7, 200, 129}, 64);
    tiles_cover_window_once((struct tile_rect){0, 0, 256, 256}, 256);

    static const uint32_t some[] = {1,   7,   8,   9,   16,  31,   32,   64,     255,
                                    256, 257, 511, 512, 513, 1000, 4096, 1 << 24};
    for (size_t i = 0; i < countof(some); i++)
        passes_cover_samples_once(some[i]);

    bool fixed = true;
    for (uint32_t p = 0; p + 1 < tile_pass_count(3000); p++) {
        const struct tile_pass a = tile_pass_of(p, 3000), b = tile_pass_of(p, 1 << 24);
        fixed &= a.s_begin == b.s_begin && a.s_end == b.s_end;
    }
    ok(fixed, "passes lie at the same places whatever the job's spp");
    return tap_done();
}
