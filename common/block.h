/* block.h - evidence: what is kept of the samples of 8 x 8 pixels besides their sums, so that one
 * can tell whether the image's error bars mean anything (evidence.h).
 *
 * Blocks are aligned to the window of the film. A tile's side is a multiple of BLOCK_PX, so that a
 * block lies in one tile and is the same with tiles of any size: of a rectangle of pixels that
 * begins at a corner of a block, the last row and column of blocks may be cut. All pixels of a
 * block have equally many samples.
 *
 * x is the luminance of a sample as it enters the image, but for the sign and gain of the pixel's
 * filter: never negative. A block's samples are added in the order of (y, x, sample), blocks of
 * passes in the order of passes, in double and without any rounding in between (P1).
 *
 * A block is also the least of a tile that can be rendered without the rest of it: a block_set says
 * which of a tile's.
 *
 * Pure functions; no allocation. SPDX-License-Identifier: MIT */
#ifndef COMMON_BLOCK_H
#define COMMON_BLOCK_H

#include "common/tile.h"

enum {
    BLOCK_PX = TILE_STEP_PX,
    BLOCK_TOP = 16,        /* how many of the largest x are kept */
    BLOCK_DOUBLINGS = 4,   /* how many of the latest variances are */
    BLOCK_PROBE_RATE = 512 /* one sample in so many is followed beyond max_bounces */
};

struct block {
    double sum, square; /* of x, of x^2 */
    double clamped;     /* luminance that settings.clamp has taken from the image */
    double cut; /* luminance that max_bounces has: BLOCK_PROBE_RATE times that of those looked at */
    uint64_t met;         /* samples whose camera ray met a surface */
    float top[BLOCK_TOP]; /* the largest x, falling; 0 where there are no more */
};

static inline uint32_t block_columns(struct tile_rect r)
{
    return (r.x_end - r.x_begin + BLOCK_PX - 1) / BLOCK_PX;
}

static inline uint32_t block_rows(struct tile_rect r)
{
    return (r.y_end - r.y_begin + BLOCK_PX - 1) / BLOCK_PX;
}

static inline size_t block_count(struct tile_rect r)
{
    return (size_t)block_columns(r) * block_rows(r);
}

/* Of block number i of the rectangle, row by row. */
struct tile_rect block_rect_of(struct tile_rect, size_t i);

/* Block i and its neighbours: columns and rows of the rectangle's blocks, half-open. */
struct tile_rect block_around(struct tile_rect, size_t i);

void block_keep(struct block *, float x); /* x > top[BLOCK_TOP - 1] */

static inline void block_add(struct block *b, float x)
{
    const double v = (double)x;
    b->sum += v;
    b->square += v * v;
    if (x > b->top[BLOCK_TOP - 1])
        block_keep(b, x);
}

void block_merge(struct block *, const struct block *more);

/* Of one of n samples. */
double block_variance(const struct block *, double n);

enum {
    BLOCK_SET_MAX = (TILE_MAX_PX / BLOCK_PX) * (TILE_MAX_PX / BLOCK_PX),
    BLOCK_SET_HEX = BLOCK_SET_MAX / 4 + 1, /* with the final 0 */
};

/* Blocks of a rectangle of at most BLOCK_SET_MAX: bit i % 64 of word i / 64 is block i, row by row.
 * Bits beyond the last block are 0. */
struct block_set {
    uint64_t bits[BLOCK_SET_MAX / 64];
};

static inline bool block_set_has(const struct block_set *s, size_t i)
{
    return s->bits[i / 64] >> i % 64 & 1;
}

static inline void block_set_add(struct block_set *s, size_t i)
{
    s->bits[i / 64] |= UINT64_C(1) << i % 64;
}

struct block_set block_set_all(size_t count); /* blocks [0, count) */
size_t block_set_count(const struct block_set *);
uint32_t block_set_pixels(const struct block_set *, struct tile_rect); /* of its blocks */
bool block_set_equal(const struct block_set *, const struct block_set *);
bool block_set_within(const struct block_set *part, const struct block_set *whole);

/* As text: a hex digit for every four of `count` blocks, rounded up, the first of the four in its
 * highest bit. Parsing takes nothing else, and no empty set. */
void block_set_print(const struct block_set *, size_t count, char hex[BLOCK_SET_HEX]);
bool block_set_parse(struct block_set *, size_t count, const char *hex);

#endif
