/* image.h - a resolved image: named channels of 32-bit pixels, and its digest.
 *
 * The one meeting point of film and files: the coordinator makes an image from the film
 * and writes it (server/image_exr.c); the CLI reads one back (client/exr_read.c); both
 * speak of the same digest.
 * SPDX-License-Identifier: MIT */
#ifndef COMMON_IMAGE_H
#define COMMON_IMAGE_H

#include "common/film.h"
#include "common/hash.h"

enum image_type { IMAGE_UINT32 = 0, IMAGE_FLOAT32 = 2 }; /* the numbers OpenEXR gives them */

struct image_channel {
    const char *name; /* "R", "error.R", "samples" */
    enum image_type type;
    void *pixels; /* [row][column] of 4 bytes, host order; in the image's arena */
};

struct image {
    struct tile_rect window;        /* data window: pixels that exist, in the whole frame */
    uint32_t width_px, height_px;   /* display window: the whole frame, from (0, 0) */
    struct image_channel *channels; /* sorted by name (strcmp) */
    size_t channel_count;
};

/* R G B: mean radiance. A: 1. error.R error.G error.B: standard error of the mean (+infinity: not
 * known yet). error.neff, error.verdict: of the pixel's block (evidence.h), the effective number of
 * its samples, and whether the standard error may be trusted: u32, 0 it may, 1 unknown, 2 a heavy
 * tail. samples: samples per pixel. And of the film's layers (layers.h):
 *
 *     albedo.R .G .B      mean over all samples
 *     normal.X .Y .Z      mean over all samples: shorter than 1 where surfaces meet
 *     Z                   depth: mean over the samples that met something; +infinity when none did
 *     position.X .Y .Z    the same mean; +infinity when none did
 *     material            u32, 1 + the index of sample 0's material in the document; 0: nothing met
 *     bounceK.R .G .B     light scattered K times, mean over all samples; rest.R .G .B: more often
 *
 * Memory of the arena. */
struct image image_from_film(const struct film *, uint32_t width_px, uint32_t height_px,
                             struct arena *);

const struct image_channel *image_find(const struct image *, const char *name); /* or NULL */

/* SHA-256 over, all little-endian: for each channel its name with NUL and its type (u32); window's
 * width and height (u32 each); then for each channel its pixels, rows from the top. Attributes and
 * compression do not take part, nor do error.neff and error.verdict: they are opinions of the same
 * samples, and may become better ones. */
void image_digest(const struct image *, char hex[HASH_HEX]);

#endif
