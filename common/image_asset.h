/* image_asset.h - an asset's bytes to pixels: PNG, JPEG and OpenEXR.
 *
 *   PNG    1, 2, 4 and 8 bits become u8, 16 become u16; a palette becomes RGB, and a transparent
 *          colour alpha. What the file says about gamma and colour profiles is passed over.
 *   JPEG   gray or RGB (YCbCr), u8; baseline and progressive. CMYK is refused. The orientation that
 *          a camera notes is passed over.
 *   EXR    the channels R, G, B, or Y, and A if there is one, half or float; others are passed
 *          over. The data window is the image. Of a file with several parts the first.
 *
 * Bytes are hostile: the size is held against SCENE_MAX_IMAGE_* before memory is taken, a damaged
 * or shortened file is refused rather than guessed at, and so is a value that is not finite, with
 * its place. Errors: ERR_INPUT, ERR_LIMIT. Any thread.
 * The same bytes give the same pixels, whatever the machine.
 * SPDX-License-Identifier: MIT */
#ifndef COMMON_IMAGE_ASSET_H
#define COMMON_IMAGE_ASSET_H

#include "common/scene.h"

/* Fills the second half of `image` (whose format is set) with memory of the arena. */
bool image_asset_read(struct image_asset *image, const void *data, size_t bytes,
                      struct arena *arena, struct err *) MUST_CHECK;

/* By the file name's ending, .png, .jpg, .jpeg or .exr in any case; false for others. */
bool image_asset_format_of(const char *file, enum image_format *);

/* "png", "jpeg", "exr": as documents name them. */
enum { IMAGE_ASSET_FORMATS = 3 };
extern const char *const image_asset_formats[IMAGE_ASSET_FORMATS]; /* by enum image_format */

#endif
