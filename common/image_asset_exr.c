/* SPDX-License-Identifier: MIT */
#include "common/image_asset_build.h"

#include <math.h>
#include <string.h>

#include "common/exr_file.h"

static const struct exr_file_channel *channel_find(const struct exr_file *f, const char *name)
{
    for (uint32_t i = 0; i < f->channel_count; i++)
        if (!strcmp(f->channels[i].name, name))
            return &f->channels[i];
    return NULL;
}

/* The channels that are read, in the order in which pixels hold them. */
struct choice {
    const char *names[4];
    uint32_t count;
    bool half; /* all of them */
};

static bool choose(const struct exr_file *f, struct choice *c, struct err *err)
{
    static const char *const color[] = {"R", "G", "B"};
    *c = (struct choice){.half = true};
    for (uint32_t i = 0; i < countof(color); i++)
        if (channel_find(f, color[i]))
            c->names[c->count++] = color[i];
    if (c->count == 0 && channel_find(f, "Y"))
        c->names[c->count++] = "Y";
    else if (c->count != countof(color))
        return err_set(err, ERR_INPUT,
                       "expected the channels R, G and B, or Y, got %u others, the first \"%.64s\"",
                       f->channel_count - c->count, f->channels[0].name);
    if (channel_find(f, "A"))
        c->names[c->count++] = "A";
    for (uint32_t i = 0; i < c->count; i++) {
        const struct exr_file_channel *channel = channel_find(f, c->names[i]);
        if (channel->subsampled)
            return err_set(err, ERR_INPUT, "channel %s is subsampled; expected 1 x 1", c->names[i]);
        if (channel->type == EXR_FILE_UINT32)
            return err_set(err, ERR_INPUT, "channel %s has whole numbers; expected half or float",
                           c->names[i]);
        c->half &= channel->type == EXR_FILE_HALF;
    }
    return true;
}

static bool check_finite(const struct image_asset *image, const struct choice *c, struct err *err)
{
    const float *v = image->pixels;
    for (uint32_t y = 0; y < image->height_px; y++)
        for (uint32_t x = 0; x < image->width_px; x++)
            for (uint32_t k = 0; k < image->channels; k++, v++)
                if (!isfinite(*v))
                    return err_set(err, ERR_INPUT,
                                   "expected finite values, channel %s of pixel (%u, %u) is %g",
                                   c->names[k], x, y, (double)*v);
    return true;
}

static bool read_pixels(struct exr_file *f, struct image_asset *image, const struct choice *c,
                        struct arena *arena, struct err *err)
{
    const uint32_t size_px[2] = {f->width_px, f->height_px};
    float *pixels = image_asset_make(image, IMAGE_DEPTH_FLOAT, size_px, c->count, arena);
    struct exr_file_plane planes[4];
    const size_t step = c->count * sizeof *pixels;
    for (uint32_t k = 0; k < c->count; k++)
        planes[k] = (struct exr_file_plane){c->names[k], pixels + k, step, step * f->width_px};
    image->half = c->half;
    return exr_file_read(f, planes, c->count, err) && check_finite(image, c, err);
}

bool image_asset_exr(struct image_asset *image, struct image_asset_bytes file, struct arena *arena,
                     struct err *err)
{
    struct exr_file f;
    if (!exr_file_open(&f, &(struct exr_file_source){.data = file.data, .bytes = file.size}, err))
        return err_at(err, "EXR");
    struct choice choice;
    const bool good = (image_asset_check_size(f.width_px, f.height_px, err) &&
                       choose(&f, &choice, err) && read_pixels(&f, image, &choice, arena, err)) ||
                      err_at(err, "EXR");
    exr_file_close(&f);
    return good;
}
