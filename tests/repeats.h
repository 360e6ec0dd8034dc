/* repeats.h - a scene rendered many times in this process, each time with other random numbers:
 * what error bars say beside what errors are.
 *
 * The truth that a repeat is held against is the mean of all others, at the most samples that there
 * are: an estimate without bias, and independent of the repeat. Its own noise is known by the
 * numbers of samples (repeats_wider). SPDX-License-Identifier: MIT */
#ifndef TESTS_REPEATS_H
#define TESTS_REPEATS_H

#include "common/estimate.h"
#include "common/evidence.h"
#include "tests/scenes.h"

enum { REPEATS_MOST = 64, REPEATS_MOST_LEVELS = 8, REPEATS_VERDICTS = EVIDENCE_HEAVY + 1 };

struct repeats_look {               /* at one repeat, when it has so many samples */
    float *mean, *error;            /* [pixel][rgb] */
    enum evidence_verdict *verdict; /* [pixel] */
    struct estimate_interval interval;
    double estimate;
};

struct repeats {
    struct arena arena;
    uint32_t count, levels;
    uint32_t spp[REPEATS_MOST_LEVELS]; /* ascending; ends of passes */
    size_t pixels;
    struct repeats_look look[REPEATS_MOST_LEVELS][REPEATS_MOST]; /* [level][repeat] */
    double *total; /* [pixel][rgb]: of the last looks' means */
};

/* Sets count, levels and spp as given in `to`, all else anew. The whole frame. */
void repeats_make(struct repeats *to, const struct stage *);
void repeats_release(struct repeats *);

/* The truth for repeat r: at = 3 pixel + channel. */
double repeats_others(const struct repeats *, uint32_t r, size_t at);
/* What its noise makes of the square of a difference from it, in parts. */
double repeats_wider(const struct repeats *, uint32_t level);
/* Not all repeats say the same to the last bits of their sums. */
bool repeats_is_noisy(const struct repeats *, uint32_t level, size_t at);
/* A repeat's own relMSE. */
double repeats_relmse(const struct repeats *, uint32_t level, uint32_t r);

#define REPEATS_ROUNDING 1e-6 /* of a mean: replicates' sums are floats */

#endif
