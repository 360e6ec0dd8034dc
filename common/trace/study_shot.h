/* study_shot.h - a shot: pixels here and there, by one method's own samples, and what they say.
 *
 * Blocks of 2 x 2 pixels, so that what errors are relative to is a mean of four; block i is in the
 * same place in all shots of a stage. A shot can be made wider, by more blocks, and deeper, by more
 * samples of all blocks or of some that are picked. For studies alone (study.h).
 *
 * Noise is often in few pixels, so that what a shot can say hangs on how many of these it has met:
 * it is wide first, by as few samples of a pixel as show an error. How the error falls from there
 * on only needs the blocks that have some. They are picked in proportion to it, so that each brings
 * about as much of the sum (M. Hansen, W. Hurwitz, "On the Theory of Sampling from Finite
 * Populations", Annals of Mathematical Statistics 14(4), 1943), and half as if it were everywhere
 * the same, since some of it has not been seen yet.
 * SPDX-License-Identifier: MIT */
#ifndef COMMON_TRACE_STUDY_SHOT_H
#define COMMON_TRACE_STUDY_SHOT_H

#include "common/trace/study_parts.h"

enum {
    STUDY_BLOCK = 2, /* its side */
    STUDY_BLOCK_PIXELS = STUDY_BLOCK * STUDY_BLOCK,
    STUDY_BLOCKS = 1024, /* at most */
};

enum study_depth { /* samples of a pixel, study_depth_spp */
                   STUDY_FIRST,
                   STUDY_PILOT,
                   STUDY_DEEP,
                   STUDY_DEEPEST,
                   STUDY_DEPTHS,
};

extern const uint32_t study_depth_spp[STUDY_DEPTHS];

struct study_pixel {
    double sums[FILM_REPLICATES][3];
    double square[STUDY_DEPTHS][3]; /* squared error of the mean, at each depth so far */
    double mean[3];                 /* by now */
    double scale[3];                /* what squared errors are relative to: study_shot_scale */
};

struct study_block {
    uint32_t spp;
    double units;  /* of work, that the first samples took */
    double weight; /* it speaks for so many blocks; 0: for none, it was not picked */
    double share;  /* of all noise, as it was when blocks were picked */
};

struct study_shot {
    const struct stage *stage;
    struct study_pixel *pixels;
    struct study_block *list;
    uint32_t blocks, block_pixels;
    enum study_depth depth;      /* that blocks have which speak for others */
    enum study_depth reached;    /* by some */
    bool is_picked;              /* not all do */
    struct film_samples samples; /* of the block at hand; with the work of all */
};

/* Empty, with room for STUDY_BLOCKS, in the arena. The stage is borrowed. */
void study_shot_init(struct study_shot *, const struct stage *, struct arena *);

/* Blocks [0, blocks), as many as before at least, each to that depth. False: halted. */
bool study_shot_go(struct study_shot *, const struct study *, uint32_t blocks, enum study_depth);

/* Looks at where noise is, for what is picked next. Work of one more sample of each pixel of a
 * block that would be, on the average. After study_shot_scale. */
double study_shot_price(struct study_shot *);

/* So many blocks, picked of those that there are as said above, to a depth not above `reached`. */
bool study_shot_deepen(struct study_shot *, const struct study *, uint32_t blocks,
                       enum study_depth);

/* --- study_noise.c --- */

/* Sets what errors are relative to. */
void study_shot_scale(struct study_shot *);

/* A block's squared errors at a depth, relative to what `usual` has found there: the sum over its
 * pixels and channels. */
double study_shot_noise(const struct study_shot *, const struct study_shot *usual, uint32_t block,
                        enum study_depth);

/* Relative to what `usual` has found, which has as many blocks. */
struct plan_pilot study_shot_sum(const struct study_shot *, const struct study_shot *usual);

#endif
