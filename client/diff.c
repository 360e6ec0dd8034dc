/* SPDX-License-Identifier: MIT */
#include "client/diff.h"

#include <math.h>
#include <string.h>

#include "common/curve.h"

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

/* [pixel][channel], as curve.h takes them. */
static double *interleaved(const struct planes *p, struct arena *arena)
{
    double *out = arena_new(arena, double, 3 * p->pixels);
    for (size_t i = 0; i < p->pixels; i++)
        for (size_t c = 0; c < 3; c++)
            out[3 * i + c] = (double)p->channel[c][i];
    return out;
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

    for (size_t i = 0; i < p.pixels; i++)
        for (size_t c = 0; c < 3; c++)
            note_largest(d, &x->window, &p, &q, i, c);
    d->identical = identical(x, y);
    d->relmse = curve_relmse(interleaved(&p, scratch), interleaved(&q, scratch), p.pixels,
                             &d->relmse_999, arena_new(scratch, double, p.pixels));
    return true;
}
