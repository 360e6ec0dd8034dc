/* SPDX-License-Identifier: MIT */
#include "tests/image_files.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <jpeglib.h>
#include <openexr.h>
#include <png.h>

#include "common/arena.h"

/* --- PNG --- */

static void png_out(png_structp png, png_bytep data, size_t bytes)
{
    buf_append(png_get_io_ptr(png), data, bytes);
}

static void png_nothing(png_structp png)
{
    (void)png;
}

static void png_extras(png_structp png, png_infop info, const struct image_files_png *p)
{
    png_color palette[256];
    for (uint32_t i = 0; i < p->palette_count; i++)
        palette[i] = (png_color){p->palette[i][0], p->palette[i][1], p->palette[i][2]};
    if (p->palette)
        png_set_PLTE(png, info, palette, (int)p->palette_count);
    if (p->palette_alpha)
        png_set_tRNS(png, info, p->palette_alpha, (int)p->palette_count, NULL);
    if (p->transparent) {
        png_color_16 key = {.gray = p->transparent[0]};
        if (p->channels == 3) {
            key.red = p->transparent[0];
            key.green = p->transparent[1];
            key.blue = p->transparent[2];
        }
        png_set_tRNS(png, info, NULL, 0, &key);
    }
}

void image_files_png(struct buf *out, const struct image_files_png *p)
{
    static const int types[] = {0, PNG_COLOR_TYPE_GRAY, PNG_COLOR_TYPE_GRAY_ALPHA,
                                PNG_COLOR_TYPE_RGB, PNG_COLOR_TYPE_RGB_ALPHA};
    png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, NULL, NULL, NULL);
    png_infop info = png_create_info_struct(png);
    png_set_write_fn(png, out, png_out, png_nothing);
    png_set_user_limits(png, PNG_UINT_31_MAX, PNG_UINT_31_MAX);
    png_set_IHDR(png, info, p->width_px, p->height_px, p->bits,
                 p->palette ? PNG_COLOR_TYPE_PALETTE : types[p->channels],
                 p->interlaced ? PNG_INTERLACE_ADAM7 : PNG_INTERLACE_NONE,
                 PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
    png_extras(png, info, p);
    png_write_info(png, info);
    if (p->bits == 16)
        png_set_swap(png);
    const size_t row_bytes = ((size_t)p->width_px * p->channels * (size_t)p->bits + 7) / 8;
    const int passes = png_set_interlace_handling(png);
    for (int pass = 0; pass < passes; pass++)
        for (uint32_t y = 0; y < p->height_px; y++)
            png_write_row(png, (png_const_bytep)p->rows + y * row_bytes);
    png_write_end(png, info);
    png_destroy_write_struct(&png, &info);
}

/* --- JPEG --- */

enum { MOST_SCANS = 1 + 3 * 63 };

static void scans_by_coefficient(struct jpeg_compress_struct *jpeg, jpeg_scan_info *scans)
{
    const int components = jpeg->num_components;
    int count = 0;
    scans[count++] = (jpeg_scan_info){components, {0, 1, 2}, 0, 0, 0, 0};
    for (int component = 0; component < components; component++)
        for (int k = 1; k < 64; k++)
            scans[count++] = (jpeg_scan_info){1, {component}, k, k, 0, 0};
    jpeg->scan_info = scans;
    jpeg->num_scans = count;
}

void image_files_jpeg(struct buf *out, const struct image_files_jpeg *p)
{
    static const J_COLOR_SPACE spaces[] = {0, JCS_GRAYSCALE, 0, JCS_RGB, JCS_CMYK};
    struct jpeg_error_mgr errors;
    struct jpeg_compress_struct jpeg = {.err = jpeg_std_error(&errors)};
    unsigned char *bytes = NULL;
    unsigned long size = 0;
    jpeg_create_compress(&jpeg);
    jpeg_mem_dest(&jpeg, &bytes, &size);
    jpeg.image_width = p->width_px;
    jpeg.image_height = p->height_px;
    jpeg.input_components = (int)p->channels;
    jpeg.in_color_space = spaces[p->channels];
    jpeg_set_defaults(&jpeg);
    jpeg_set_quality(&jpeg, 100, TRUE);
    if (!p->subsampled)
        jpeg.comp_info[0].h_samp_factor = jpeg.comp_info[0].v_samp_factor = 1;
    if (p->progressive)
        jpeg_simple_progression(&jpeg);
    jpeg_scan_info scans[MOST_SCANS];
    if (p->by_coefficient)
        scans_by_coefficient(&jpeg, scans);
    jpeg_start_compress(&jpeg, TRUE);
    const size_t row_bytes = (size_t)p->width_px * p->channels;
    JSAMPLE *row = arena_malloc(row_bytes, 1);
    while (jpeg.next_scanline < p->height_px) {
        memcpy(row, p->rows + jpeg.next_scanline * row_bytes, row_bytes);
        jpeg_write_scanlines(&jpeg, &row, 1);
    }
    free(row);
    jpeg_finish_compress(&jpeg);
    buf_append(out, bytes, size);
    jpeg_destroy_compress(&jpeg);
    free(bytes);
}

/* --- EXR --- */

static int64_t exr_out(exr_const_context_t file, void *user, const void *data, uint64_t bytes,
                       uint64_t offset, exr_stream_error_func_ptr_t report)
{
    (void)file;
    (void)report;
    struct buf *out = user;
    if (offset + bytes > out->size)
        (void)buf_grow(out, offset + bytes - out->size);
    memcpy(out->data + offset, data, bytes);
    return (int64_t)bytes;
}

static void exr_nothing(exr_const_context_t file, exr_result_t code, const char *text)
{
    (void)file;
    (void)code;
    (void)text;
}

static exr_result_t exr_head(exr_context_t f, const struct image_files_exr *p)
{
    const exr_attr_box2i_t window = {.min = {.x = p->x_begin, .y = p->y_begin},
                                     .max = {.x = p->x_begin + (int32_t)p->width_px - 1,
                                             .y = p->y_begin + (int32_t)p->height_px - 1}};
    const exr_attr_v2f_t center = {.x = 0};
    int part;
    exr_result_t r =
        exr_add_part(f, "image", p->tile_px ? EXR_STORAGE_TILED : EXR_STORAGE_SCANLINE, &part);
    if (!r)
        r = exr_initialize_required_attr(f, 0, &window, &window, 1, &center, 1,
                                         EXR_LINEORDER_INCREASING_Y, (exr_compression_t)p->packing);
    if (!r && p->tile_px)
        r = exr_set_tile_descriptor(f, 0, p->tile_px, p->tile_px, EXR_TILE_ONE_LEVEL,
                                    EXR_TILE_ROUND_DOWN);
    for (uint32_t c = 0; !r && c < p->channels; c++)
        r = exr_add_channel(f, 0, p->names[c], (exr_pixel_type_t)p->type, EXR_PERCEPTUALLY_LINEAR,
                            1, 1);
    return r ? r : exr_write_header(f);
}

/* The library compresses only what needs it: incompressible chunks are as long as the raw ones. */
static exr_result_t exr_chunk(exr_context_t f, const struct image_files_exr *p,
                              const exr_chunk_info_t *chunk, exr_encode_pipeline_t *e, uint32_t x,
                              uint32_t y)
{
    exr_result_t r = exr_encoding_initialize(f, 0, chunk, e);
    for (int c = 0; !r && c < e->channel_count; c++) {
        exr_coding_channel_info_t *info = &e->channels[c];
        uint32_t from = 0;
        while (strcmp(p->names[from], info->channel_name))
            from++;
        info->user_data_type = p->type == IMAGE_FILES_UINT ? EXR_PIXEL_UINT : EXR_PIXEL_FLOAT;
        info->user_bytes_per_element = 4;
        info->user_pixel_stride = (int32_t)(4 * p->channels);
        info->user_line_stride = (int32_t)(4 * p->channels * p->width_px);
        info->encode_from_ptr =
            (const uint8_t *)(p->pixels + ((size_t)y * p->width_px + x) * p->channels + from);
    }
    if (!r)
        r = exr_encoding_choose_default_routines(f, 0, e);
    if (!r)
        r = exr_encoding_run(f, 0, e);
    exr_encoding_destroy(f, e);
    return r;
}

static exr_result_t exr_pixels(exr_context_t f, const struct image_files_exr *p)
{
    int32_t step_x = (int32_t)p->width_px, step_y = 0;
    exr_result_t r = p->tile_px ? exr_get_tile_sizes(f, 0, 0, 0, &step_x, &step_y)
                                : exr_get_scanlines_per_chunk(f, 0, &step_y);
    for (uint32_t y = 0; !r && y < p->height_px; y += (uint32_t)step_y)
        for (uint32_t x = 0; !r && x < p->width_px; x += (uint32_t)step_x) {
            exr_chunk_info_t chunk;
            exr_encode_pipeline_t e = EXR_ENCODE_PIPELINE_INITIALIZER;
            r = p->tile_px ? exr_write_tile_chunk_info(f, 0, (int)x / step_x, (int)y / step_y, 0, 0,
                                                       &chunk)
                           : exr_write_scanline_chunk_info(f, 0, p->y_begin + (int)y, &chunk);
            if (!r)
                r = exr_chunk(f, p, &chunk, &e, x, y);
        }
    return r;
}

bool image_files_exr(struct buf *out, const struct image_files_exr *p)
{
    exr_context_t f;
    exr_context_initializer_t init = EXR_DEFAULT_CONTEXT_INITIALIZER;
    init.error_handler_fn = exr_nothing;
    init.user_data = out;
    init.write_fn = exr_out;
    exr_result_t r = exr_start_write(&f, "memory", EXR_WRITE_FILE_DIRECTLY, &init);
    if (r)
        return false;
    r = exr_head(f, p);
    if (!r)
        r = exr_pixels(f, p);
    const exr_result_t end = exr_finish(&f);
    return !r && !end;
}
