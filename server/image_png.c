/* SPDX-License-Identifier: MIT */
#include "server/image.h"

#include <math.h>
#include <stdlib.h>

#include <png.h>

#include "common/buf.h"
#include "server/disk.h"

/* sRGB transfer function, IEC 61966-2-1; what is brighter than 1 is clipped. */
static unsigned char srgb8(float linear)
{
    if (!(linear > 0))
        return 0;
    if (linear >= 1)
        return 255;
    const double v = linear <= 0.0031308f ? 12.92 * (double)linear
                                           : 1.055 * pow((double)linear, 1 / 2.4) - 0.055;
    return (unsigned char)(v * 255 + 0.5);
}

static unsigned char *pixels_of(const struct image *image)
{
    static const char *const names[] = {"R", "G", "B"};
    const size_t pixels = tile_rect_pixels(image->window);
    unsigned char *out = arena_malloc(pixels, 3);
    for (size_t c = 0; c < 3; c++) {
        const float *plane = image_find(image, names[c])->pixels;
        for (size_t i = 0; i < pixels; i++)
            out[3 * i + c] = srgb8(plane[i]);
    }
    return out;
}

static bool encode(const struct image *image, struct buf *out, struct err *err)
{
    png_image png = {
        .version = PNG_IMAGE_VERSION,
        .width = image->window.x_end - image->window.x_begin,
        .height = image->window.y_end - image->window.y_begin,
        .format = PNG_FORMAT_RGB,
        .flags = PNG_IMAGE_FLAG_FAST,
    };
    unsigned char *pixels = pixels_of(image);
    png_alloc_size_t bytes = PNG_IMAGE_PNG_SIZE_MAX(png);
    const bool ok =
        png_image_write_to_memory(&png, buf_grow(out, bytes), &bytes, 0, pixels, 0, NULL);
    out->size = ok ? bytes : 0;
    free(pixels);
    return ok || err_set(err, ERR_IO, "PNG: %s", png.message);
}

bool image_write_png(const struct image *image, const char *path, struct err *err)
{
    struct buf bytes = {0};
    struct disk_file f;
    bool ok = encode(image, &bytes, err) && disk_create(&f, path, err);
    if (ok) {
        ok = disk_write(&f, bytes.data, bytes.size, err);
        if (!ok)
            disk_abort(&f);
    }
    ok = ok && disk_commit(&f, err);
    buf_release(&bytes);
    return ok;
}
