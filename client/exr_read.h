/* exr_read.h - an EXR file to an image.
 *
 * Scan lines or tiles (of a pyramid the finest level), any compression the library reads. Half
 * becomes float. Of a file with several parts the first is read. Deep and subsampled images are
 * refused, and so is anything beyond EXR_READ_MAX_VALUES before memory is allocated.
 * Errors: ERR_NOT_FOUND, ERR_INPUT (not such a file, or damaged), ERR_LIMIT.
 * SPDX-License-Identifier: MIT */
#ifndef CLIENT_EXR_READ_H
#define CLIENT_EXR_READ_H

#include "common/err.h"
#include "common/image.h"

#define EXR_READ_MAX_VALUES ((uint64_t)1 << 30) /* pixels x channels; 4 bytes each */

/* Memory of the arena. A data window with negative coordinates is moved to begin at 0. */
bool exr_read(struct image *, const char *path, struct arena *, struct err *) MUST_CHECK;

#endif
