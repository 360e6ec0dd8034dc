/* evidence.h - film -> which of its error bars may be believed, block by block (block.h).
 *
 * A standard error from samples (estimate.h) supposes that the samples have shown what they can be.
 * Where a pixel's light comes from few bright samples, bars are too short until these have come;
 * where the variance does not exist, they never mean anything. Three things are looked at.
 *
 * The effective number of samples, n_eff = (sum x)^2 / sum x^2: n equal samples count n, one that
 * is all that came counts 1. From 32 on 95 % intervals cover what they should (docs/accuracy.md).
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
    EVIDENCE_UNKNOWN, /* too few effective samples */
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
};

struct evidence evidence_make(const struct film *, struct arena *);

/* The same, with the tails of these blocks alone: [block]. Who asks again with more samples only
 * about what was flagged before does not depend on the others' samples. */
struct evidence evidence_among(const struct film *, const bool *blocks, struct arena *);

/* Of one block (by its number in the window), from what is known of it alone: all but the tail. */
struct evidence_block evidence_block(const struct film *, size_t i);

/* Hill's estimate of the tail index from the k largest of values[0 .. k], falling and positive;
 * +infinity when they are all the same. */
double evidence_hill(const double *values, size_t k);

#endif
