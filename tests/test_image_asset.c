/* image_asset*.c: known pixels of each format, depth and packing come back, and what is damaged,
 * too large or not finite is refused.
 * SPDX-License-Identifier: MIT */
#include "common/image_asset.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <zlib.h>

#include "tests/image_files.h"
#include "tests/tap.h"

static struct arena arena;
static struct err err;

static bool read_as(enum image_format format, const struct buf *file, struct image_asset *image)
{
    *image = (struct image_asset){.format = format};
    void *exact = malloc(file->size ? file->size : 1); /* the sanitizer sees a byte too far */
    if (file->size)
        memcpy(exact, file->data, file->size);
    const bool good = image_asset_read(image, exact, file->size, &arena, &err);
    free(exact);
    return good;
}

static bool has(const struct image_asset *i, enum image_depth depth, uint32_t width,
                uint32_t height, uint32_t channels)
{
    return i->depth == depth && i->width_px == width && i->height_px == height &&
           i->channels == channels;
}

static void refused(bool good, enum err_code code, const char *what, const char *name)
{
    if (!ok(!good && err.code == code && strstr(err.text, what), "%s: refused", name))
        diag("good %d, '%s', expected '%s'", good, err.text, what);
}

/* --- PNG --- */

static void png_is(const struct image_files_png *p, const struct image_asset *want,
                   const char *name)
{
    struct buf file = {0};
    struct image_asset got;
    image_files_png(&file, p);
    const bool good = read_as(IMAGE_FORMAT_PNG, &file, &got);
    const size_t bytes = (size_t)want->width_px * want->height_px * want->channels *
                         (want->depth == IMAGE_DEPTH_U16 ? 2 : 1);
    if (!ok(good && has(&got, want->depth, want->width_px, want->height_px, want->channels) &&
                !memcmp(got.pixels, want->pixels, bytes),
            "PNG, %s", name))
        diag("%s", good ? "other pixels" : err.text);
    buf_release(&file);
}

#define WANT(depth_, w, h, c, ...)                                                                 \
    &(const struct image_asset)                                                                    \
    {                                                                                              \
        .depth = depth_, .width_px = w, .height_px = h, .channels = c, .pixels = (__VA_ARGS__)     \
    }

static void png_depths(void)
{
    png_is(&(struct image_files_png){5, 2, 1, 1, .rows = (unsigned char[]){0xa8, 0x10}},
           WANT(IMAGE_DEPTH_U8, 5, 2, 1,
                (const unsigned char[]){255, 0, 255, 0, 255, 0, 0, 0, 255, 0}),
           "gray of 1 bit");
    png_is(&(struct image_files_png){4, 1, 2, 1, .rows = (unsigned char[]){0x1b}},
           WANT(IMAGE_DEPTH_U8, 4, 1, 1, (const unsigned char[]){0, 85, 170, 255}),
           "gray of 2 bits");
    png_is(&(struct image_files_png){3, 1, 4, 1, .rows = (unsigned char[]){0x0f, 0x80}},
           WANT(IMAGE_DEPTH_U8, 3, 1, 1, (const unsigned char[]){0, 255, 136}), "gray of 4 bits");
    static const unsigned char bytes[] = {0,  1,  2,  127, 128, 129, 253, 254, 255, 10,  20,  30,
                                          40, 50, 60, 70,  80,  90,  100, 110, 120, 130, 140, 150};
    png_is(&(struct image_files_png){4, 6, 8, 1, .rows = bytes},
           WANT(IMAGE_DEPTH_U8, 4, 6, 1, bytes), "gray of 8 bits");
    png_is(&(struct image_files_png){4, 3, 8, 2, .rows = bytes},
           WANT(IMAGE_DEPTH_U8, 4, 3, 2, bytes), "gray and alpha of 8 bits");
    png_is(&(struct image_files_png){4, 2, 8, 3, .rows = bytes},
           WANT(IMAGE_DEPTH_U8, 4, 2, 3, bytes), "RGB of 8 bits");
    png_is(&(struct image_files_png){3, 2, 8, 4, .rows = bytes},
           WANT(IMAGE_DEPTH_U8, 3, 2, 4, bytes), "RGB and alpha of 8 bits");
    png_is(&(struct image_files_png){2, 4, 8, 3, .interlaced = true, .rows = bytes},
           WANT(IMAGE_DEPTH_U8, 2, 4, 3, bytes), "interlaced");
    static const uint16_t words[] = {0,     1,     255,   256,   257,   32767,
                                     32768, 65279, 65280, 65534, 65535, 4660};
    png_is(&(struct image_files_png){4, 3, 16, 1, .rows = words},
           WANT(IMAGE_DEPTH_U16, 4, 3, 1, words), "gray of 16 bits");
    png_is(&(struct image_files_png){2, 2, 16, 3, .rows = words},
           WANT(IMAGE_DEPTH_U16, 2, 2, 3, words), "RGB of 16 bits");
    png_is(&(struct image_files_png){3, 1, 16, 4, .rows = words},
           WANT(IMAGE_DEPTH_U16, 3, 1, 4, words), "RGB and alpha of 16 bits");
}

static void png_palettes(void)
{
    static const unsigned char palette[][3] = {{10, 20, 30}, {40, 50, 60}, {70, 80, 90}};
    static const unsigned char alpha[] = {255, 128, 0};
    struct image_files_png p = {.width_px = 3,
                                .height_px = 1,
                                .bits = 2,
                                .channels = 1,
                                .rows = (unsigned char[]){0x84},
                                .palette = palette,
                                .palette_count = 3};
    png_is(
        &p,
        WANT(IMAGE_DEPTH_U8, 3, 1, 3, (const unsigned char[]){70, 80, 90, 10, 20, 30, 40, 50, 60}),
        "a palette");
    p.palette_alpha = alpha;
    png_is(&p,
           WANT(IMAGE_DEPTH_U8, 3, 1, 4,
                (const unsigned char[]){70, 80, 90, 0, 10, 20, 30, 255, 40, 50, 60, 128}),
           "a palette with alpha");
    png_is(&(struct image_files_png){2, 1, 8, 3, .rows = (unsigned char[]){1, 2, 3, 4, 5, 6},
                                     .transparent = (uint16_t[]){4, 5, 6}},
           WANT(IMAGE_DEPTH_U8, 2, 1, 4, (const unsigned char[]){1, 2, 3, 255, 4, 5, 6, 0}),
           "a transparent colour");
}

/* The head with other numbers and the right checksum. */
static void png_patch(struct buf *file, size_t at, uint32_t value)
{
    for (int i = 0; i < 4; i++)
        file->data[at + (size_t)i] = (unsigned char)(value >> (24 - 8 * i));
    const uint32_t crc = (uint32_t)crc32(crc32(0, NULL, 0), file->data + 12, 17);
    for (int i = 0; i < 4; i++)
        file->data[29 + i] = (unsigned char)(crc >> (24 - 8 * i));
}

static void png_refusals(void)
{
    static const unsigned char rows[64 * 3];
    const struct image_files_png p = {8, 8, 8, 3, .rows = rows};
    struct buf file = {0};
    struct image_asset image;
    image_files_png(&file, &p);
    const size_t whole = file.size;
    size_t accepted = 0;
    for (file.size = 0; file.size < whole; file.size++)
        accepted += read_as(IMAGE_FORMAT_PNG, &file, &image);
    ok(accepted == 0, "a PNG that is cut short is refused, wherever");
    file.data[whole - 20] ^= 0x10;
    refused(read_as(IMAGE_FORMAT_PNG, &file, &image), ERR_INPUT, "PNG: ", "a flipped bit");
    file.data[whole - 20] ^= 0x10;
    png_patch(&file, 16, 16385);
    refused(read_as(IMAGE_FORMAT_PNG, &file, &image), ERR_LIMIT, "got 16385 x 8",
            "16385 pixels wide");
    png_patch(&file, 16, 16384);
    png_patch(&file, 20, 16384);
    refused(read_as(IMAGE_FORMAT_PNG, &file, &image), ERR_LIMIT, "got 16384 x 16384",
            "268 million pixels");
    png_patch(&file, 20, 4096); /* allowed, but the file does not have them */
    refused(read_as(IMAGE_FORMAT_PNG, &file, &image), ERR_INPUT,
            "PNG: ", "64 million pixels in a hundred bytes");
    png_patch(&file, 16, 0);
    refused(read_as(IMAGE_FORMAT_PNG, &file, &image), ERR_INPUT, "PNG: ", "no pixel at all");
    refused(read_as(IMAGE_FORMAT_EXR, &file, &image), ERR_INPUT,
            "expected an OpenEXR file, got a PNG file", "a PNG named .exr");
    buf_release(&file);
    buf_append(&file, "v 0 0 0\n", 8);
    refused(read_as(IMAGE_FORMAT_PNG, &file, &image), ERR_INPUT, "got 8 bytes that are none",
            "a mesh named .png");
    buf_release(&file);
}

/* --- JPEG --- */

enum { SIDE = 24 };

/* Four even quarters: at full quality the transform loses a step or two. */
static void quarters(unsigned char *rows, uint32_t channels)
{
    static const unsigned char colors[4][4] = {
        {200, 30, 40, 9}, {20, 180, 60, 9}, {10, 20, 250, 9}, {128, 128, 128, 9}};
    for (uint32_t y = 0; y < SIDE; y++)
        for (uint32_t x = 0; x < SIDE; x++)
            memcpy(rows + (y * SIDE + x) * channels, colors[(y >= SIDE / 2) * 2 + (x >= SIDE / 2)],
                   channels);
}

static void jpeg_is(uint32_t channels, bool progressive, bool subsampled, const char *name)
{
    unsigned char rows[SIDE * SIDE * 3];
    struct buf file = {0};
    struct image_asset got;
    quarters(rows, channels);
    image_files_jpeg(&file, &(struct image_files_jpeg){SIDE, SIDE, channels, progressive,
                                                       subsampled, .rows = rows});
    const bool good = read_as(IMAGE_FORMAT_JPEG, &file, &got);
    int worst = good && has(&got, IMAGE_DEPTH_U8, SIDE, SIDE, channels) ? 0 : 255;
    const unsigned char *pixels = got.pixels;
    for (uint32_t i = 0; worst < 255 && i < SIDE * SIDE * channels; i++) {
        const uint32_t x = i / channels % SIDE, y = i / channels / SIDE;
        const bool at_an_edge =
            (x > 7 && x < 16) || (y > 7 && y < 16); /* colour is blurred there */
        const int difference = abs(pixels[i] - rows[i]);
        if (!(subsampled && at_an_edge) && difference > worst)
            worst = difference;
    }
    if (!ok(worst <= 3, "JPEG, %s: its pixels within %d", name, worst))
        diag("%s", good ? "" : err.text);
    buf_release(&file);
}

static void jpeg_refusals(void)
{
    unsigned char rows[SIDE * SIDE * 4];
    struct buf file = {0};
    struct image_asset image;
    quarters(rows, 4);
    image_files_jpeg(&file, &(struct image_files_jpeg){SIDE, SIDE, 4, .rows = rows});
    refused(read_as(IMAGE_FORMAT_JPEG, &file, &image), ERR_INPUT, "CMYK", "a JPEG of four inks");
    buf_release(&file);
    quarters(rows, 3);
    image_files_jpeg(&file,
                     &(struct image_files_jpeg){SIDE, SIDE, 3, .progressive = true, .rows = rows});
    const size_t whole = file.size;
    size_t accepted = 0;
    for (file.size = 0; file.size < whole; file.size++)
        accepted += read_as(IMAGE_FORMAT_JPEG, &file, &image);
    ok(accepted == 0, "a JPEG that is cut short is refused, wherever");
    size_t at = 2; /* to the frame, whose size is 5 bytes in */
    while (file.data[at + 1] != 0xc2)
        at += 2 + (size_t)(file.data[at + 2] << 8 | file.data[at + 3]);
    memcpy(file.data + at + 5, "\xff\0", 2);
    refused(read_as(IMAGE_FORMAT_JPEG, &file, &image), ERR_LIMIT, "got 24 x 65280",
            "65280 pixels high");
    memcpy(file.data + at + 5, "\0\0", 2);
    refused(read_as(IMAGE_FORMAT_JPEG, &file, &image), ERR_INPUT, "JPEG: ", "no pixel at all");
    buf_release(&file);
}

/* Each scan may be a walk over all blocks for a few bytes of file. */
static void jpeg_scans(void)
{
    unsigned char rows[SIDE * SIDE * 3];
    struct buf file = {0};
    struct image_asset image;
    quarters(rows, 3);
    struct image_files_jpeg p = {SIDE, SIDE, 1, .by_coefficient = true, .rows = rows};
    image_files_jpeg(&file, &p);
    ok(read_as(IMAGE_FORMAT_JPEG, &file, &image), "a JPEG of 64 scans is read");
    buf_release(&file);
    p.channels = 3;
    image_files_jpeg(&file, &p);
    refused(read_as(IMAGE_FORMAT_JPEG, &file, &image), ERR_LIMIT, "at most 100 scans",
            "a JPEG of 190 scans");
    buf_release(&file);
}

/* --- EXR --- */

static const char *const bgr[] = {"B", "G", "R"};
static const char *const names_abgr_more[] = {"A", "B", "G", "R", "Z", "depth.V"};

enum { WIDTH = 37, HEIGHT = 21 };

/* Values that a half holds, of any sign and size. */
static float value_of(uint32_t i)
{
    static const float some[] = {0, .5f, -.25f, 1, 65504, 6.103515625e-05f, 1.5f, 1000, -2, 3e-5f};
    return i % 7 == 3 ? (float)(i % 1024) / 1024 : some[i % 9];
}

static void exr_is(const struct image_files_exr *settings, const char *const want[4],
                   const char *name)
{
    static float pixels[WIDTH * HEIGHT * 6];
    struct image_files_exr p = *settings;
    struct buf file = {0};
    struct image_asset got;
    p.width_px = WIDTH;
    p.height_px = HEIGHT;
    p.pixels = pixels;
    for (uint32_t i = 0; i < WIDTH * HEIGHT * p.channels; i++)
        pixels[i] = value_of(i);
    uint32_t channels = 0;
    while (channels < 4 && want[channels])
        channels++;
    const bool good = image_files_exr(&file, &p) && read_as(IMAGE_FORMAT_EXR, &file, &got) &&
                      has(&got, IMAGE_DEPTH_FLOAT, WIDTH, HEIGHT, channels) &&
                      got.half == (p.type == IMAGE_FILES_HALF);
    size_t wrong = 0;
    for (uint32_t c = 0; good && c < channels; c++)
        for (uint32_t from = 0; from < p.channels; from++)
            for (uint32_t i = 0; !strcmp(p.names[from], want[c]) && i < WIDTH * HEIGHT; i++)
                wrong +=
                    ((const float *)got.pixels)[i * channels + c] != pixels[i * p.channels + from];
    if (!ok(good && !wrong, "EXR, %s", name))
        diag("%zu wrong, %s", wrong, good ? "" : err.text);
    buf_release(&file);
}

static void exr_kinds(void)
{
    static const char *const rgb_names[4] = {"R", "G", "B"};
    static const char *const rgba_names[4] = {"R", "G", "B", "A"};
    static const char *const y_names[4] = {"Y"};
    static const char *const packings[] = {"plain", "RLE", "ZIPS", "ZIP", "PIZ", "PXR24"};
    char name[64];
    for (int half = 0; half < 2; half++)
        for (uint32_t packing = 0; packing < countof(packings); packing++) {
            if (packing == IMAGE_FILES_PXR24 && !half)
                continue; /* it drops a byte of each float */
            snprintf(name, sizeof name, "%s, %s", half ? "half" : "float", packings[packing]);
            exr_is(&(struct image_files_exr){.names = bgr,
                                             .channels = 3,
                                             .type = half ? IMAGE_FILES_HALF : IMAGE_FILES_FLOAT,
                                             .packing = (enum image_files_packing)packing},
                   rgb_names, name);
        }
    exr_is(&(struct image_files_exr){.names = bgr, .channels = 3, .type = 1, .tile_px = 16},
           rgb_names, "tiles");
    exr_is(&(struct image_files_exr){.names = bgr,
                                     .channels = 3,
                                     .type = 2,
                                     .x_begin = -9,
                                     .y_begin = 4,
                                     .packing = IMAGE_FILES_ZIP},
           rgb_names, "a data window elsewhere");
    exr_is(
        &(struct image_files_exr){
            .names = names_abgr_more, .channels = 6, .type = 2, .packing = IMAGE_FILES_ZIP},
        rgba_names, "alpha, and channels that are passed over");
    exr_is(&(struct image_files_exr){.names = (const char *const[]){"Y"}, .channels = 1, .type = 1},
           y_names, "gray");
}

static void exr_refused(const struct image_files_exr *settings, float bad, const char *what)
{
    static float pixels[8 * 4 * 3];
    struct image_files_exr p = *settings;
    struct buf file = {0};
    struct image_asset image;
    p.width_px = 8;
    p.height_px = 4;
    p.pixels = pixels;
    pixels[(2 * 8 + 5) * 3 + 1] = bad;
    if (!p.names)
        p.names = bgr;
    p.channels = 3;
    refused(image_files_exr(&file, &p) && read_as(IMAGE_FORMAT_EXR, &file, &image), ERR_INPUT, what,
            what);
    pixels[(2 * 8 + 5) * 3 + 1] = 0;
    buf_release(&file);
}

/* The header says how large it is; the pixels need not be there. */
static void exr_is_huge(struct buf *exr, uint32_t width_px, uint32_t height_px)
{
    static const char key[] = "dataWindow\0box2i\0\x10\0\0"; /* and a 0; then four numbers */
    size_t at = 0;
    while (memcmp(exr->data + at, key, sizeof key) != 0)
        at++;
    const uint32_t box[4] = {0, 0, width_px - 1, height_px - 1};
    for (size_t i = 0; i < 16; i++)
        exr->data[at + sizeof key + i] = (unsigned char)(box[i / 4] >> 8 * (i % 4));
}

static void exr_refusals(void)
{
    struct image_files_exr p = {.type = IMAGE_FILES_FLOAT, .packing = IMAGE_FILES_ZIP};
    exr_refused(&p, NAN, "channel G of pixel (5, 2) is nan");
    exr_refused(&p, -INFINITY, "channel G of pixel (5, 2) is -inf");
    p.type = IMAGE_FILES_HALF;
    exr_refused(&p, INFINITY, "channel G of pixel (5, 2) is inf");
    p.type = IMAGE_FILES_UINT;
    exr_refused(&p, 0, "channel R has whole numbers");
    p.type = IMAGE_FILES_HALF;
    p.names = (const char *const[]){"B", "G", "layer.R"};
    exr_refused(&p, 0, "expected the channels R, G and B, or Y, got 1 others");
    static const float pixels[WIDTH * HEIGHT * 3] = {1, 2, 3};
    struct buf file = {0};
    struct image_asset image;
    size_t accepted = 0;
    p = (struct image_files_exr){
        WIDTH, HEIGHT, bgr, 3, .type = 1, .packing = IMAGE_FILES_ZIP, .pixels = pixels};
    const bool made = image_files_exr(&file, &p);
    const size_t whole = file.size;
    for (file.size = 0; file.size < whole; file.size++)
        accepted += read_as(IMAGE_FORMAT_EXR, &file, &image);
    ok(made && accepted == 0, "an EXR that is cut short is refused, wherever");
    exr_is_huge(&file, 16385, 1);
    refused(read_as(IMAGE_FORMAT_EXR, &file, &image), ERR_LIMIT, "got 16385 x 1",
            "an EXR 16385 pixels wide");
    exr_is_huge(&file, 16384, 16384);
    refused(read_as(IMAGE_FORMAT_EXR, &file, &image), ERR_LIMIT, "got 16384 x 16384",
            "an EXR of 268 million pixels");
    exr_is_huge(&file, 0x80000000u, 0x80000000u);
    refused(read_as(IMAGE_FORMAT_EXR, &file, &image), ERR_INPUT, "EXR: ",
            "an EXR as large as its numbers go");
    exr_is_huge(&file, 4096, 4096);
    refused(read_as(IMAGE_FORMAT_EXR, &file, &image), ERR_INPUT, "", "16 million pixels in 10 kB");
    buf_release(&file);
}

int main(void)
{
    png_depths();
    png_palettes();
    png_refusals();
    jpeg_is(1, false, false, "gray");
    jpeg_is(3, false, false, "colour");
    jpeg_is(3, true, false, "progressive");
    jpeg_is(3, false, true, "with colour at half the resolution");
    jpeg_refusals();
    jpeg_scans();
    exr_kinds();
    exr_refusals();
    arena_release(&arena);
    return tap_done();
}
