/* chart_runs.h - many small renders in this process, shared out among threads.
 *
 * A run is one thread's from beginning to end, so its CPU seconds are its own; what it finds
 * depends on its stage, seed and samples alone. SPDX-License-Identifier: MIT */
#ifndef CLIENT_CHART_RUNS_H
#define CLIENT_CHART_RUNS_H

#include "common/film.h"
#include "common/trace/stage.h"

struct chart_run {
    const struct stage *stage; /* borrowed; traced with this seed and this many samples per pixel */
    uint64_t seed;
    uint32_t spp;
    double *image; /* [pixel of the crop][rgb]: the caller's, filled with the means */
    /* Filled: */
    struct film_work work;
    double unknown,
        heavy;      /* shares of its pixels: few effective samples, heavy tails; evidence.h */
    double seconds; /* CPU */
};

struct chart_crew {
    uint32_t threads;
    bool quiet;                   /* else a line on stderr tells how far it is */
    uint32_t runs_all, runs_done; /* of everything that is to come, for that line */
};

void chart_runs_do(struct chart_crew *, struct chart_run runs[], uint32_t count);

/* Pixels of a run's image. */
size_t chart_runs_pixels(const struct stage *);

/* A seed for the n-th run of something: all differ, as far as it matters. [0, 2^53 - 1] */
uint64_t chart_runs_seed(uint64_t base, uint32_t of, uint32_t n);

#endif
