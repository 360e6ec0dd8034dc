/* image_asset_build.h - the readers of each format. Private to image_asset*.c.
 * SPDX-License-Identifier: MIT */
#ifndef COMMON_IMAGE_ASSET_BUILD_H
#define COMMON_IMAGE_ASSET_BUILD_H

#include "common/scene.h"

struct image_asset_bytes {
    const unsigned char *data;
    size_t size;
};

/* Takes size, channels and depth, which are checked, and memory for the pixels, which it returns.
 */
void *image_asset_make(struct image_asset *image, enum image_depth, const uint32_t size_px[2],
                       uint32_t channels, struct arena *);

/* The limits of scene.h. */
bool image_asset_check_size(uint64_t width_px, uint64_t height_px, struct err *) MUST_CHECK;

bool image_asset_png(struct image_asset *, struct image_asset_bytes, struct arena *,
                     struct err *) MUST_CHECK;
bool image_asset_jpeg(struct image_asset *, struct image_asset_bytes, struct arena *,
                      struct err *) MUST_CHECK;
bool image_asset_exr(struct image_asset *, struct image_asset_bytes, struct arena *,
                     struct err *) MUST_CHECK;

#endif
