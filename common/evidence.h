/* evidence.h - film -> which of its error bars may be believed, block by block (block.h).
 *
 * A standard error from samples (estimate.h) supposes that the samples have shown what they can be.
 * Where a pixel's light comes from few bright samples, bars are too short until these have come;
 * where the variance does not exist, they never mean anything. Four things are looked at.
 *
 * The effective number of samples, n_eff = (sum x)^2 / sum x^2: n equal samples count n, one that
 * is all that came counts 1. Below 32 nothing is known.
 *
 * The bars themselves. What few samples bring, a pixel often has not seen yet, and then its bar is
 * short, just because the rest is even. So a block's pixels are looked at together:
 * - what a pixel's mean has more, or less, than the median of its replicates is what most of them
 *   have not seen: its mean over the block may be half of the block's median bar, and over the
 *   block and its neighbours one and a half of it
 * - the interval of four of a pixel's replicates must hold the mean of the other four nearly as
 *   often as such intervals do: in 88 of 100 trials, for 95, seven ways to halve them in each pixel
 * Where that fails the block is unknown. Of bars that pass 92 % and more hold the truth
 * (docs/accuracy.md). What nobody near has seen it cannot know.
 *
 * The tail's index a, where P(X > x) falls like x^-a; below 2 there is no variance. B. Hill, "A
 * Simple General Approach to Inference About the Tail of a Distribution", Annals of Statistics
 * 3(5), 1975: 1 / a is the mean logarithm of the largest k over the next one. They are the largest
 * samples of a region of 64 blocks or more, each divided by the mean of the others of its block;
 * k is 256 of at least 65 536, in windows of less than 64 blocks 4 a block, and at least 64.
 * Flagged when a is below 2.2 and stays as low for the largest half of them, a quarter, and so on
 * to eight: a power law has the same index everywhere, while the contributions of a lamp that is
 * met by rare chance look like one in the middle of their range, and then end. Blocks with few
 * effective samples, about which nothing is known, stay out of it. Of a flagged region those blocks
 * are flagged that have some of the largest k.
 *
 * Outliers: a variance that has grown by half and more with each of three doublings of the samples;
 * one sample that has brought a tenth of everything while the rest have 32 effective ones.
 *
 * Each is a function of the film alone, by arithmetic that gives the same bits everywhere (no
 * libm), so that the verdicts may decide what is sampled next. Pure; memory of the arena.
 * SPDX-License-Identifier: MIT */
#ifndef COMMON_EVIDENCE_H
#define COMMON_EVIDENCE_H

#include "common/film.h"

enum { EVIDENCE_LEAST = 32 }; /* effective samples */

enum evidence_verdict {
    EVIDENCE_TRUSTED, /* or dark: no camera ray met anything, and nothing came */
    EVIDENCE_UNKNOWN, /* too few effective samples, or bars that do not hold */
    EVIDENCE_HEAVY,   /* a heavy tail: the variance may not exist */
};

struct evidence_block {
    float neff;
    enum evidence_verdict verdict;
};

struct evidence {
    uint32_t columns, rows;        /* of blocks of the film's window */
    struct evidence_block *blocks; /* [row][column] */
    double unknown, heavy;         /* shares of the pixels, of all */
    double few;                    /* the part of unknown with too few effective samples */
};

struct evidence evidence_make(const struct film *, struct arena *);

/* The second of the four: trusted blocks whose bars do not hold become unknown. evidence_make's own
 * step; memory of the arena. */
void evidence_bars_judge(const struct film *, struct evidence *, struct arena *);

/* Hill's estimate of the tail index from the k largest of values[0 .. k], falling and positive;
 * +infinity when they are all the same. */
double evidence_hill(const double *values, size_t k);

#endif
