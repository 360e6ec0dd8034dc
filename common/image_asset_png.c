/* SPDX-License-Identifier: MIT */
#include "common/image_asset_build.h"

#include <png.h>
#include <string.h>

/* All state: the library leaves by longjmp, and locals might not survive that. */
struct job {
    struct image_asset *image;
    struct image_asset_bytes left;
    struct arena *arena;
    struct err *err;
    png_structp png;
    png_infop info;
};

enum { CHUNK_MAX_BYTES = 8 << 20 }; /* of a chunk that is not pixels, inflated */

static void on_error(png_structp png, png_const_charp text)
{
    const struct job *j = png_get_error_ptr(png);
    err_set(j->err, ERR_INPUT, "PNG: %s", text);
    png_longjmp(png, 1);
}

static void on_warning(png_structp png, png_const_charp text)
{
    (void)png;
    (void)text; /* of chunks that are passed over anyway */
}

static void on_read(png_structp png, png_bytep to, size_t bytes)
{
    struct job *j = png_get_io_ptr(png);
    if (bytes > j->left.size)
        png_error(png, "the file ends too early");
    memcpy(to, j->left.data, bytes);
    j->left.data += bytes;
    j->left.size -= bytes;
}

/* Gray or RGB, perhaps with alpha, of 8 or 16 bits. */
static void normalize(const struct job *j)
{
    png_set_palette_to_rgb(j->png);
    png_set_expand_gray_1_2_4_to_8(j->png);
    if (png_get_valid(j->png, j->info, PNG_INFO_tRNS))
        png_set_tRNS_to_alpha(j->png);
    if (png_get_bit_depth(j->png, j->info) == 16 && __BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__)
        png_set_swap(j->png);
}

static void read_rows(const struct job *j)
{
    const int passes = png_set_interlace_handling(j->png);
    png_read_update_info(j->png, j->info);
    const uint32_t size_px[2] = {png_get_image_width(j->png, j->info),
                                 png_get_image_height(j->png, j->info)};
    const bool wide = png_get_bit_depth(j->png, j->info) == 16;
    unsigned char *pixels = image_asset_make(j->image, wide ? IMAGE_DEPTH_U16 : IMAGE_DEPTH_U8,
                                             size_px, png_get_channels(j->png, j->info), j->arena);
    const size_t row_bytes = (size_t)size_px[0] * j->image->channels * (wide ? 2 : 1);
    if (png_get_rowbytes(j->png, j->info) != row_bytes)
        png_error(j->png, "the rows have an unknown layout");
    for (int pass = 0; pass < passes; pass++)
        for (uint32_t y = 0; y < size_px[1]; y++)
            png_read_row(j->png, pixels + y * row_bytes, NULL);
    png_read_end(j->png, NULL);
}

static bool run(const struct job *j)
{
    if (setjmp(png_jmpbuf(j->png)))
        return false;
    png_read_info(j->png, j->info);
    if (!image_asset_check_size(png_get_image_width(j->png, j->info),
                                png_get_image_height(j->png, j->info), j->err))
        return false;
    normalize(j);
    read_rows(j);
    return true;
}

bool image_asset_png(struct image_asset *image, struct image_asset_bytes file, struct arena *arena,
                     struct err *err)
{
    struct job j = {.image = image, .left = file, .arena = arena, .err = err};
    j.png = png_create_read_struct(PNG_LIBPNG_VER_STRING, &j, on_error, on_warning);
    if (!j.png)
        return err_set(err, ERR_IO, "PNG: no memory");
    j.info = png_create_info_struct(j.png);
    png_set_read_fn(j.png, &j, on_read);
    png_set_user_limits(j.png, PNG_UINT_31_MAX, PNG_UINT_31_MAX); /* ours come with a text */
    png_set_chunk_malloc_max(j.png, CHUNK_MAX_BYTES);
    const bool good = j.info && run(&j);
    png_destroy_read_struct(&j.png, &j.info, NULL);
    return good;
}
