/* diff.c: the metrics against values worked out by hand; what cannot be compared is refused.
 * SPDX-License-Identifier: MIT */
#include "client/diff.h"

#include <math.h>
#include <string.h>

#include "tests/tap.h"

static struct image make(uint32_t width, uint32_t height, float value, struct arena *arena)
{
    static const char *const names[] = {"B", "G", "R"};
    struct image image = {.window = {0, 0, width, height},
                          .width_px = width,
                          .height_px = height,
                          .channels = arena_new(arena, struct image_channel, 3),
                          .channel_count = 3};
    for (size_t c = 0; c < 3; c++) {
        float *pixels = arena_new(arena, float, (size_t)width *height);
        for (size_t i = 0; i < (size_t)width * height; i++)
            pixels[i] = value;
        image.channels[c] = (struct image_channel){names[c], IMAGE_FLOAT32, pixels};
    }
    return image;
}

static float *plane(const struct image *image, const char *name)
{
    return image_find(image, name)->pixels;
}

static void metrics(struct arena *arena)
{
    struct diff d;
    struct err err;
    const struct image x = make(40, 50, 2, arena), y = make(40, 50, 2, arena);
    ok(diff_images(&x, &y, arena, &d, &err) && d.identical && d.relmse == 0 && d.largest == 0,
       "an image does not differ from its copy");

    /* One channel of one of 2000 pixels is 3 instead of 2; e = 0.02. */
    plane(&x, "G")[40 * 7 + 5] = 3;
    ok(diff_images(&x, &y, arena, &d, &err) && !d.identical, "one value makes another image");
    near(d.relmse, 1. / (4 + 4e-4) / 6000, 1e-18, "relMSE is the mean over pixels and channels");
    ok(d.relmse_999 == 0, "relMSE-99.9 leaves out the two worst of 2000 pixels");
    ok(d.largest == 1 && d.x_px == 5 && d.y_px == 7 && d.channel == 'G' && d.x_value == 3 &&
           d.y_value == 2,
       "the largest difference is found where it is");

    const struct image dark = make(40, 50, 0, arena), other = make(40, 50, 0, arena);
    ok(diff_images(&dark, &other, arena, &d, &err) && d.relmse == 0,
       "two black images do not differ");
    ok(diff_images(&x, &dark, arena, &d, &err) && isinf(d.relmse),
       "against black everything is infinitely wrong");

    /* Reference 4 everywhere, image 2: (2 - 4)^2 / (16 + 0.0016). */
    const struct image two = make(3, 3, 2, arena), four = make(3, 3, 4, arena);
    ok(diff_images(&two, &four, arena, &d, &err), "small images can be compared");
    near(d.relmse, 4 / 16.0016, 1e-12, "the second image is the reference");
    near(d.relmse_999, d.relmse, 0, "less than 1000 pixels: none is left out");
}

static void other_channels(struct arena *arena)
{
    struct diff d;
    struct err err;
    const struct image x = make(4, 4, 1, arena);
    struct image y = make(4, 4, 1, arena);
    plane(&y, "R")[3] = -0.0f;
    plane(&x, "R")[3] = 0.0f;
    ok(diff_images(&x, &y, arena, &d, &err) && !d.identical && d.relmse == 0,
       "zeros of either sign do not differ, but are not identical");
    y = make(4, 4, 1, arena);
    plane(&y, "R")[3] = 0;
    y.width_px = 5;
    ok(diff_images(&x, &y, arena, &d, &err) && !d.identical, "another frame is not identical");
    y.width_px = 4;
    y.channel_count = 2;
    ok(!diff_images(&x, &y, arena, &d, &err) &&
           !strcmp(err.text, "second image: expected a channel R of floats"),
       "a missing channel is refused");
}

static void refused(struct arena *arena)
{
    struct diff d;
    struct err err;
    const struct image x = make(4, 4, 1, arena), y = make(4, 5, 1, arena), z = make(4, 4, 1, arena);
    ok(!diff_images(&x, &y, arena, &d, &err) && !strcmp(err.text, "sizes differ: 4 x 4 and 4 x 5"),
       "other sizes are refused");
    plane(&z, "B")[4 * 2 + 1] = NAN;
    ok(!diff_images(&z, &x, arena, &d, &err) &&
           !strncmp(err.text, "first image: pixel (1, 2) has B = ", 34),
       "a NaN is an error, with its place");
    plane(&z, "B")[4 * 2 + 1] = INFINITY;
    ok(!diff_images(&x, &z, arena, &d, &err) && err.code == ERR_INPUT, "so is an infinity");
}

int main(void)
{
    struct arena arena = {0};
    metrics(&arena);
    other_channels(&arena);
    refused(&arena);
    arena_release(&arena);
    return tap_done();
}
