/* SPDX-License-Identifier: MIT */
#include "common/image_asset_build.h"

#include <setjmp.h>
#include <stdio.h> /* the library's header needs it */

#include <jpeglib.h>

enum {
    MAX_SCANS = 100
}; /* each may go over the whole image for a few bytes; real files have ten */

/* All state: the library leaves by longjmp, and locals might not survive that. */
struct job {
    struct jpeg_error_mgr errors;
    struct jpeg_progress_mgr progress;
    struct jpeg_decompress_struct jpeg;
    struct image_asset *image;
    struct arena *arena;
    struct err *err;
    jmp_buf leave;
};

static _Noreturn void on_error(j_common_ptr common)
{
    struct job *j = common->client_data;
    char text[JMSG_LENGTH_MAX];
    common->err->format_message(common, text);
    err_set(j->err, ERR_INPUT, "JPEG: %s", text);
    longjmp(j->leave, 1);
}

/* The library warns of what is damaged and makes something up; what, depends on its version. */
static void on_message(j_common_ptr common, int level)
{
    if (level < 0)
        on_error(common);
}

static void on_progress(j_common_ptr common)
{
    struct job *j = common->client_data;
    if (j->jpeg.input_scan_number <= MAX_SCANS)
        return;
    err_set(j->err, ERR_LIMIT, "JPEG: expected at most %d scans", MAX_SCANS);
    longjmp(j->leave, 1);
}

static bool read_head(struct job *j)
{
    jpeg_read_header(&j->jpeg, TRUE);
    if (!image_asset_check_size(j->jpeg.image_width, j->jpeg.image_height, j->err))
        return false;
    const bool gray = j->jpeg.jpeg_color_space == JCS_GRAYSCALE;
    if (!gray && j->jpeg.jpeg_color_space != JCS_RGB && j->jpeg.jpeg_color_space != JCS_YCbCr)
        return err_set(j->err, ERR_INPUT, "JPEG: expected gray, RGB or YCbCr, got %d channels%s",
                       j->jpeg.num_components,
                       j->jpeg.num_components == 4 ? " (CMYK)" : " of unknown meaning");
    j->jpeg.out_color_space = gray ? JCS_GRAYSCALE : JCS_RGB;
    /* The exact integer transform, and nothing that guesses: the same in every version. */
    j->jpeg.dct_method = JDCT_ISLOW;
    j->jpeg.do_fancy_upsampling = TRUE;
    j->jpeg.do_block_smoothing = FALSE;
    return true;
}

static bool run(struct job *j)
{
    if (setjmp(j->leave))
        return false;
    if (!read_head(j))
        return false;
    jpeg_start_decompress(&j->jpeg);
    const uint32_t size_px[2] = {j->jpeg.output_width, j->jpeg.output_height};
    const uint32_t channels = (uint32_t)j->jpeg.output_components;
    unsigned char *pixels = image_asset_make(j->image, IMAGE_DEPTH_U8, size_px, channels, j->arena);
    while (j->jpeg.output_scanline < size_px[1]) {
        JSAMPROW row = pixels + (size_t)j->jpeg.output_scanline * size_px[0] * channels;
        jpeg_read_scanlines(&j->jpeg, &row, 1);
    }
    jpeg_finish_decompress(&j->jpeg);
    return true;
}

static bool create(struct job *j)
{
    if (setjmp(j->leave)) /* a library of another version than its header */
        return false;
    jpeg_create_decompress(&j->jpeg);
    return true;
}

bool image_asset_jpeg(struct image_asset *image, struct image_asset_bytes file, struct arena *arena,
                      struct err *err)
{
    struct job j = {.image = image, .arena = arena, .err = err};
    j.jpeg.err = jpeg_std_error(&j.errors);
    j.jpeg.client_data = &j;
    j.errors.error_exit = on_error;
    j.errors.emit_message = on_message;
    if (!create(&j))
        return false;
    j.progress.progress_monitor = on_progress;
    j.jpeg.progress = &j.progress;
    jpeg_mem_src(&j.jpeg, file.data, file.size);
    const bool good = run(&j);
    jpeg_destroy_decompress(&j.jpeg);
    return good;
}
