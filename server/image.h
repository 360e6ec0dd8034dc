/* image.h - a resolved image to files that are whole at every moment (disk.h).
 *
 * image_write_exr: one part, scan lines, float32 and uint32 channels under their own names; the
 * facts are attributes and never touch a pixel. image_write_png: R G B at exposure 1 as 8-bit sRGB.
 * Any one thread per path. Errors: ERR_IO.
 * SPDX-License-Identifier: MIT */
#ifndef SERVER_IMAGE_H
#define SERVER_IMAGE_H

#include "common/err.h"
#include "common/image.h"

struct image_facts {
    const char *job, *document, *target; /* target: JSON text */
    const char *plan;                    /* JSON text; NULL or "": there is none */
    const char *digest;                  /* image_digest of the image */
    const char *report;                  /* JSON text, docs/http.md */
    float error;                         /* reached; +infinity: unknown */
    float error_low, error_high;         /* its 95 % interval; 0, +infinity: unknown */
    float unknown, heavy; /* shares of pixels without trusted error bars, evidence.h */
    float cpu_seconds;
    float stopped;  /* share of pixels that have enough for the error target */
    float spp_mean; /* samples of a pixel */
    uint32_t spp;   /* rounds reached: of every pixel that has not stopped */
    uint32_t spp_least, spp_most;
};

enum image_packing { IMAGE_PLAIN, IMAGE_ZIP }; /* plain: cheap, for images that are soon replaced */

bool image_write_exr(const struct image *, const struct image_facts *, enum image_packing,
                     const char *path, struct err *) MUST_CHECK;
bool image_write_png(const struct image *, const char *path, struct err *) MUST_CHECK;

#endif
