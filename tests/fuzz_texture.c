/* Any bytes as an image: an answer, never a crash, and only finite values.
 *
 * The first byte chooses. Below 128: the format, and the rest is the file behind the format's own
 * first bytes. From there on: one of the files that the libraries make, the rest says where it is
 * changed (two bytes: where, one: to what; a PNG's checksums are then made right) - so that the
 * inner parts of the formats are met without a corpus.
 *
 *     build/fuzz-clang/bin/fuzz_texture -max_len=5000 CORPUS
 * SPDX-License-Identifier: MIT */
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <zlib.h>

#include "common/image_asset.h"
#include "tests/image_files.h"

int LLVMFuzzerTestOneInput(const unsigned char *data, size_t bytes);

enum { SIDE = 20, KINDS = 16 };

static enum image_format make(struct buf *file, unsigned kind)
{
    static const char *const names[] = {"A", "B", "G", "R"};
    static unsigned char rows[SIDE * SIDE * 8];
    static float pixels[SIDE * SIDE * 4];
    for (size_t i = 0; i < countof(rows); i++)
        rows[i] = (unsigned char)(i * i / 7);
    for (size_t i = 0; i < countof(pixels); i++)
        pixels[i] = (float)(i % 19) / 4;
    if (kind < 6) {
        image_files_png(file,
                        &(struct image_files_png){SIDE, SIDE, kind == 5 ? 16 : 8, kind % 4 + 1,
                                                  kind == 4, rows, NULL, NULL, 0, NULL});
        return IMAGE_FORMAT_PNG;
    }
    if (kind < 10) {
        image_files_jpeg(file, &(struct image_files_jpeg){SIDE, SIDE, kind == 6 ? 1 : 3, kind == 7,
                                                          kind == 8, kind == 9, rows});
        return IMAGE_FORMAT_JPEG;
    }
    const struct image_files_exr exr = {SIDE,
                                        SIDE,
                                        names,
                                        4,
                                        kind % 2 ? IMAGE_FILES_HALF : IMAGE_FILES_FLOAT,
                                        (enum image_files_packing)(kind - 10),
                                        kind == 13 ? 8 : 0,
                                        0,
                                        0,
                                        pixels};
    if (!image_files_exr(file, &exr))
        abort();
    return IMAGE_FORMAT_EXR;
}

/* After the signature: length, name, content, checksum of name and content. */
static void mend_png(struct buf *file)
{
    size_t at = 8;
    while (at + 12 <= file->size) {
        const unsigned char *p = file->data + at;
        const size_t length = (size_t)p[0] << 24 | (size_t)p[1] << 16 | (size_t)p[2] << 8 | p[3];
        if (length > file->size - at - 12)
            return;
        const uint32_t crc =
            (uint32_t)crc32(crc32(0, NULL, 0), file->data + at + 4, (uInt)(4 + length));
        for (int i = 0; i < 4; i++)
            file->data[at + 8 + length + (size_t)i] = (unsigned char)(crc >> (24 - 8 * i));
        at += 12 + length;
    }
}

static enum image_format make_file(struct buf *file, const unsigned char *data, size_t bytes)
{
    static const struct {
        const char *text;
        size_t bytes;
    } magic[] = {{"\x89PNG\r\n\x1a\n", 8}, {"\xff\xd8\xff", 3}, {"\x76\x2f\x31\x01", 4}};
    if (data[0] < 128) {
        const enum image_format format = (enum image_format)(data[0] % IMAGE_ASSET_FORMATS);
        buf_append(file, magic[format].text, magic[format].bytes);
        buf_append(file, data + 1, bytes - 1);
        return format;
    }
    const enum image_format format = make(file, data[0] % KINDS);
    for (size_t i = 1; i + 3 <= bytes; i += 3)
        file->data[((size_t)data[i] << 8 | data[i + 1]) % file->size] = data[i + 2];
    if (format == IMAGE_FORMAT_PNG)
        mend_png(file);
    return format;
}

static void check(const struct image_asset *image)
{
    const size_t values = (size_t)image->width_px * image->height_px * image->channels;
    if (!values || image->channels > 4)
        abort();
    for (size_t i = 0; image->depth == IMAGE_DEPTH_FLOAT && i < values; i++)
        if (!isfinite(((const float *)image->pixels)[i]))
            abort();
}

int LLVMFuzzerTestOneInput(const unsigned char *data, size_t bytes)
{
    if (bytes == 0)
        return 0;
    struct arena arena = {0};
    struct err err = {0};
    struct buf file = {0};
    struct image_asset image = {.format = make_file(&file, data, bytes)};
    unsigned char *exact = malloc(file.size); /* a byte too far is then seen */
    memcpy(exact, file.data, file.size);
    if (image_asset_read(&image, exact, file.size, &arena, &err))
        check(&image);
    else if (!*err.text || (err.code != ERR_INPUT && err.code != ERR_LIMIT))
        abort();
    free(exact);
    buf_release(&file);
    arena_release(&arena);
    return 0;
}
