/* SPDX-License-Identifier: MIT */
#include "tests/stat/zmap.h"

#include <math.h>

#include "common/arena.h"
#include "tests/stat/ks.h"
#include "common/special.h"

struct map {
    double *z;
    size_t count, exact;
};

/* A rectangle of pixels as one value. */
struct part {
    uint32_t x_begin, x_end, y_begin, y_end;
};

/* (sum of all samples)^2 / sum of all squares, of pixels with as many samples each. */
static double part_n_eff(const struct zmap_image *im, const struct part *p)
{
    double sum = 0, square = 0;
    if (!im->n_eff)
        return (double)INFINITY;
    for (uint32_t y = p->y_begin; y < p->y_end; y++)
        for (uint32_t x = p->x_begin; x < p->x_end; x++) {
            const size_t i = (size_t)y * im->width + x;
            double mean = 0;
            for (uint32_t r = 0; r < im->replicates; r++)
                mean += im->mean[i * im->replicates + r] / im->replicates;
            sum += mean;
            square += mean == 0 ? 0 : mean * mean / im->n_eff[i];
        }
    return square > 0 ? sum * sum / square : 0; /* all black: nothing was seen */
}

static struct means part_against_truth(const struct zmap_image *im, const struct part *p)
{
    const double pixels = (double)(p->x_end - p->x_begin) * (p->y_end - p->y_begin);
    double truth = 0, square = 0;
    struct stat_mean m = {0};
    for (uint32_t r = 0; r < im->replicates; r++) {
        double sum = 0;
        for (uint32_t y = p->y_begin; y < p->y_end; y++)
            for (uint32_t x = p->x_begin; x < p->x_end; x++)
                sum += im->mean[((size_t)y * im->width + x) * im->replicates + r];
        stat_add(&m, sum / pixels);
    }
    for (uint32_t y = p->y_begin; y < p->y_end; y++)
        for (uint32_t x = p->x_begin; x < p->x_end; x++) {
            const size_t i = (size_t)y * im->width + x;
            truth += im->truth[i] / pixels;
            square += im->truth_error ? im->truth_error[i] * im->truth_error[i] : 0;
        }
    struct means d = means_from_truth(&m, truth);
    d.error = sqrt(d.error * d.error + square / (pixels * pixels));
    return d;
}

static void judge(const struct zmap_image *im, const struct part *p, struct map *map)
{
    const struct means d = part_against_truth(im, p);
    if (d.off == 0 && d.error == 0) {
        map->exact++;
        return;
    }
    const double t = means_t(&d);
    double z = t; /* a NaN and infinities stay what they are */
    if (isfinite(t))
        z = copysign(special_normal_limit(special_student_tail(fabs(t), d.dof)), t);
    map->z[map->count++] = z;
}

static bool trusted(const struct zmap_image *im, const struct part *block)
{
    if (!im->n_eff)
        return true;
    for (uint32_t y = block->y_begin; y < block->y_end; y++)
        for (uint32_t x = block->x_begin; x < block->x_end; x++)
            if (!(im->n_eff[(size_t)y * im->width + x] >= ZMAP_LEAST_N_EFF))
                return false;
    return true;
}

static void judge_block(const struct zmap_image *im, const struct part *block, struct map *map,
                        struct zmap *r)
{
    if (trusted(im, block)) {
        for (uint32_t y = block->y_begin; y < block->y_end; y++)
            for (uint32_t x = block->x_begin; x < block->x_end; x++)
                judge(im, &(struct part){x, x + 1, y, y + 1}, map);
    } else if (part_n_eff(im, block) >= ZMAP_LEAST_N_EFF) {
        const size_t before = map->count;
        judge(im, block, map);
        r->blocks += map->count - before;
    } else {
        r->unjudged++;
    }
}

static void sum_up(struct map *map, double level, struct zmap *r)
{
    struct stat_mean z = {0};
    const double n = (double)map->count;
    r->limit = stat_z_limit(stat_sidak(0.5 * level, n));
    for (size_t i = 0; i < map->count; i++) {
        r->outside += !(fabs(map->z[i]) <= r->limit);
        stat_add(&z, map->z[i]);
        map->z[i] = special_normal_tail(map->z[i]);
    }
    r->mean = z.mean;
    r->variance = stat_variance(&z);
    r->mean_limit = 4 / sqrt(n);
    r->variance_limit = fmax(0.1, 4 * sqrt(2 / n));
    r->ks_p = ks_test(map->z, map->count).p;
}

struct zmap zmap_make(const struct zmap_image *im, double level)
{
    struct arena arena = {0};
    struct map map = {arena_new(&arena, double, (size_t)im->width * im->height), 0, 0};
    struct zmap r = {0};
    for (uint32_t y = 0; y < im->height; y += ZMAP_BLOCK)
        for (uint32_t x = 0; x < im->width; x += ZMAP_BLOCK) {
            const uint32_t x_end = x + ZMAP_BLOCK, y_end = y + ZMAP_BLOCK;
            const struct part block = {x, x_end < im->width ? x_end : im->width, y,
                                       y_end < im->height ? y_end : im->height};
            judge_block(im, &block, &map, &r);
        }
    r.exact = map.exact;
    r.judged = map.count;
    if (map.count >= 20)
        sum_up(&map, level, &r);
    arena_release(&arena);
    return r;
}

/* Written so that a NaN fails. */
bool zmap_passes(const struct zmap *r, double level)
{
    return r->judged >= 20 && r->outside <= r->judged / 1000 && fabs(r->mean) <= r->mean_limit &&
           fabs(r->variance - 1) <= r->variance_limit && r->ks_p > 0.5 * level;
}

double zmap_detects_all(const struct zmap *r)
{
    return (4 + special_normal_limit(1 - STAT_POWER)) / sqrt((double)r->judged);
}

double zmap_detects_one(const struct zmap *r, uint32_t replicates, double level)
{
    const struct means one = {0, 1, replicates - 1};
    return means_detects(&one, stat_sidak(0.5 * level, (double)r->judged));
}
