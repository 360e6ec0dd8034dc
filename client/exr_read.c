/* SPDX-License-Identifier: MIT */
#include "client/exr_read.h"

#include <openexr.h>
#include <stdlib.h>
#include <string.h>

struct reader {
    exr_context_t file;
    exr_attr_box2i_t data;
    int32_t width, height;
    struct image *image;
    exr_decode_pipeline_t decoder;
    bool decoding; /* the decoder has been initialised */
};

static void be_silent(exr_const_context_t file, exr_result_t code, const char *text)
{
    (void)file;
    (void)code;
    (void)text; /* the result code is turned into text where it is returned */
}

static bool exr_fail(struct err *err, const char *doing, exr_result_t code)
{
    return err_set(err, ERR_INPUT, "%s: %s", doing, exr_get_default_error_message(code));
}

static bool check_channels(const exr_attr_chlist_t *list, struct err *err)
{
    for (int c = 0; c < list->num_channels; c++) {
        const exr_attr_chlist_entry_t *e = &list->entries[c];
        if (e->x_sampling != 1 || e->y_sampling != 1)
            return err_set(err, ERR_INPUT, "channel %s is subsampled (%d x %d); expected 1 x 1",
                           e->name.str, e->x_sampling, e->y_sampling);
    }
    return true;
}

static bool read_header(struct reader *r, exr_storage_t *storage,
                        const exr_attr_chlist_t **channels, struct err *err)
{
    exr_attr_box2i_t display;
    exr_result_t rc = exr_get_storage(r->file, 0, storage);
    if (!rc)
        rc = exr_get_data_window(r->file, 0, &r->data);
    if (!rc)
        rc = exr_get_display_window(r->file, 0, &display);
    if (!rc)
        rc = exr_get_channels(r->file, 0, channels);
    if (rc)
        return exr_fail(err, "header", rc);
    if (*storage != EXR_STORAGE_SCANLINE && *storage != EXR_STORAGE_TILED)
        return err_set(err, ERR_INPUT, "deep images are not read");

    const int64_t width = (int64_t)r->data.max.x - r->data.min.x + 1;
    const int64_t height = (int64_t)r->data.max.y - r->data.min.y + 1;
    const int count = (*channels)->num_channels;
    if (width < 1 || height < 1 || count < 1)
        return err_set(err, ERR_INPUT, "no pixels: %lld x %lld with %d channels", (long long)width,
                       (long long)height, count);
    if (width > INT32_MAX / 4 || height > INT32_MAX / 4 ||
        (uint64_t)width * (uint64_t)height > EXR_READ_MAX_VALUES / (uint64_t)count)
        return err_set(
            err, ERR_LIMIT, "%lld x %lld pixels with %d channels are more than %llu values",
            (long long)width, (long long)height, count, (unsigned long long)EXR_READ_MAX_VALUES);
    r->width = (int32_t)width;
    r->height = (int32_t)height;
    const int64_t display_width = (int64_t)display.max.x + 1,
                  display_height = (int64_t)display.max.y + 1;
    r->image->width_px = (uint32_t)max_i64(display_width, 0);
    r->image->height_px = (uint32_t)max_i64(display_height, 0);
    return check_channels(*channels, err);
}

static int by_name(const void *a, const void *b)
{
    return strcmp(((const struct image_channel *)a)->name, ((const struct image_channel *)b)->name);
}

static void make_image(struct reader *r, const exr_attr_chlist_t *list, struct arena *arena)
{
    struct image *image = r->image;
    const uint32_t x = r->data.min.x > 0 ? (uint32_t)r->data.min.x : 0;
    const uint32_t y = r->data.min.y > 0 ? (uint32_t)r->data.min.y : 0;
    image->window = (struct tile_rect){x, y, x + (uint32_t)r->width, y + (uint32_t)r->height};
    image->channel_count = (size_t)list->num_channels;
    image->channels = arena_new(arena, struct image_channel, image->channel_count);
    for (size_t c = 0; c < image->channel_count; c++) {
        const exr_attr_chlist_entry_t *e = &list->entries[c];
        image->channels[c] = (struct image_channel){
            .name = arena_strdup(arena, e->name.str),
            .type = e->pixel_type == EXR_PIXEL_UINT ? IMAGE_UINT32 : IMAGE_FLOAT32,
            .pixels = arena_alloc(arena, (size_t)r->width * (size_t)r->height, 4, 4),
        };
    }
    qsort(image->channels, image->channel_count, sizeof *image->channels, by_name);
}

/* Where the decoder puts the chunk whose top left pixel is (x, y) of the data window. */
static bool aim(struct reader *r, int32_t x, int32_t y)
{
    for (int c = 0; c < r->decoder.channel_count; c++) {
        exr_coding_channel_info_t *info = &r->decoder.channels[c];
        const struct image_channel *to = image_find(r->image, info->channel_name);
        if (!to || y + info->height > r->height || x + info->width > r->width)
            return false;
        info->user_data_type = to->type == IMAGE_UINT32 ? EXR_PIXEL_UINT : EXR_PIXEL_FLOAT;
        info->user_bytes_per_element = 4;
        info->user_pixel_stride = 4;
        info->user_line_stride = r->width * 4;
        info->decode_to_ptr =
            (uint8_t *)to->pixels + 4 * ((size_t)y * (size_t)r->width + (size_t)x);
    }
    return true;
}

static bool read_chunk(struct reader *r, const exr_chunk_info_t *chunk, int32_t x, int32_t y,
                       struct err *err)
{
    const bool first = !r->decoding;
    exr_result_t rc = first ? exr_decoding_initialize(r->file, 0, chunk, &r->decoder)
                            : exr_decoding_update(r->file, 0, chunk, &r->decoder);
    r->decoding |= !rc;
    if (!rc && !aim(r, x, y))
        return err_set(err, ERR_INPUT, "a chunk at (%d, %d) lies outside the image", x, y);
    if (!rc && first)
        rc = exr_decoding_choose_default_routines(r->file, 0, &r->decoder);
    if (!rc)
        rc = exr_decoding_run(r->file, 0, &r->decoder);
    return !rc || exr_fail(err, "pixels", rc);
}

static bool read_lines(struct reader *r, struct err *err)
{
    int32_t step = 0;
    const exr_result_t rc = exr_get_scanlines_per_chunk(r->file, 0, &step);
    if (rc || step < 1)
        return exr_fail(err, "scan lines", rc);
    for (int64_t y = 0; y < r->height; y += step) {
        exr_chunk_info_t chunk;
        const exr_result_t found =
            exr_read_scanline_chunk_info(r->file, 0, (int)(r->data.min.y + y), &chunk);
        if (found)
            return exr_fail(err, "scan lines", found);
        if (!read_chunk(r, &chunk, 0, (int32_t)y, err))
            return false;
    }
    return true;
}

static bool read_tiles(struct reader *r, struct err *err)
{
    int32_t side_x = 0, side_y = 0;
    const exr_result_t rc = exr_get_tile_sizes(r->file, 0, 0, 0, &side_x, &side_y);
    if (rc || side_x < 1 || side_y < 1)
        return exr_fail(err, "tiles", rc);
    for (int64_t y = 0; y < r->height; y += side_y)
        for (int64_t x = 0; x < r->width; x += side_x) {
            exr_chunk_info_t chunk;
            const exr_result_t found = exr_read_tile_chunk_info(r->file, 0, (int)(x / side_x),
                                                                (int)(y / side_y), 0, 0, &chunk);
            if (found)
                return exr_fail(err, "tiles", found);
            if (!read_chunk(r, &chunk, (int32_t)x, (int32_t)y, err))
                return false;
        }
    return true;
}

static bool read_file(struct reader *r, struct arena *arena, struct err *err)
{
    exr_storage_t storage;
    const exr_attr_chlist_t *channels;
    if (!read_header(r, &storage, &channels, err))
        return false;
    make_image(r, channels, arena);
    return storage == EXR_STORAGE_TILED ? read_tiles(r, err) : read_lines(r, err);
}

bool exr_read(struct image *image, const char *path, struct arena *arena, struct err *err)
{
    *image = (struct image){0};
    struct reader r = {.image = image};
    exr_context_initializer_t init = EXR_DEFAULT_CONTEXT_INITIALIZER;
    init.error_handler_fn = be_silent;
    const exr_result_t rc = exr_start_read(&r.file, path, &init);
    if (rc)
        return err_set(err, rc == EXR_ERR_FILE_ACCESS ? ERR_NOT_FOUND : ERR_INPUT, "%s: %s", path,
                       exr_get_default_error_message(rc));
    const bool good = read_file(&r, arena, err) || err_at(err, "%s", path);
    if (r.decoding)
        exr_decoding_destroy(r.file, &r.decoder);
    exr_finish(&r.file);
    return good;
}
