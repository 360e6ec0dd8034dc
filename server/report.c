/* SPDX-License-Identifier: MIT */
#include "server/report.h"

#include <math.h>

#include "common/estimate.h"
#include "common/evidence.h"

struct store_report report_none(void)
{
    return (struct store_report){.error_low = -1, .error_high = -1, .unknown = -1, .heavy = -1};
}

static double mean_luminance(const struct film *f)
{
    const size_t pixels = tile_rect_pixels(f->window);
    double sum = 0;
    for (size_t i = 0; i < pixels; i++) {
        double c[3];
        film_mean(f, i, c);
        sum += film_luminance(c);
    }
    return sum / (double)pixels;
}

struct store_report report_make(const struct film *f)
{
    struct arena arena = {0};
    const struct evidence e = evidence_make(f, &arena);
    const struct estimate_interval i = estimate_interval(f);
    struct store_report r = report_none();
    const double pixels = tile_rect_pixels(f->window);
    if (isfinite(i.high)) {
        r.error_low = i.low;
        r.error_high = i.high;
    }
    r.unknown = e.unknown;
    r.heavy = e.heavy;
    r.energy = mean_luminance(f);
    r.spp_least = UINT32_MAX;
    for (size_t b = 0; b < block_count(f->window); b++) {
        const uint32_t spp = film_block_spp(f, b);
        const double n = max_u32(spp, 1) * pixels;
        r.spp_least = min_u32(r.spp_least, spp);
        r.spp_most = max_u32(r.spp_most, spp);
        r.spp_mean += spp * (tile_rect_pixels(block_rect_of(f->window, b)) / pixels);
        r.clamped += f->blocks[b].clamped / n;
        r.cut += f->blocks[b].cut / n;
    }
    r.work = f->work;
    r.dropped = f->dropped;
    arena_release(&arena);
    return r;
}
