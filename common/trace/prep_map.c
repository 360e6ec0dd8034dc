/* Environment maps -> pixels, and the tables by which one is chosen (light_map.h).
 * SPDX-License-Identifier: MIT */
#include "common/trace/prep_plan.h"

#include <assert.h>

#include "common/trace/fmath.h"

#define PI 3.14159265358979323846

/* Gray images have one colour, alpha is passed over, and what is below 0 counts as 0. */
static rgb pixel_at(const struct image_asset *image, size_t i)
{
    assert(image->depth == IMAGE_DEPTH_FLOAT);
    const float *p = (const float *)image->pixels + i * image->channels;
    const bool gray = image->channels < 3;
    const vec3 v = gray ? rgb_gray(p[0]) : vec3_load(p), none = {0};
    return vec3_choose(v > none, v, none);
}

static const struct image_asset *image_of(const struct scene *scene, const struct light *l)
{
    return &scene->images[l->environment.image];
}

bool prep_map_is_uniform(const struct scene *scene, const struct light *l, rgb *pixel)
{
    const struct image_asset *image = image_of(scene, l);
    const size_t count = (size_t)image->width_px * image->height_px;
    *pixel = pixel_at(image, 0);
    for (size_t i = 1; i < count; i++)
        if (!rgb_is_black(pixel_at(image, i) - *pixel))
            return false;
    return true;
}

void prep_map_open(struct prep_plan *p, struct arena *scratch)
{
    const struct scene *scene = p->scene;
    size_t maps = 0, rows = 0, pixels = 0;
    for (uint32_t i = 0; i < scene->light_count; i++)
        if (scene->lights[i].kind == LIGHT_ENVIRONMENT) {
            const struct image_asset *image = image_of(scene, &scene->lights[i]);
            maps++;
            rows += image->height_px;
            pixels += (size_t)image->width_px * image->height_px;
        }
    p->maps = arena_new(scratch, struct stage_map, maps);
    p->map_rows = arena_new(scratch, struct stage_map_row, rows);
    p->map_pixels = arena_new(scratch, struct stage_map_pixel, pixels);
    p->map_columns = arena_new(scratch, uint32_t, pixels);
}

/* sin^2 b - sin^2 a = sin(b + a) sin(b - a), which has all its digits; a and b are half the angles
 * of the row's edges. */
static void shape_rows(const struct stage_map *map, struct stage_map_row *rows)
{
    const uint32_t h = map->height;
    float step, unused;
    fmath_sincos_turns(0.25f / (float)h, &step, &unused);
    for (uint32_t i = 0; i < h; i++) {
        const uint32_t from_pole = i < h - 1 - i ? i : h - 1 - i;
        float edge, middle;
        fmath_sincos_turns((float)from_pole / (4 * (float)h), &edge, &unused);
        fmath_sincos_turns((2 * (float)from_pole + 1) / (4 * (float)h), &middle, &unused);
        rows[i].edge = edge * edge;
        rows[i].width = middle * step;
        rows[i].solid_angle = 4 * FMATH_PI * rows[i].width / (float)map->width;
    }
}

/* The parts of [0, 2^32) in proportion to weights, by where they begin; all alike when none has
 * any. sums[i]: of the weights up to and with i. */
static void cut(const double *sums, uint32_t count, uint32_t *begin, size_t stride)
{
    const double total = sums[count - 1];
    for (uint32_t i = 0; i < count; i++) {
        const double before = total > 0 ? (i ? sums[i - 1] / total : 0) : (double)i / count;
        const double at = before * 0x1p32;
        begin[i * stride] = at < 0x1.fffffffep31 ? (uint32_t)at : UINT32_MAX;
    }
}

static double mean_luminance(const struct stage_map *map, const struct stage_map_row *rows,
                             const struct stage_map_pixel *pixels, rgb scale)
{
    double sum = 0;
    for (uint32_t y = 0; y < map->height; y++) {
        double row = 0;
        for (uint32_t x = 0; x < map->width; x++, pixels++)
            row += (double)rgb_luminance(scale * vec3_load(pixels->rgb));
        sum += row * (double)rows[y].solid_angle;
    }
    return sum / (4 * PI);
}

/* A pixel's weight is what it has above the mean: up to there BSDF sampling, which takes all
 * directions, is as good. O. Karlik et al., "MIS Compensation: Optimizing Sampling Techniques in
 * Multiple Importance Sampling", SIGGRAPH Asia 2019, section 4. */
static double make_tables(struct prep_plan *p, const struct stage_map *map, rgb scale,
                          struct arena *scratch)
{
    struct stage_map_row *rows = p->map_rows + map->row_begin;
    const struct stage_map_pixel *pixels = p->map_pixels + map->pixel_begin;
    const double mean = mean_luminance(map, rows, pixels, scale);
    double *row_sums = arena_new(scratch, double, map->height), total = 0;
    double *sums = arena_new(scratch, double, map->width);
    for (uint32_t y = 0; y < map->height; y++) {
        double sum = 0;
        for (uint32_t x = 0; x < map->width; x++, pixels++) {
            const double more = (double)rgb_luminance(scale * vec3_load(pixels->rgb)) - mean;
            sum += more > 0 ? more : 0;
            sums[x] = sum;
        }
        cut(sums, map->width, p->map_columns + map->pixel_begin + (size_t)y * map->width, 1);
        total += sum * (double)rows[y].solid_angle;
        row_sums[y] = total;
    }
    cut(row_sums, map->height, &rows->begin, sizeof *rows / sizeof rows->begin);
    return total;
}

double prep_map_make(struct prep_plan *p, struct emitter *e, const struct light *l,
                     struct arena *scratch)
{
    const struct image_asset *image = image_of(p->scene, l);
    struct stage *head = &p->head;
    *e = (struct emitter){.kind = EMITTER_MAP, .index = (uint32_t)head->maps.count++};
    vec3_store(e->radiance, l->environment.scale);
    struct stage_map *map = &p->maps[e->index];
    *map = (struct stage_map){.width = image->width_px,
                              .height = image->height_px,
                              .pixel_begin = head->map_pixels.count,
                              .row_begin = head->map_rows.count};
    for (int i = 0; i < 3; i++)
        for (int k = 0; k < 3; k++)
            map->to_local[i][k] = l->environment.to_world.m[k][i];
    const size_t pixels = (size_t)map->width * map->height;
    for (size_t i = 0; i < pixels; i++)
        vec3_store(p->map_pixels[map->pixel_begin + i].rgb, pixel_at(image, i));
    head->map_rows.count += map->height;
    head->map_pixels.count += pixels;
    head->map_columns.count = head->map_pixels.count;
    shape_rows(map, p->map_rows + map->row_begin);
    return make_tables(p, map, l->environment.scale, scratch);
}
