/* SPDX-License-Identifier: MIT */
#include "common/trace/probe.h"

#include "common/film.h"
#include "common/trace/rng.h"

struct probe probe_choose(const struct stage *s, uint32_t x_px, uint32_t y_px, uint32_t index)
{
    const uint64_t place = (uint64_t)y_px << 32 | x_px;
    const uint64_t h = rng_mix(rng_mix(rng_mix(s->settings.seed + 1) ^ place) + index);
    _Static_assert(BLOCK_PROBE_RATE == BLOCK_PX * BLOCK_PX * 8,
                   "one of each pixel's eight replicates");
    return (struct probe){x_px + (uint32_t)(h & 7), y_px + (uint32_t)(h >> 3 & 7),
                          (uint32_t)(h >> 6 & 7)};
}
