/* render.h - tile x pass -> tile samples: the core's single entry point.
 *
 * A sample is a pure function of (document's seed, pixel, sample index): no state is kept
 * between samples, so rows, tiles and passes may be rendered by anyone in any order.
 * Re-entrant; the stage is only read. No I/O, clock, lock or allocation.
 * SPDX-License-Identifier: MIT */
#ifndef COMMON_TRACE_RENDER_H
#define COMMON_TRACE_RENDER_H

#include "common/film.h"
#include "common/trace/stage.h"

/* One row of a tile's pass, y_px in [rect.y_begin, rect.y_end). A caller that may have to stop
 * looks at its own flag between rows. Rows must be rendered in ascending order for the keys of
 * invalid samples to be the first ones. */
void render_row(const struct stage *, struct film_samples *, uint32_t y_px);

/* All rows. */
void render_tile(const struct stage *, struct film_samples *);

/* One sample's radiance, not yet judged finite: what render_row adds up, after the filter's sign. */
rgb render_sample(const struct stage *, uint32_t x_px, uint32_t y_px, uint32_t sample);

#endif
