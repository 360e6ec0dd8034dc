/* image_exr.c, image_png.c: what is written is read back bit for bit, noise above all.
 * SPDX-License-Identifier: MIT */
#include "server/image.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <openexr.h>
#include <png.h>

#include "tests/fake_job.h"
#include "tests/tap.h"

static char in_memory[] = "/dev/shm/smalti-test-image-XXXXXX"; /* fsync costs nothing there */
static char on_disk[] = "/tmp/smalti-test-image-XXXXXX";
static char path[256];

static const struct image_facts facts = {
    .job = "0123456789abcdef",
    .document = "d0c",
    .target = "{\"spp\": 8}",
    .digest = "d1gest",
    .report = "{\"error\": {}}",
    .error_low = .0625f,
    .error_high = .25f,
    .unknown = .5f,
    .heavy = .25f,
    .stopped = .375f,
    .spp_mean = 5.5f,
    .spp_least = 4,
    .spp_most = 8,
    .error = .125f,
    .cpu_seconds = 2.5f,
    .spp = 8,
};

/* ---- a reader of its own ---- */

static bool read_chunks(exr_context_t f, const struct image *image, uint32_t *const *planes)
{
    exr_decode_pipeline_t d = EXR_DECODE_PIPELINE_INITIALIZER;
    const struct tile_rect w = image->window;
    const size_t width = w.x_end - w.x_begin;
    int32_t step = 1;
    exr_result_t r = exr_get_scanlines_per_chunk(f, 0, &step);
    for (int32_t y = (int32_t)w.y_begin; !r && y < (int32_t)w.y_end; y += step) {
        exr_chunk_info_t chunk;
        r = exr_read_scanline_chunk_info(f, 0, y, &chunk);
        if (!r)
            r = y == (int32_t)w.y_begin ? exr_decoding_initialize(f, 0, &chunk, &d)
                                        : exr_decoding_update(f, 0, &chunk, &d);
        for (int16_t c = 0; !r && c < d.channel_count; c++) {
            uint32_t *at = planes[c] + width * (size_t)(y - (int32_t)w.y_begin);
            d.channels[c].decode_to_ptr = (uint8_t *)at;
            d.channels[c].user_pixel_stride = 4;
            d.channels[c].user_line_stride = (int32_t)(4 * width);
        }
        if (!r && y == (int32_t)w.y_begin)
            r = exr_decoding_choose_default_routines(f, 0, &d);
        if (!r)
            r = exr_decoding_run(f, 0, &d);
    }
    exr_decoding_destroy(f, &d);
    return r == EXR_ERR_SUCCESS;
}

static bool reads_back(const struct image *image)
{
    exr_context_t f;
    if (exr_start_read(&f, path, NULL) != EXR_ERR_SUCCESS)
        return false;
    const size_t bytes = (size_t)tile_rect_pixels(image->window) * 4;
    const exr_attr_chlist_t *names = NULL;
    bool same = exr_get_channels(f, 0, &names) == EXR_ERR_SUCCESS &&
                (size_t)names->num_channels == image->channel_count;
    uint32_t *planes[16] = {0};
    for (size_t c = 0; same && c < image->channel_count; c++) {
        same = !strcmp(names->entries[c].name.str, image->channels[c].name) &&
               (int)names->entries[c].pixel_type == (int)image->channels[c].type;
        planes[c] = malloc(bytes);
    }
    same = same && read_chunks(f, image, planes);
    for (size_t c = 0; c < image->channel_count; c++) {
        same = same && !memcmp(planes[c], image->channels[c].pixels, bytes);
        free(planes[c]);
    }
    exr_finish(&f);
    return same;
}

/* ---- images ---- */

static struct image image_of(struct tile_rect window, uint32_t width, uint32_t height, float noise,
                             struct arena *arena)
{
    struct film film;
    film_init(&film, window);
    struct film_samples s = film_samples_make(window, (struct tile_pass){0, 8}, arena);
    fake_job_fill(&s, noise);
    film_merge(&film, &s);
    const struct image image = image_from_film(&film, width, height, arena);
    film_release(&film);
    return image;
}

static void round_trips(void)
{
    static const struct {
        struct tile_rect window;
        uint32_t width, height;
    } sizes[] = {
        {{0, 0, 1, 1}, 1, 1},       {{0, 0, 33, 17}, 33, 17},   {{5, 7, 60, 41}, 64, 48},
        {{63, 47, 64, 48}, 64, 48}, {{0, 0, 256, 16}, 256, 16}, {{0, 0, 3, 200}, 3, 200},
    };
    for (size_t i = 0; i < countof(sizes); i++)
        for (int packing = IMAGE_PLAIN; packing <= IMAGE_ZIP; packing++) {
            struct arena arena = {0};
            struct err err = {.text = ""};
            const struct image image =
                image_of(sizes[i].window, sizes[i].width, sizes[i].height, .9f, &arena);
            ok(image_write_exr(&image, &facts, (enum image_packing)packing, path, &err) &&
                   reads_back(&image),
               "%ux%u at (%u, %u), %s: every bit comes back %s",
               sizes[i].window.x_end - sizes[i].window.x_begin,
               sizes[i].window.y_end - sizes[i].window.y_begin, sizes[i].window.x_begin,
               sizes[i].window.y_begin, packing == IMAGE_ZIP ? "zip" : "plain", err.text);
            arena_release(&arena);
        }
}

/* Random bits do not compress at all, zeros do; between them, somewhere, zlib's output is exactly
 * as long as its input: the case in which OpenEXR 3.1.5 writes chunks that nobody can read. */
static void incompressible(void)
{
    struct arena arena = {0};
    uint32_t state = 1;
    int bad = 0;
    const int runs = 600;
    for (int run = 0; run < runs; run++) {
        const struct image image = image_of((struct tile_rect){0, 0, 8, 16}, 8, 16, 0, &arena);
        const uint32_t zeros = 60 + (uint32_t)run % 50; /* of the 1024 words */
        for (size_t c = 0; c < image.channel_count; c++)
            for (uint32_t i = 0; i < 8 * 16; i++) {
                state ^= state << 13;
                state ^= state >> 17;
                state ^= state << 5;
                ((uint32_t *)image.channels[c].pixels)[i] = state % 1024 < zeros ? 0 : state;
            }
        struct err err;
        bad += !image_write_exr(&image, &facts, IMAGE_ZIP, path, &err) || !reads_back(&image);
        arena_reset(&arena);
    }
    arena_release(&arena);
    ok(bad == 0, "%d of %d incompressible images come back wrong", bad, runs);
}

static void attributes(void)
{
    struct arena arena = {0};
    struct err err;
    const struct image image = image_of((struct tile_rect){2, 1, 6, 5}, 9, 8, .5f, &arena);
    exr_context_t f;
    if (!ok(image_write_exr(&image, &facts, IMAGE_PLAIN, path, &err) &&
                exr_start_read(&f, path, NULL) == EXR_ERR_SUCCESS,
            "an image opens"))
        return;
    exr_attr_box2i_t data, display;
    exr_get_data_window(f, 0, &data);
    exr_get_display_window(f, 0, &display);
    ok(data.min.x == 2 && data.min.y == 1 && data.max.x == 5 && data.max.y == 4 &&
           display.min.x == 0 && display.max.x == 8 && display.max.y == 7,
       "the data window is the crop, the display window the frame");
    const char *text = NULL;
    int32_t n = 0, spp = 0;
    float error = 0, cpu = 0;
    ok(!exr_attr_get_string(f, 0, "smalti.job", &n, &text) && !strcmp(text, facts.job) &&
           !exr_attr_get_string(f, 0, "smalti.document", &n, &text) && !strcmp(text, "d0c") &&
           !exr_attr_get_string(f, 0, "smalti.target", &n, &text) && !strcmp(text, facts.target) &&
           !exr_attr_get_string(f, 0, "smalti.digest", &n, &text) && !strcmp(text, "d1gest") &&
           !exr_attr_get_string(f, 0, "smalti.version", &n, &text) && !strcmp(text, SMALTI_VERSION),
       "job, document, target, digest and version are attributes");
    ok(!exr_attr_get_float(f, 0, "smalti.error", &error) && error == .125f &&
           !exr_attr_get_float(f, 0, "smalti.cpuSeconds", &cpu) && cpu == 2.5f &&
           !exr_attr_get_int(f, 0, "smalti.spp", &spp) && spp == 8,
       "so are error, CPU seconds and samples");
    float low = 0, high = 0, untrusted = 0, heavy = 0, stopped = 0, mean = 0;
    int32_t least = 0, most = 0;
    ok(!exr_attr_get_float(f, 0, "smalti.errorLow", &low) && low == .0625f &&
           !exr_attr_get_float(f, 0, "smalti.errorHigh", &high) && high == .25f &&
           !exr_attr_get_float(f, 0, "smalti.untrusted", &untrusted) && untrusted == .75f &&
           !exr_attr_get_float(f, 0, "smalti.heavyTail", &heavy) && heavy == .25f &&
           !exr_attr_get_float(f, 0, "smalti.stopped", &stopped) && stopped == .375f &&
           !exr_attr_get_float(f, 0, "smalti.sppMean", &mean) && mean == 5.5f &&
           !exr_attr_get_int(f, 0, "smalti.sppLeast", &least) && least == 4 &&
           !exr_attr_get_int(f, 0, "smalti.sppMost", &most) && most == 8 &&
           !exr_attr_get_string(f, 0, "smalti.report", &n, &text) && !strcmp(text, facts.report),
       "so are the error's interval, what is not trusted, what has stopped, and the report");
    exr_finish(&f);
    arena_release(&arena);
}

static void failures(void)
{
    struct arena arena = {0};
    struct err err = {.text = ""};
    const struct image image = image_of((struct tile_rect){0, 0, 4, 4}, 4, 4, 0, &arena);
    ok(!image_write_exr(&image, &facts, IMAGE_ZIP, "/nonexistent/a.exr", &err) &&
           err.code == ERR_IO,
       "no such directory: %s", err.text);
    ok(!image_write_png(&image, "/nonexistent/a.png", &err) && err.code == ERR_IO,
       "for a PNG either: %s", err.text);
    arena_release(&arena);
}

static void png(void)
{
    struct arena arena = {0};
    struct err err;
    struct image image = image_of((struct tile_rect){1, 1, 4, 3}, 8, 8, 0, &arena);
    static const float linear[] = {0, .0031308f, .18f, .5f, 1, 1000};
    static const unsigned char want[] = {0, 10, 118, 188, 255, 255}; /* sRGB, rounded */
    for (size_t i = 0; i < image.channel_count; i++)
        if (strlen(image.channels[i].name) == 1)
            memcpy(image.channels[i].pixels, linear, sizeof linear);
    unsigned char got[6 * 3] = {0};
    png_image in = {.version = PNG_IMAGE_VERSION};
    ok(image_write_png(&image, path, &err) && png_image_begin_read_from_file(&in, path) &&
           in.width == 3 && in.height == 2,
       "a PNG has the size of the crop");
    in.format = PNG_FORMAT_RGB;
    png_image_finish_read(&in, NULL, got, 0, NULL);
    bool same = true;
    for (size_t i = 0; i < sizeof got; i++)
        same &= got[i] == want[i / 3];
    ok(same, "its pixels are sRGB, clipped at 1");
    arena_release(&arena);
}

int main(void)
{
    const char *dir = mkdtemp(in_memory);
    if (!dir && !(dir = mkdtemp(on_disk)))
        return 1;
    snprintf(path, sizeof path, "%s/image", dir);
    round_trips();
    incompressible();
    attributes();
    failures();
    png();
    unlink(path);
    return rmdir(dir) || tap_done();
}
