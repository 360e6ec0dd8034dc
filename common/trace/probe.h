/* probe.h - what light do paths miss by ending at settings.max_bounces?
 *
 * One sample in BLOCK_PROBE_RATE (block.h) is traced once more, with the same numbers, and may
 * scatter PROBE_BOUNCES times more: its path is the same up to where it was cut, so what it brings
 * more is what the cut has taken from this sample, and the mean over samples so chosen is an
 * unbiased estimate of what it takes from the image, whatever the scene is like. (To follow the
 * trend of the last bounces costs nothing, but light that has come through glass or between mirrors
 * has no trend.) Light that is scattered oftener still is missing in that, too.
 *
 * Which samples is a function of the pixel's place and the sample's index: of the 512 samples of 8
 * x 8 pixels that have one index in their replicates, one. SPDX-License-Identifier: MIT */
#ifndef COMMON_TRACE_PROBE_H
#define COMMON_TRACE_PROBE_H

#include "common/film.h"
#include "common/trace/stage.h"

enum { PROBE_BOUNCES = 256 };

struct probe { /* a sample */
    uint32_t x_px, y_px, replicate;
};

/* Of the samples of this index in the 8 x 8 pixels from (x_px, y_px) on. */
struct probe probe_choose(const struct stage *, uint32_t x_px, uint32_t y_px, uint32_t index);

#endif
