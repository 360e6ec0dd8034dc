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

/* One row of a tile's pass, y_px in [rect.y_begin, rect.y_end), of what is to be sampled of it
 * (film_samples_restrict): it gets the same sums with the rest of the row or without. A caller that
 * may have to stop looks at its own flag between rows. Rows must be rendered in ascending order for
 * the keys of invalid samples to be the first ones. */
void render_row(const struct stage *, struct film_samples *, uint32_t y_px);

/* All rows. */
void render_tile(const struct stage *, struct film_samples *);

/* One sample's radiance, not yet judged finite: what render_row adds up, after the filter's sign.
 */
rgb render_sample(const struct stage *, uint32_t x_px, uint32_t y_px, uint32_t sample);

struct render_place {  /* where a sample's path has arrived */
    uint32_t material; /* STAGE_NONE: it ended before; then only light and traced are set */
    bool shines;
    vec3 p, ng;      /* the point, and the unit normal of the surface's front; world, m */
    rgb throughput;  /* what of light from here goes on to the camera */
    rgb light;       /* found so far; once the path has ended, what render_sample returns */
    uint64_t traced; /* rays of the path after the camera's */
};

/* The sample's path after so many scatterings (0: where the camera ray has arrived), the very one
 * that was rendered. Traced from the start: for people who look at one sample. */
void render_follow(const struct stage *, struct film_key, uint32_t bounces, struct render_place *);

#endif
