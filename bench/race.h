/* race.h - kernels side by side on one scene: rays per CPU second, and CPU seconds of building.
 *
 * The machine may be shared and its speed drifts, so nothing is compared across time: a round gives
 * every kernel each slice of the rays in turn, the order moves on by one from slice to slice,
 * ratios are formed inside a round, and the median of the rounds' ratios is what counts. The best
 * rate is quoted beside it for the reader. Time is CPU time of the thread (building: of the
 * process). SPDX-License-Identifier: MIT */
#ifndef BENCH_RACE_H
#define BENCH_RACE_H

#include "bench/embree.h"
#include "bench/shots.h"

/* A further kernel: an enumerator, its name, its case in race.c's run(). */
enum race_kernel {
    RACE_EMBREE,  /* default, single rays */
    RACE_ROBUST,  /* robust, single rays */
    RACE_OURS,    /* single rays */
    RACE_EIGHTS,  /* ours, eight at a time */
    RACE_PACKETS, /* from here on for information: fewer rounds */
    RACE_STREAM,
    RACE_KERNELS
};

enum { RACE_MOST_ROUNDS = 99 };

struct race {
    const struct stage *stage;
    const struct scene *scene;
    uint32_t rounds, info_rounds;        /* of rays: of the first four kernels, of the others */
    uint32_t builds;                     /* of each tree, at least 1 */
    bool sah;                            /* whether Embree's is to be found out: another build */
    struct embree *embree[EMBREE_KINDS]; /* NULL without Embree */
};

struct race_trees {
    double seconds[3];    /* of building, best: RACE_EMBREE, ROBUST, OURS */
    double ratio[2];      /* seconds of EMBREE, ROBUST / ours, median; NaN without Embree */
    double bytes[3];      /* per triangle */
    double sah, sah_ours; /* of Embree's default tree and of ours; NaN: unknown */
};

struct race_rays {
    double rate[RACE_KERNELS];      /* rays per CPU us, best; NaN: did not run */
    double ratio[2], eights[2];     /* our rate, singly and by eights / that of RACE_EMBREE, ROBUST,
                                       median of rounds */
    double other_hit[RACE_KERNELS]; /* part of the rays: hit here and miss in RACE_EMBREE, or the
                                       reverse */
    double other_t[RACE_KERNELS];   /* part of the rays: both hit, t more than 1e-3 apart */
};

const char *race_name(enum race_kernel);

/* Fills race->embree. */
void race_build(struct race *, struct race_trees *);
void race_run(const struct race *, const struct shots *, struct race_rays *);
void race_release(struct race *);

#endif
