/* SPDX-License-Identifier: MIT */
#include "client/exr_read.h"

#include <stdlib.h>
#include <string.h>

#include "common/exr_file.h"

static bool check_head(const struct exr_file *f, struct err *err)
{
    if (f->width_px > INT32_MAX / 4 || f->height_px > INT32_MAX / 4 ||
        (uint64_t)f->width_px * f->height_px > EXR_READ_MAX_VALUES / f->channel_count)
        return err_set(err, ERR_LIMIT, "%u x %u pixels with %u channels are more than %llu values",
                       f->width_px, f->height_px, f->channel_count,
                       (unsigned long long)EXR_READ_MAX_VALUES);
    for (uint32_t c = 0; c < f->channel_count; c++)
        if (f->channels[c].subsampled)
            return err_set(err, ERR_INPUT, "channel %s is subsampled; expected 1 x 1",
                           f->channels[c].name);
    return true;
}

static int by_name(const void *a, const void *b)
{
    return strcmp(((const struct image_channel *)a)->name, ((const struct image_channel *)b)->name);
}

static void make_image(struct image *image, const struct exr_file *f, struct arena *arena)
{
    const uint32_t x = (uint32_t)max_i64(f->x_begin, 0), y = (uint32_t)max_i64(f->y_begin, 0);
    image->window = (struct tile_rect){x, y, x + f->width_px, y + f->height_px};
    image->width_px = (uint32_t)max_i64(f->display_x_end, 0);
    image->height_px = (uint32_t)max_i64(f->display_y_end, 0);
    image->channel_count = f->channel_count;
    image->channels = arena_new(arena, struct image_channel, image->channel_count);
    for (size_t c = 0; c < image->channel_count; c++)
        image->channels[c] = (struct image_channel){
            .name = arena_strdup(arena, f->channels[c].name),
            .type = f->channels[c].type == EXR_FILE_UINT32 ? IMAGE_UINT32 : IMAGE_FLOAT32,
            .pixels = arena_alloc(arena, (size_t)f->width_px * f->height_px, 4, 4),
        };
    qsort(image->channels, image->channel_count, sizeof *image->channels, by_name);
}

static bool read_planes(struct exr_file *f, const struct image *image, struct err *err)
{
    struct exr_file_plane *planes = arena_malloc(image->channel_count, sizeof *planes);
    for (size_t c = 0; c < image->channel_count; c++)
        planes[c] = (struct exr_file_plane){image->channels[c].name, image->channels[c].pixels, 4,
                                            (size_t)4 * f->width_px};
    const bool good = exr_file_read(f, planes, (uint32_t)image->channel_count, err);
    free(planes);
    return good;
}

bool exr_read(struct image *image, const char *path, struct arena *arena, struct err *err)
{
    *image = (struct image){0};
    struct exr_file f;
    if (!exr_file_open(&f, &(struct exr_file_source){.path = path}, err))
        return err_at(err, "%s", path);
    bool good = check_head(&f, err);
    if (good) {
        make_image(image, &f, arena);
        good = read_planes(&f, image, err);
    }
    exr_file_close(&f);
    return good || err_at(err, "%s", path);
}
