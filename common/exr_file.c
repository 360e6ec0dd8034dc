/* SPDX-License-Identifier: MIT */
#include "common/exr_file.h"

#include <openexr.h>
#include <stdlib.h>
#include <string.h>

#include "common/arena.h"

struct exr_file_reader {
    exr_context_t context;
    struct exr_file_source source;
    exr_storage_t storage;
    struct exr_file_channel *channels;
    const struct exr_file_plane *planes;
    uint32_t plane_count;
    exr_decode_pipeline_t decoder;
    bool decoding; /* the decoder has been initialised */
};

static void be_silent(exr_const_context_t file, exr_result_t code, const char *text)
{
    (void)file;
    (void)code;
    (void)text; /* the result code is turned into text where it is returned */
}

#define ALLOCATION_MAX_BYTES ((size_t)1 << 30) /* tables and buffers of a chunk take far less */

/* Zeroed: a stream that ends early leaves the rest of its chunk unwritten, and what memory held
 * before must not become pixels. */
static void *take(size_t bytes)
{
    return bytes <= ALLOCATION_MAX_BYTES ? calloc(1, bytes ? bytes : 1) : NULL;
}

static void give_back(void *memory)
{
    free(memory);
}

static int64_t source_read(exr_const_context_t file, void *user, void *to, uint64_t bytes,
                           uint64_t offset, exr_stream_error_func_ptr_t report)
{
    (void)file;
    (void)report;
    const struct exr_file_reader *r = user;
    if (offset >= r->source.bytes)
        return 0;
    const size_t n = min_size((size_t)bytes, r->source.bytes - (size_t)offset);
    memcpy(to, (const unsigned char *)r->source.data + offset, n);
    return (int64_t)n;
}

static int64_t source_size(exr_const_context_t file, void *user)
{
    (void)file;
    return (int64_t)((const struct exr_file_reader *)user)->source.bytes;
}

static bool fail(struct err *err, const char *doing, exr_result_t code)
{
    return err_set(err, ERR_INPUT, "%s: %s", doing, exr_get_default_error_message(code));
}

/* --- the head --- */

static void list_channels(struct exr_file *f, const exr_attr_chlist_t *list)
{
    struct exr_file_channel *channels = arena_malloc((size_t)list->num_channels, sizeof *channels);
    for (int c = 0; c < list->num_channels; c++) {
        const exr_attr_chlist_entry_t *e = &list->entries[c];
        channels[c] = (struct exr_file_channel){
            .name = e->name.str,
            .type = (enum exr_file_type)e->pixel_type,
            .subsampled = e->x_sampling != 1 || e->y_sampling != 1,
        };
    }
    f->reader->channels = channels;
    f->channels = channels;
    f->channel_count = (uint32_t)list->num_channels;
}

static bool read_head(struct exr_file *f, struct err *err)
{
    struct exr_file_reader *r = f->reader;
    exr_attr_box2i_t data, display;
    const exr_attr_chlist_t *channels;
    exr_result_t rc = exr_get_storage(r->context, 0, &r->storage);
    if (!rc)
        rc = exr_get_data_window(r->context, 0, &data);
    if (!rc)
        rc = exr_get_display_window(r->context, 0, &display);
    if (!rc)
        rc = exr_get_channels(r->context, 0, &channels);
    if (rc)
        return fail(err, "header", rc);
    if (r->storage != EXR_STORAGE_SCANLINE && r->storage != EXR_STORAGE_TILED)
        return err_set(err, ERR_INPUT, "deep images are not read");
    const int64_t width = (int64_t)data.max.x - data.min.x + 1;
    const int64_t height = (int64_t)data.max.y - data.min.y + 1;
    if (width < 1 || height < 1 || width > INT32_MAX || height > INT32_MAX ||
        channels->num_channels < 1)
        return err_set(err, ERR_INPUT, "no pixels: %lld x %lld with %d channels", (long long)width,
                       (long long)height, channels->num_channels);
    f->x_begin = data.min.x;
    f->y_begin = data.min.y;
    f->width_px = (uint32_t)width;
    f->height_px = (uint32_t)height;
    f->display_x_end = (int64_t)display.max.x + 1;
    f->display_y_end = (int64_t)display.max.y + 1;
    list_channels(f, channels);
    return true;
}

bool exr_file_open(struct exr_file *f, const struct exr_file_source *source, struct err *err)
{
    *f = (struct exr_file){.reader = arena_malloc(1, sizeof *f->reader)};
    f->reader->source = *source;
    exr_context_initializer_t init = EXR_DEFAULT_CONTEXT_INITIALIZER;
    init.error_handler_fn = be_silent;
    init.alloc_fn = take;
    init.free_fn = give_back;
    if (!source->path) {
        init.user_data = f->reader;
        init.read_fn = source_read;
        init.size_fn = source_size;
    }
    const exr_result_t rc =
        exr_start_read(&f->reader->context, source->path ? source->path : "memory", &init);
    if (rc)
        err_set(err, rc == EXR_ERR_FILE_ACCESS ? ERR_NOT_FOUND : ERR_INPUT, "%s",
                exr_get_default_error_message(rc));
    if (!rc && read_head(f, err))
        return true;
    exr_file_close(f);
    return false;
}

void exr_file_close(struct exr_file *f)
{
    struct exr_file_reader *r = f->reader;
    if (r->decoding)
        exr_decoding_destroy(r->context, &r->decoder);
    if (r->context)
        exr_finish(&r->context);
    free(r->channels);
    free(r);
    f->reader = NULL;
}

/* --- pixels --- */

static const struct exr_file_plane *plane_of(const struct exr_file_reader *r, const char *name)
{
    for (uint32_t i = 0; i < r->plane_count; i++)
        if (!strcmp(r->planes[i].name, name))
            return &r->planes[i];
    return NULL;
}

/* Where the decoder puts the chunk whose top left pixel is (x, y) of the data window. */
static bool aim(const struct exr_file *f, int32_t x, int32_t y)
{
    struct exr_file_reader *r = f->reader;
    for (int c = 0; c < r->decoder.channel_count; c++) {
        exr_coding_channel_info_t *info = &r->decoder.channels[c];
        const struct exr_file_plane *plane = plane_of(r, info->channel_name);
        info->decode_to_ptr = NULL; /* passed over */
        if (!plane)
            continue;
        if ((uint64_t)y + (uint64_t)info->height > f->height_px ||
            (uint64_t)x + (uint64_t)info->width > f->width_px)
            return false;
        info->user_data_type = info->data_type == EXR_PIXEL_UINT ? EXR_PIXEL_UINT : EXR_PIXEL_FLOAT;
        info->user_bytes_per_element = 4;
        info->user_pixel_stride = (int32_t)plane->step;
        info->user_line_stride = (int32_t)plane->row;
        info->decode_to_ptr =
            (uint8_t *)plane->to + (size_t)y * plane->row + (size_t)x * plane->step;
    }
    return true;
}

static bool read_chunk(struct exr_file *f, const exr_chunk_info_t *chunk, int32_t x, int32_t y,
                       struct err *err)
{
    struct exr_file_reader *r = f->reader;
    const bool first = !r->decoding;
    exr_result_t rc = first ? exr_decoding_initialize(r->context, 0, chunk, &r->decoder)
                            : exr_decoding_update(r->context, 0, chunk, &r->decoder);
    r->decoding |= !rc;
    if (!rc && !aim(f, x, y))
        return err_set(err, ERR_INPUT, "a chunk at (%d, %d) lies outside the image", x, y);
    if (!rc && first)
        rc = exr_decoding_choose_default_routines(r->context, 0, &r->decoder);
    if (!rc)
        rc = exr_decoding_run(r->context, 0, &r->decoder);
    return !rc || fail(err, "pixels", rc);
}

static bool read_lines(struct exr_file *f, struct err *err)
{
    exr_context_t context = f->reader->context;
    int32_t step = 0;
    const exr_result_t rc = exr_get_scanlines_per_chunk(context, 0, &step);
    if (rc || step < 1)
        return fail(err, "scan lines", rc);
    for (int64_t y = 0; y < f->height_px; y += step) {
        exr_chunk_info_t chunk;
        const exr_result_t found =
            exr_read_scanline_chunk_info(context, 0, (int)(f->y_begin + y), &chunk);
        if (found)
            return fail(err, "scan lines", found);
        if (!read_chunk(f, &chunk, 0, (int32_t)y, err))
            return false;
    }
    return true;
}

static bool read_tiles(struct exr_file *f, struct err *err)
{
    exr_context_t context = f->reader->context;
    int32_t side_x = 0, side_y = 0;
    const exr_result_t rc = exr_get_tile_sizes(context, 0, 0, 0, &side_x, &side_y);
    if (rc || side_x < 1 || side_y < 1)
        return fail(err, "tiles", rc);
    for (int64_t y = 0; y < f->height_px; y += side_y)
        for (int64_t x = 0; x < f->width_px; x += side_x) {
            exr_chunk_info_t chunk;
            const exr_result_t found = exr_read_tile_chunk_info(context, 0, (int)(x / side_x),
                                                                (int)(y / side_y), 0, 0, &chunk);
            if (found)
                return fail(err, "tiles", found);
            if (!read_chunk(f, &chunk, (int32_t)x, (int32_t)y, err))
                return false;
        }
    return true;
}

bool exr_file_read(struct exr_file *f, const struct exr_file_plane *planes, uint32_t count,
                   struct err *err)
{
    f->reader->planes = planes;
    f->reader->plane_count = count;
    return f->reader->storage == EXR_STORAGE_TILED ? read_tiles(f, err) : read_lines(f, err);
}
