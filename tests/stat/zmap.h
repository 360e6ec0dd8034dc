/* zmap.h - is an image right in every pixel? A map of z values, and four questions about it.
 *
 * The standard error of a pixel comes from its replicates (common/film.h), with no floor. t of R -
 * 1 degrees of freedom, more where the truth has an error of its own, is turned into the z of the
 * same probability, so that whatever R is, the z of a right image are standard normal. Right needs
 * all of: hardly any pixel is outside what Sidak's correction allows; their mean is 0 (a bias of
 * the whole image, each pixel of which hides in its noise); their variance is 1 (replicates that
 * are not independent); their distribution is normal.
 *
 * Where few samples make most of the value, the spread of the replicates says nothing yet: if a
 * pixel has less than 32 effective samples, its block of 8 x 8 pixels is judged as one; if that has
 * less, too, it is not judged and is counted.
 *
 * For film_samples and the like, one channel at a time. Nothing is kept.
 * SPDX-License-Identifier: MIT */
#ifndef TESTS_STAT_ZMAP_H
#define TESTS_STAT_ZMAP_H

#include "common/base.h"
#include "tests/stat/means.h"

enum { ZMAP_BLOCK = 8, ZMAP_LEAST_N_EFF = 32 };

struct zmap_image { /* borrowed; rows of pixels */
    uint32_t width, height, replicates;
    const double *mean;        /* [y][x][replicate]: independent means of equally many samples */
    const double *n_eff;       /* [y][x]: (sum of samples)^2 / sum of their squares. NULL: enough */
    const double *truth;       /* [y][x] */
    const double *truth_error; /* [y][x]: its standard errors, well known, less than
                                * the image's. NULL: none */
};

struct zmap {
    size_t judged;   /* pixels and blocks; at least 20, or nothing passes */
    size_t blocks;   /* of these: blocks */
    size_t unjudged; /* blocks */
    size_t exact;    /* pixels and blocks without noise that are the truth: not judged */
    size_t outside;  /* |z| above limit, or no number */
    double limit;    /* by Sidak, at half the level */
    double mean, variance;
    double mean_limit, variance_limit; /* 4 / sqrt(judged); 0.1, or for less than 3200 z four
                                        * standard deviations of a variance */
    double ks_p;
};

struct zmap zmap_make(const struct zmap_image *, double level);

/* A right image fails with a chance of at most about the level: half of it by the distribution,
 * half by the pixels outside (less if they are more than 1000, of which 1 in 1000 may be). */
bool zmap_passes(const struct zmap *, double level);

/* The smallest bias detected, in standard errors of a pixel: of every pixel; and of a single one,
 * if no more than 1000 are judged (else, of more than 1 in 1000). */
double zmap_detects_all(const struct zmap *);
double zmap_detects_one(const struct zmap *, uint32_t replicates, double level);

#endif
