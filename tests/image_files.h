/* image_files.h - image files made by the libraries themselves, for tests that read them back.
 * SPDX-License-Identifier: MIT */
#ifndef TESTS_IMAGE_FILES_H
#define TESTS_IMAGE_FILES_H

#include "common/buf.h"

struct image_files_png {
    uint32_t width_px, height_px;
    int bits;          /* of a channel or palette index: 1, 2, 4, 8, 16 */
    uint32_t channels; /* 1 gray, 2 with alpha, 3 RGB, 4 with alpha; with a palette: 1 */
    bool interlaced;
    const void *rows;                   /* packed as in the file, but 16 bits in host order */
    const unsigned char (*palette)[3];  /* or NULL */
    const unsigned char *palette_alpha; /* or NULL */
    uint32_t palette_count;
    const uint16_t *transparent; /* a gray or an RGB that is; or NULL */
};

void image_files_png(struct buf *, const struct image_files_png *);

struct image_files_jpeg {
    uint32_t width_px, height_px, channels; /* 1 gray, 3 RGB, 4 CMYK */
    bool progressive, subsampled;
    bool by_coefficient;       /* a scan for each of the 63, 190 for RGB */
    const unsigned char *rows; /* [height][width][channels] */
};

void image_files_jpeg(struct buf *, const struct image_files_jpeg *);

enum image_files_packing { /* as OpenEXR numbers them */
                           IMAGE_FILES_NONE,
                           IMAGE_FILES_RLE,
                           IMAGE_FILES_ZIPS,
                           IMAGE_FILES_ZIP,
                           IMAGE_FILES_PIZ,
                           IMAGE_FILES_PXR24,
};

enum image_files_type { IMAGE_FILES_UINT, IMAGE_FILES_HALF, IMAGE_FILES_FLOAT }; /* likewise */

struct image_files_exr {
    uint32_t width_px, height_px;
    const char *const *names; /* of the channels */
    uint32_t channels;
    enum image_files_type type;
    enum image_files_packing packing;
    uint32_t tile_px; /* 0: scan lines */
    int32_t x_begin, y_begin;
    const float *pixels; /* [height][width][channels] */
};

/* False: the library refused. */
bool image_files_exr(struct buf *, const struct image_files_exr *);

#endif
