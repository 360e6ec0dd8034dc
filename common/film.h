/* film.h - the accumulators: tile samples (what one pass of one tile adds) and the
 * film of a frame (what they are merged into).
 *
 * Replicates (docs/accuracy.md): sample i of a pixel belongs to replicate i mod 8, and each
 * replicate has its own scramble, so the eight replicate means are independent
 * estimates of the pixel even though the samples inside one are not. Their spread gives
 * the standard error (estimate.h).
 *
 * Same pixels (P1): a pass sums its samples in sample order in double and rounds each
 * replicate's sum once to float, which is what travels; the film adds passes in pass
 * order. Merging anything else than the next pass is a caller's bug (assert).
 *
 * Beside sums there is evidence of what samples were like, by blocks of pixels (block.h).
 *
 * A film belongs to one thread at a time. Pure: no I/O, no clock.
 * SPDX-License-Identifier: MIT */
#ifndef COMMON_FILM_H
#define COMMON_FILM_H

#include "common/arena.h"
#include "common/block.h"
#include "common/color.h"
#include "common/layers.h"
#include "common/tile.h"

enum {
    FILM_REPLICATES = 8,
    FILM_CHANNELS = 3 * FILM_REPLICATES, /* floats per pixel in tile samples: [replicate][rgb] */
    FILM_MAX_KEYS = 16,
};

/* A sample that came out negative, not finite or above 2^102: it counts as black and can be traced
 * again. */
struct film_key {
    uint32_t x_px, y_px, sample;
};

/* The work that samples have taken, in rays and vertices: a sum over samples, of what each sample
 * asks for by itself. So it does not depend on who traces it, beside which others, in which order
 * or in how many lanes. (Two siblings share a camera ray, common/trace/rng.h: it is the elder's.)
 */
struct film_work {
    uint64_t camera_rays;
    uint64_t bounce_rays; /* other rays of which the nearest hit was asked for */
    uint64_t shadow_rays; /* rays of which any hit was */
    /* From which a path tried to go on: of the kind that lanes know (path8.h), of all others */
    uint64_t plain_vertices, other_vertices;
    uint64_t units; /* of all these, at the scene's prices (common/trace/work.h): one number */
};

void film_work_add(struct film_work *, const struct film_work *more);

struct film_dropped { /* triangles that the scene was prepared without */
    uint32_t degenerate, nonfinite;
};

struct film_samples {
    struct tile_rect rect;
    struct tile_pass pass;
    bool partial;            /* only the blocks of `active` are sampled; of others all is 0 */
    struct block_set active; /* if partial: some of rect's blocks, not all */
    float *sums;     /* [row][column][replicate][rgb], rows of rect from the top; owned by the arena
                      * given to film_samples_make */
    uint32_t layers; /* layers.h; 0: none */
    float *layer_sums;    /* [row][column][layers_channels(layers)]; NULL for none. Finite */
    struct block *blocks; /* [row][column] of blocks of rect; of the same arena. NULL: of a message
                           * of an older version */
    struct film_dropped dropped;
    struct film_work work;
    uint64_t invalid_count;              /* all of them */
    uint32_t key_count;                  /* min(invalid_count, FILM_MAX_KEYS) */
    struct film_key keys[FILM_MAX_KEYS]; /* the first ones in (y, x, sample) order */
};

struct film_samples film_samples_make(struct tile_rect, struct tile_pass, struct arena *);
void film_samples_add_layers(struct film_samples *, uint32_t layers, struct arena *);
/* Only these blocks are to be sampled; at least one. rect is a tile's. */
void film_samples_restrict(struct film_samples *, const struct block_set *);
void film_samples_note_invalid(struct film_samples *, struct film_key);

static inline bool film_samples_has(const struct film_samples *s, size_t block)
{
    return !s->partial || block_set_has(&s->active, block);
}

/* The next pixels [*x_begin, *x_end) of row y_px, from *x_begin on, that are sampled; false: none.
 * Before the first call *x_begin is rect's; afterwards it goes on from *x_end. */
bool film_samples_run(const struct film_samples *, uint32_t y_px, uint32_t *x_begin,
                      uint32_t *x_end);
uint32_t film_samples_pixels(const struct film_samples *);         /* that are sampled */
struct block_set film_samples_active(const struct film_samples *); /* of a tile: also if all are */

struct film {
    struct tile_rect window; /* pixels of the whole frame */
    double *sum;             /* [row][column][rgb]: all samples */
    float *replicate;        /* [row][column][replicate][rgb] */
    uint32_t *spp;           /* [row][column]: samples merged, always the indices [0, spp) */
    uint32_t layers;         /* layers.h; 0: none */
    double *layer;        /* [row][column][layers_channels(layers)]: all samples; NULL for none */
    struct block *blocks; /* [row][column] of blocks of the window */
    float *variance; /* [block][BLOCK_DOUBLINGS]: of a sample, when 8, 16, 32 ... of each pixel were
                      * merged, the latest last; 0 before */
    struct film_dropped dropped;
    struct film_work work;
    uint64_t invalid_count;
    uint32_t key_count;
    struct film_key keys[FILM_MAX_KEYS]; /* the first ones in (y, x, sample) order */
};

void film_init(struct film *, struct tile_rect window); /* heap; all zero */
void film_add_layers(struct film *, uint32_t layers);   /* the same; once, before any sample */
void film_copy(struct film *, const struct film *from); /* inits it */
void film_release(struct film *);
size_t film_bytes(const struct film *); /* memory of its arrays, by window and layers */

/* Adds the samples, which have the film's layers and blocks of their own. samples->rect begins
 * where a block does, and ends where one does or the window. Every pixel that was sampled holds [0,
 * samples->pass.s_begin) so far. */
void film_merge(struct film *, const struct film_samples *);

/* How many samples of [0, spp) belong to replicate r. */
static inline uint32_t film_replicate_spp(uint32_t spp, uint32_t r)
{
    return (spp + FILM_REPLICATES - 1 - r) / FILM_REPLICATES;
}

/* Samples of each pixel of block i of the window. */
static inline uint32_t film_block_spp(const struct film *f, size_t i)
{
    const struct tile_rect w = f->window, r = block_rect_of(w, i);
    const size_t width = w.x_end - w.x_begin;
    return f->spp[(r.y_begin - w.y_begin) * width + (r.x_begin - w.x_begin)];
}

/* rgb_luminance of what is summed in double. */
static inline double film_luminance(const double c[3])
{
    return 0.2126 * c[0] + 0.7152 * c[1] + 0.0722 * c[2];
}

/* Mean radiance of a pixel given by its index in the window; black before the first sample. */
static inline void film_mean(const struct film *f, size_t pixel, double mean[3])
{
    const double n = f->spp[pixel] ? f->spp[pixel] : 1;
    for (int c = 0; c < 3; c++)
        mean[c] = f->sum[3 * pixel + (size_t)c] / n;
}

#endif
