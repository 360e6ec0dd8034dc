/* exr_file.h - an OpenEXR file: what it holds, and its pixels into the caller's memory.
 *
 * Scan lines or tiles (of a pyramid the finest level), any compression the library reads. Of a file
 * with several parts the first is read; deep images are refused. The bytes are hostile: sizes are
 * in `struct exr_file` before anything is allocated for pixels, so the caller holds them against
 * its limit first. The only user of OpenEXR's reading half.
 * Errors: ERR_NOT_FOUND, ERR_INPUT (not such a file, or damaged).
 * SPDX-License-Identifier: MIT */
#ifndef COMMON_EXR_FILE_H
#define COMMON_EXR_FILE_H

#include "common/err.h"

enum exr_file_type { EXR_FILE_UINT32 = 0, EXR_FILE_HALF = 1, EXR_FILE_FLOAT32 = 2 }; /* OpenEXR's */

struct exr_file_channel {
    const char *name; /* the file's, valid until it is closed */
    enum exr_file_type type;
    bool subsampled; /* cannot be read */
};

struct exr_file_reader; /* opaque */

struct exr_file {
    int32_t x_begin, y_begin;     /* of the data window, whose pixels there are */
    uint32_t width_px, height_px; /* of it; both >= 1 */
    int64_t display_x_end, display_y_end;
    const struct exr_file_channel *channels; /* by name */
    uint32_t channel_count;                  /* >= 1 */
    struct exr_file_reader *reader;
};

struct exr_file_source { /* one of the two */
    const char *path;
    const void *data; /* must outlive the file */
    size_t bytes;
};

bool exr_file_open(struct exr_file *, const struct exr_file_source *, struct err *) MUST_CHECK;
void exr_file_close(struct exr_file *);

/* Where a channel goes. A channel of uint32 comes as such, all others as float. */
struct exr_file_plane {
    const char *name; /* of a channel of the file that is not subsampled */
    void *to;         /* 4 bytes for each pixel: the top left one's */
    size_t step;      /* bytes from one pixel to the next in its row */
    size_t row;       /* bytes from one row to the next; at most INT32_MAX */
};

bool exr_file_read(struct exr_file *, const struct exr_file_plane *, uint32_t count,
                   struct err *) MUST_CHECK;

#endif
