/* The coordinator's EXR writer against the CLI's reader: the same pixels, bit for bit; damaged
 * files are errors.
 * SPDX-License-Identifier: MIT */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "client/exr_read.h"
#include "common/buf.h"
#include "server/image.h"
#include "tests/tap.h"

static char path[64];

/* Noise that hardly deflates, over a wide range, with what an early film has: unknown errors. */
static struct image noise(struct tile_rect window, uint32_t width_px, uint32_t height_px,
                          struct arena *arena)
{
    struct film film;
    struct arena scratch = {0};
    film_init(&film, window);
    struct film_samples s = film_samples_make(window, (struct tile_pass){0, 5},
                                              &scratch); /* 5 spp: error is infinite */
    uint32_t state = 12345;
    for (size_t i = 0; i < (size_t)tile_rect_pixels(window) * FILM_CHANNELS; i++) {
        state = state * 1664525 + 1013904223;
        s.sums[i] = ldexpf((float)(state >> 8), (int)(state % 40) - 40);
    }
    film_merge(&film, &s);
    const struct image image = image_from_film(&film, width_px, height_px, arena);
    film_release(&film);
    arena_release(&scratch);
    return image;
}

static bool write_image(const struct image *image, enum image_packing packing, struct err *err)
{
    char hex[HASH_HEX];
    image_digest(image, hex);
    const struct image_facts facts = {.job = "5f0c9b1e8a7d6c34",
                                      .document = hex,
                                      .target = "{}",
                                      .report = "{}",
                                      .digest = hex,
                                      .error = INFINITY,
                                      .spp = 5};
    return image_write_exr(image, &facts, packing, path, err);
}

static void comes_back(struct tile_rect window, uint32_t width_px, uint32_t height_px,
                       enum image_packing packing)
{
    struct arena arena = {0};
    struct image back = {0};
    struct err err = {0};
    char want[HASH_HEX], got[HASH_HEX] = "";
    const struct image image = noise(window, width_px, height_px, &arena);
    image_digest(&image, want);
    if (write_image(&image, packing, &err) && exr_read(&back, path, &arena, &err))
        image_digest(&back, got);
    if (!ok(!strcmp(want, got), "%u x %u of %u x %u %s: the digest comes back",
            window.x_end - window.x_begin, window.y_end - window.y_begin, width_px, height_px,
            packing == IMAGE_ZIP ? "deflated" : "plain"))
        diag("%s", err.text);
    ok(!memcmp(&back.window, &window, sizeof window) && back.width_px == width_px &&
           back.height_px == height_px,
       "and so do the windows");
    arena_release(&arena);
}

/* A file cut anywhere is refused, and reading it touches nothing it should not (ASan). */
static void cut_files_are_refused(void)
{
    struct arena arena = {0};
    struct buf bytes = {0};
    struct err err;
    const struct image image = noise((struct tile_rect){0, 0, 20, 20}, 20, 20, &arena);
    if (!write_image(&image, IMAGE_ZIP, &err) || !buf_read_file(&bytes, path, 1 << 20, &err))
        diag("%s", err.text);
    size_t accepted = 0;
    for (size_t cut = 0; cut < bytes.size; cut += 13) {
        FILE *f = fopen(path, "wb");
        fwrite(bytes.data, 1, cut, f);
        fclose(f);
        struct image back;
        accepted += exr_read(&back, path, &arena, &err);
    }
    ok(bytes.size > 1000 && accepted == 0, "a file that is cut short is refused, wherever");
    buf_release(&bytes);
    arena_release(&arena);
}

static void other_files_are_refused(void)
{
    struct arena arena = {0};
    struct image image;
    struct err err;
    FILE *f = fopen(path, "wb");
    fputs("this is not an image", f);
    fclose(f);
    ok(!exr_read(&image, path, &arena, &err) && err.code == ERR_INPUT, "text is not an image");
    unlink(path);
    ok(!exr_read(&image, path, &arena, &err) && err.code == ERR_NOT_FOUND, "no file is not found");
    arena_release(&arena);
}

int main(void)
{
    strcpy(path, "/tmp/smalti-exr-XXXXXX");
    const int fd = mkstemp(path);
    if (fd < 0)
        return 1;
    close(fd);
    comes_back((struct tile_rect){0, 0, 64, 48}, 64, 48, IMAGE_PLAIN);
    comes_back((struct tile_rect){0, 0, 64, 48}, 64, 48, IMAGE_ZIP);
    comes_back((struct tile_rect){13, 7, 50, 41}, 64, 48, IMAGE_PLAIN);
    comes_back((struct tile_rect){13, 7, 50, 41}, 64, 48, IMAGE_ZIP);
    comes_back((struct tile_rect){0, 0, 1, 1}, 1, 1, IMAGE_ZIP);
    cut_files_are_refused();
    other_files_are_refused();
    return tap_done();
}
