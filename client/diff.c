/* SPDX-License-Identifier: MIT */
#include "client/diff.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

struct planes {
    const float *channel[3]; /* R, G, B */
    size_t pixels;
    uint32_t width;
};

static const char *const names[] = {"R", "G", "B"};

static bool find_planes(const struct image *image, struct planes *p, struct err *err)
{
    p->width = image->window.x_end - image->window.x_begin;
    p->pixels = (size_t)p->width * (image->window.y_end - image->window.y_begin);
    for (size_t c = 0; c < 3; c++) {
        const struct image_channel *found = image_find(image, names[c]);
        if (!found || found->type != IMAGE_FLOAT32)
            return err_set(err, ERR_INPUT, "expected a channel %s of floats", names[c]);
        p->channel[c] = found->pixels;
        for (size_t i = 0; i < p->pixels; i++)
            if (!isfinite(p->channel[c][i]))
                return err_set(
                    err, ERR_INPUT, "pixel (%zu, %zu) has %s = %g; expected finite values",
                    image->window.x_begin + i % p->width, image->window.y_begin + i / p->width,
                    names[c], (double)p->channel[c][i]);
    }
    return true;
}

static bool same_window(const struct image *x, const struct image *y)
{
    return !memcmp(&x->window, &y->window, sizeof x->window) && x->width_px == y->width_px &&
           x->height_px == y->height_px;
}

static bool identical(const struct image *x, const struct image *y)
{
    if (!same_window(x, y) || x->channel_count != y->channel_count)
        return false;
    const size_t bytes = (size_t)tile_rect_pixels(x->window) * 4;
    for (size_t c = 0; c < x->channel_count; c++)
        if (strcmp(x->channels[c].name, y->channels[c].name) != 0 ||
            x->channels[c].type != y->channels[c].type ||
            memcmp(x->channels[c].pixels, y->channels[c].pixels, bytes) != 0)
            return false;
    return true;
}

static void note_largest(struct diff *d, const struct tile_rect *window, const struct planes *x,
                         const struct planes *y, size_t i, size_t c)
{
    const double a = (double)x->channel[c][i], b = (double)y->channel[c][i];
    if (!(fabs(a - b) > d->largest))
        return;
    d->largest = fabs(a - b);
    d->x_px = window->x_begin + (uint32_t)(i % x->width);
    d->y_px = window->y_begin + (uint32_t)(i / x->width);
    d->channel = *names[c];
    d->x_value = a;
    d->y_value = b;
}

static double mean_of(const struct planes *y)
{
    double sum = 0;
    for (size_t i = 0; i < y->pixels; i++)
        for (size_t c = 0; c < 3; c++)
            sum += (double)y->channel[c][i];
    return sum / (3 * (double)y->pixels);
}

static int ascending(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return x < y ? -1 : x > y;
}

static double mean_of_first(const double *terms, size_t count)
{
    double sum = 0;
    for (size_t i = 0; i < count; i++)
        sum += terms[i];
    return sum / (double)count;
}

bool diff_images(const struct image *x, const struct image *y, struct arena *scratch,
                 struct diff *d, struct err *err)
{
    struct planes p, q;
    *d = (struct diff){.channel = 'R'};
    if (!find_planes(x, &p, err))
        return err_at(err, "first image");
    if (!find_planes(y, &q, err))
        return err_at(err, "second image");
    if (p.width != q.width || p.pixels != q.pixels)
        return err_set(err, ERR_INPUT, "sizes differ: %u x %zu and %u x %zu", p.width,
                       p.pixels / p.width, q.width, q.pixels / q.width);

    const double mean = mean_of(&q), e2 = 1e-4 * mean * mean;
    double *terms = arena_new(scratch, double, p.pixels);
    for (size_t i = 0; i < p.pixels; i++) {
        for (size_t c = 0; c < 3; c++) {
            const double b = (double)q.channel[c][i], delta = (double)p.channel[c][i] - b;
            if (delta != 0) /* 0 / 0 where both are black everywhere */
                terms[i] += delta * delta / (b * b + e2) / 3;
            note_largest(d, &x->window, &p, &q, i, c);
        }
    }
    d->identical = identical(x, y);
    d->relmse = mean_of_first(terms, p.pixels);
    qsort(terms, p.pixels, sizeof *terms, ascending);
    d->relmse_999 = mean_of_first(terms, p.pixels - p.pixels / 1000);
    return true;
}
