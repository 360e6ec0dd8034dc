/* SPDX-License-Identifier: MIT */
#include "common/trace/light_map.h"

#include "common/trace/fmath.h"

static const struct stage_map_row *rows_of(const struct stage *s, const struct stage_map *map)
{
    return (const struct stage_map_row *)stage_at(s, s->map_rows) + map->row_begin;
}

static const uint32_t *columns_of(const struct stage *s, const struct stage_map *map, uint32_t row)
{
    return (const uint32_t *)stage_at(s, s->map_columns) + map->pixel_begin +
           (size_t)row * map->width;
}

static rgb pixel_of(const struct stage *s, const struct stage_map *map, uint32_t row,
                    uint32_t column)
{
    const struct stage_map_pixel *pixels = stage_at(s, s->map_pixels);
    return vec3_load(pixels[map->pixel_begin + (size_t)row * map->width + column].rgb);
}

/* Where a part of [0, 2^32) begins, of the numbers that are left for it: the largest stands for the
 * end, so that what comes last may be as impossible as anything else. (Were it merely improbable,
 * the strategy that trusts light sampling would leave it to that.) */
static double begin_of(uint32_t begin)
{
    return begin < UINT32_MAX ? (double)begin : 0x1p32;
}

static uint32_t kept(uint32_t number)
{
    return number < UINT32_MAX ? number : UINT32_MAX - 1;
}

/* Of a part: a choice's. */
static double width_of(uint32_t begin, uint32_t index, uint32_t count, uint32_t next)
{
    return (index + 1 < count ? begin_of(next) : 0x1p32) - begin_of(begin);
}

static double row_width(const struct stage_map *map, const struct stage_map_row *rows, uint32_t row)
{
    return width_of(rows[row].begin, row, map->height,
                    row + 1 < map->height ? rows[row + 1].begin : 0);
}

static double column_width(const struct stage_map *map, const uint32_t *columns, uint32_t column)
{
    return width_of(columns[column], column, map->width,
                    column + 1 < map->width ? columns[column + 1] : 0);
}

static uint32_t find_row(const struct stage_map *map, const struct stage_map_row *rows, uint32_t x)
{
    uint32_t begin = 0, end = map->height; /* rows[begin].begin <= x */
    while (end - begin > 1) {
        const uint32_t middle = begin + (end - begin) / 2;
        if (rows[middle].begin <= x)
            begin = middle;
        else
            end = middle;
    }
    return begin;
}

static uint32_t find_column(const struct stage_map *map, const uint32_t *columns, uint32_t x)
{
    uint32_t begin = 0, end = map->width;
    while (end - begin > 1) {
        const uint32_t middle = begin + (end - begin) / 2;
        if (columns[middle] <= x)
            begin = middle;
        else
            end = middle;
    }
    return begin;
}

/* turns: from the left edge; s = (1 - cos) / 2 of the angle from the nearer pole. */
static vec3 direction(const struct stage_map *map, float turns, float s, bool lower)
{
    float sine, cosine;
    fmath_sincos_turns(turns, &sine, &cosine);
    const float across = 2 * __builtin_sqrtf(s * (1 - s)), up = 1 - 2 * s;
    const vec3 local = vec3_make(-across * sine, lower ? -up : up, across * cosine);
    const vec3 x = vec3_load(map->to_local[0]), y = vec3_load(map->to_local[1]),
               z = vec3_load(map->to_local[2]);
    return vec3_unit(x * local[0] + y * local[1] + z * local[2]);
}

struct light_map_sample light_map_sample(const struct stage *s, const struct stage_map *map,
                                         struct sobol_bits q)
{
    const struct stage_map_row *rows = rows_of(s, map);
    q = (struct sobol_bits){kept(q.u), kept(q.v)};
    const uint32_t row = find_row(map, rows, q.v);
    const uint32_t *columns = columns_of(s, map, row);
    const uint32_t column = find_column(map, columns, q.u);
    const double high = row_width(map, rows, row), wide = column_width(map, columns, column);
    const double down = ((double)(q.v - rows[row].begin) + 0.5) / high;
    const double right = ((double)(q.u - columns[column]) + 0.5) / wide;
    return (struct light_map_sample){
        .dir =
            direction(map, (float)(((double)column + right) / (double)map->width),
                      rows[row].edge + (float)down * rows[row].width, row >= map->height - 1 - row),
        .pixel = pixel_of(s, map, row, column),
        .pdf_w = (float)(high * wide * 0x1p-64) / rows[row].solid_angle};
}

static uint32_t place_of(float part, uint32_t count)
{
    const float at = part * (float)count;
    return at >= (float)count ? count - 1 : at > 0 ? (uint32_t)at : 0;
}

rgb light_map_pixel(const struct stage *s, const struct stage_map *map, vec3 dir, float *pdf_w)
{
    const float x = vec3_dot(vec3_load(map->to_local[0]), dir);
    const float y = vec3_dot(vec3_load(map->to_local[1]), dir);
    const float z = vec3_dot(vec3_load(map->to_local[2]), dir);
    const float angle = fmath_atan2(__builtin_sqrtf(x * x + z * z), y);
    const uint32_t row = place_of(angle * FMATH_INV_PI, map->height);
    const uint32_t column = place_of(0.5f + fmath_atan2(x, -z) * (0.5f * FMATH_INV_PI), map->width);
    const struct stage_map_row *rows = rows_of(s, map);
    const double part =
        row_width(map, rows, row) * column_width(map, columns_of(s, map, row), column);
    *pdf_w = (float)(part * 0x1p-64) / rows[row].solid_angle;
    return pixel_of(s, map, row, column);
}
