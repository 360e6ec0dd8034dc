/* SPDX-License-Identifier: MIT */
#include "server/image.h"

#include <string.h>

#include <openexr.h>

#include "common/base.h"
#include "server/disk.h"

struct sink { /* the file behind an OpenEXR context */
    struct disk_file file;
    struct err err; /* of the first write that failed */
    bool failed;
    exr_result_t (*compress)(exr_encode_pipeline_t *); /* the library's own */
};

static int64_t sink_write(exr_const_context_t ctxt, void *user, const void *data, uint64_t bytes,
                          uint64_t offset, exr_stream_error_func_ptr_t report)
{
    (void)ctxt;
    (void)report;
    struct sink *s = user;
    if (s->failed || !disk_write_at(&s->file, data, bytes, offset, &s->err)) {
        s->failed = true;
        return -1;
    }
    return (int64_t)bytes;
}

static void say_nothing(exr_const_context_t ctxt, exr_result_t code, const char *text)
{
    (void)ctxt;
    (void)code;
    (void)text; /* the result says it too */
}

/* OpenEXR 3.1.5 stores zlib's output when it is exactly as long as the input, and every reader then
 * takes it for raw pixels (openexr issue 2306). Noise compresses to about 100 %, so that does
 * happen: store the raw bytes instead, as the format wants. */
static exr_result_t compress_safely(exr_encode_pipeline_t *e)
{
    struct sink *s = e->encoding_user_data;
    const exr_result_t r = s->compress(e);
    if (r == EXR_ERR_SUCCESS && e->compressed_bytes >= e->packed_bytes &&
        e->compressed_buffer != e->packed_buffer) {
        memcpy(e->compressed_buffer, e->packed_buffer, e->packed_bytes);
        e->compressed_bytes = e->packed_bytes;
    }
    return r;
}

static exr_result_t add_facts(exr_context_t f, const struct image_facts *x)
{
    static const exr_attr_chromaticities_t rec709 = {.64f, .33f, .3f,    .6f,
                                                     .15f, .06f, .3127f, .329f};
    const struct {
        const char *name, *value;
    } texts[] = {
        {"software", "smalti " SMALTI_VERSION},
        {"smalti.version", SMALTI_VERSION},
        {"smalti.job", x->job},
        {"smalti.document", x->document},
        {"smalti.target", x->target},
        {"smalti.plan", x->plan},
        {"smalti.digest", x->digest},
        {"smalti.report", x->report},
    };
    const struct {
        const char *name;
        float value;
    } numbers[] = {
        {"smalti.error", x->error},          {"smalti.errorLow", x->error_low},
        {"smalti.errorHigh", x->error_high}, {"smalti.untrusted", x->unknown + x->heavy},
        {"smalti.heavyTail", x->heavy},      {"smalti.cpuSeconds", x->cpu_seconds},
        {"smalti.stopped", x->stopped},      {"smalti.sppMean", x->spp_mean},
    };
    const struct {
        const char *name;
        uint32_t value;
    } counts[] = {
        {"smalti.spp", x->spp},
        {"smalti.sppLeast", x->spp_least},
        {"smalti.sppMost", x->spp_most},
    };
    exr_result_t r = exr_attr_set_chromaticities(f, 0, "chromaticities", &rec709);
    for (size_t i = 0; !r && i < countof(texts); i++)
        if (texts[i].value && *texts[i].value)
            r = exr_attr_set_string(f, 0, texts[i].name, texts[i].value);
    for (size_t i = 0; !r && i < countof(numbers); i++)
        r = exr_attr_set_float(f, 0, numbers[i].name, numbers[i].value);
    for (size_t i = 0; !r && i < countof(counts); i++)
        r = exr_attr_set_int(f, 0, counts[i].name, (int32_t)counts[i].value);
    return r;
}

/* OpenEXR's boxes include their last pixel. */
static exr_attr_box2i_t box_of(uint32_t x_begin, uint32_t y_begin, uint32_t x_end, uint32_t y_end)
{
    exr_attr_box2i_t box;
    box.min.x = (int32_t)x_begin;
    box.min.y = (int32_t)y_begin;
    box.max.x = (int32_t)x_end - 1;
    box.max.y = (int32_t)y_end - 1;
    return box;
}

static exr_result_t write_header(exr_context_t f, const struct image *image,
                                 const struct image_facts *facts, enum image_packing packing)
{
    const struct tile_rect w = image->window;
    const exr_attr_box2i_t display = box_of(0, 0, image->width_px, image->height_px);
    const exr_attr_box2i_t data = box_of(w.x_begin, w.y_begin, w.x_end, w.y_end);
    exr_attr_v2f_t center;
    center.x = center.y = 0;
    int part;
    exr_result_t r = exr_add_part(f, "image", EXR_STORAGE_SCANLINE, &part);
    if (!r)
        r = exr_initialize_required_attr(
            f, part, &display, &data, 1, &center, 1, EXR_LINEORDER_INCREASING_Y,
            packing == IMAGE_ZIP ? EXR_COMPRESSION_ZIP : EXR_COMPRESSION_NONE);
    for (size_t c = 0; !r && c < image->channel_count; c++)
        r = exr_add_channel(f, part, image->channels[c].name,
                            image->channels[c].type == IMAGE_UINT32 ? EXR_PIXEL_UINT
                                                                    : EXR_PIXEL_FLOAT,
                            EXR_PERCEPTUALLY_LINEAR, 1, 1);
    if (!r)
        r = exr_set_version(f, part, 1);
    if (!r)
        r = add_facts(f, facts);
    return r ? r : exr_write_header(f);
}

/* The library keeps its channels sorted by name, as ours are, but that is its business. */
static void point_channels(exr_encode_pipeline_t *e, const struct image *image, int32_t y)
{
    const struct tile_rect w = image->window;
    const size_t width = w.x_end - w.x_begin;
    for (int16_t c = 0; c < e->channel_count; c++) {
        exr_coding_channel_info_t *to = &e->channels[c];
        const char *pixels = image_find(image, to->channel_name)->pixels;
        to->user_pixel_stride = 4;
        to->user_line_stride = (int32_t)(4 * width);
        to->encode_from_ptr =
            (const uint8_t *)pixels + 4 * width * (size_t)(y - (int32_t)w.y_begin);
    }
}

static exr_result_t write_chunks(exr_context_t f, const struct image *image, struct sink *sink)
{
    exr_encode_pipeline_t e = EXR_ENCODE_PIPELINE_INITIALIZER;
    int32_t step;
    exr_result_t r = exr_get_scanlines_per_chunk(f, 0, &step);
    const int32_t y_begin = (int32_t)image->window.y_begin, y_end = (int32_t)image->window.y_end;
    for (int32_t y = y_begin; !r && y < y_end; y += step) {
        exr_chunk_info_t chunk;
        r = exr_write_scanline_chunk_info(f, 0, y, &chunk);
        if (!r)
            r = y == y_begin ? exr_encoding_initialize(f, 0, &chunk, &e)
                             : exr_encoding_update(f, 0, &chunk, &e);
        if (r)
            break;
        point_channels(&e, image, y);
        if (y == y_begin) {
            r = exr_encoding_choose_default_routines(f, 0, &e);
            sink->compress = e.compress_fn;
            e.encoding_user_data = sink;
            if (e.compress_fn)
                e.compress_fn = compress_safely;
        }
        if (!r)
            r = exr_encoding_run(f, 0, &e);
    }
    exr_encoding_destroy(f, &e);
    return r;
}

bool image_write_exr(const struct image *image, const struct image_facts *facts,
                     enum image_packing packing, const char *path, struct err *err)
{
    struct sink sink = {0};
    if (!disk_create(&sink.file, path, err))
        return false;
    exr_context_initializer_t init = EXR_DEFAULT_CONTEXT_INITIALIZER;
    init.error_handler_fn = say_nothing;
    init.write_fn = sink_write;
    init.user_data = &sink;
    init.zip_level = 4;
    exr_context_t f = NULL;
    /* The name is the one that exr_finish removes when a file is incomplete. */
    exr_result_t r = exr_start_write(&f, sink.file.temporary, EXR_WRITE_FILE_DIRECTLY, &init);
    if (!r)
        r = write_header(f, image, facts, packing);
    if (!r)
        r = write_chunks(f, image, &sink);
    const exr_result_t closed = f ? exr_finish(&f) : EXR_ERR_SUCCESS;
    if (r || closed || sink.failed) {
        disk_abort(&sink.file);
        if (sink.failed) {
            *err = sink.err;
            return false;
        }
        return err_set(err, ERR_IO, "%s: OpenEXR: %s", path,
                       exr_get_default_error_message(r ? r : closed));
    }
    return disk_commit(&sink.file, err);
}
