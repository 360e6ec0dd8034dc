/* SPDX-License-Identifier: MIT */
#include "common/image_asset.h"

#include <string.h>

#include "common/image_asset_build.h"

void *image_asset_make(struct image_asset *image, enum image_depth depth, const uint32_t size_px[2],
                       uint32_t channels, struct arena *arena)
{
    static const size_t bytes[] = {
        [IMAGE_DEPTH_U8] = 1, [IMAGE_DEPTH_U16] = 2, [IMAGE_DEPTH_FLOAT] = sizeof(float)};
    void *pixels =
        arena_alloc(arena, (size_t)size_px[0] * size_px[1], channels * bytes[depth], bytes[depth]);
    image->depth = depth;
    image->width_px = size_px[0];
    image->height_px = size_px[1];
    image->channels = channels;
    image->pixels = pixels;
    return pixels;
}

bool image_asset_check_size(uint64_t width_px, uint64_t height_px, struct err *err)
{
    if (width_px < 1 || height_px < 1)
        return err_set(err, ERR_INPUT, "expected an image of 1 x 1 pixels or more, got %llu x %llu",
                       (unsigned long long)width_px, (unsigned long long)height_px);
    if (width_px > SCENE_MAX_IMAGE_SIDE_PX || height_px > SCENE_MAX_IMAGE_SIDE_PX ||
        width_px * height_px > SCENE_MAX_IMAGE_PIXELS)
        return err_set(err, ERR_LIMIT,
                       "expected an image of at most %d pixels a side and %d in all, got %llu x "
                       "%llu",
                       SCENE_MAX_IMAGE_SIDE_PX, SCENE_MAX_IMAGE_PIXELS,
                       (unsigned long long)width_px, (unsigned long long)height_px);
    return true;
}

/* A file under the wrong name is the commonest mistake: say what it is. */
static bool check_kind(enum image_format format, struct image_asset_bytes file, struct err *err)
{
    static const struct {
        const char *name, *magic;
        size_t bytes;
    } kinds[] = {
        [IMAGE_FORMAT_PNG] = {"a PNG", "\x89PNG\r\n\x1a\n", 8},
        [IMAGE_FORMAT_JPEG] = {"a JPEG", "\xff\xd8\xff", 3},
        [IMAGE_FORMAT_EXR] = {"an OpenEXR", "\x76\x2f\x31\x01", 4},
        {"a GIF", "GIF8", 4},
        {"a TIFF", "II*\0", 4},
        {"a Radiance HDR", "#?", 2},
        {"a BMP", "BM", 2},
    };
    for (size_t i = 0; i < countof(kinds); i++)
        if (file.size >= kinds[i].bytes && !memcmp(file.data, kinds[i].magic, kinds[i].bytes))
            return i == (size_t)format || err_set(err, ERR_INPUT, "expected %s file, got %s file",
                                                  kinds[format].name, kinds[i].name);
    return err_set(err, ERR_INPUT, "expected %s file, got %zu bytes that are none",
                   kinds[format].name, file.size);
}

bool image_asset_read(struct image_asset *image, const void *data, size_t bytes,
                      struct arena *arena, struct err *err)
{
    const struct image_asset_bytes file = {data, bytes};
    if (!check_kind(image->format, file, err))
        return false;
    switch (image->format) {
    case IMAGE_FORMAT_PNG:
        return image_asset_png(image, file, arena, err);
    case IMAGE_FORMAT_JPEG:
        return image_asset_jpeg(image, file, arena, err);
    case IMAGE_FORMAT_EXR:
        return image_asset_exr(image, file, arena, err);
    }
    __builtin_unreachable();
}
