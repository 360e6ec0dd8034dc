/* adapt.h - a job with an error target in this process: rounds of tiles, each judged, until it is
 * due. What a farm does with adaptive.h, without the farm.
 * SPDX-License-Identifier: MIT */
#ifndef TESTS_ADAPT_H
#define TESTS_ADAPT_H

#include "common/adaptive.h"
#include "common/trace/stage.h"

struct adapt {
    struct film film;
    struct adaptive adaptive;
    uint32_t tile_px;
    uint32_t spp; /* of the last round */
};

/* Fills in the samples of a pass: those of the blocks that are asked for. */
typedef void adapt_fill(const void *context, struct film_samples *);

void adapt_init(struct adapt *, struct tile_rect window, uint32_t tile_px);
void adapt_release(struct adapt *);

/* Rounds, of which each merges what is lacking, until the target is met (true) or spp, the end of a
 * pass. A film that has met a larger target goes on. */
bool adapt_run(struct adapt *, double target, uint32_t spp, adapt_fill *, const void *context);

/* A fill of real samples; the context is a const struct stage *. */
void adapt_render(const void *stage, struct film_samples *);

double adapt_mean_spp(const struct adapt *); /* over pixels */

#endif
