/* study_shot.h - a shot: the same few pixels, by one method's own samples, and what they say.
 *
 * Blocks of 2 x 2 pixels here and there, so that what errors are relative to is a mean of four;
 * block i is in the same place in all shots of a stage. A shot can be made wider, by more blocks,
 * and deeper, by more samples of each pixel. For studies alone (study.h).
 * SPDX-License-Identifier: MIT */
#ifndef COMMON_TRACE_STUDY_SHOT_H
#define COMMON_TRACE_STUDY_SHOT_H

#include "common/trace/study_parts.h"

enum {
    STUDY_BLOCK = 2,      /* its side */
    STUDY_FIRST_SPP = 16, /* of every shot; a deeper one knows its slope from there on */
    STUDY_BLOCKS = 1024,  /* at most */
};

struct study_pixel {
    double sums[FILM_REPLICATES][3];
    double early[3];  /* squared error of the mean after STUDY_FIRST_SPP samples */
    double square[3]; /* after all */
    double mean[3];
    double scale[3]; /* what squared errors are relative to: study_shot_scale */
};

struct study_shot {
    const struct stage *stage;
    struct study_pixel *pixels;
    uint32_t blocks, count; /* of pixels */
    uint32_t spp;
    struct film_work work;
    struct film_samples samples; /* of the block at hand */
};

/* Empty, with room for so many blocks, in the arena. The stage is borrowed. */
void study_shot_init(struct study_shot *, const struct stage *, uint32_t most_blocks,
                     struct arena *);

/* So many blocks, so many samples of each pixel, no fewer than there are. False: halted. */
bool study_shot_go(struct study_shot *, const struct study *, uint32_t blocks, uint32_t spp);

/* Sets what errors are relative to. */
void study_shot_scale(struct study_shot *);

/* Relative to what `usual` has found, which has as many blocks. Its spp is left at 0. */
struct plan_pilot study_shot_sum(const struct study_shot *, const struct study_shot *usual);

#endif
