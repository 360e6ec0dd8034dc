/* What shots say of the noise of a method. SPDX-License-Identifier: MIT */
#include <string.h>

#include "common/trace/fmath.h"
#include "common/trace/study_shot.h"

enum {
    TAIL_PART = 50, /* one in so many pixels is of the tail */
    MOST_TAIL = 128,
    THIN = 3, /* of eight replicates, so few have found the light */
};

#define FLOOR       0.01 /* of the mean: relative to less than that no error counts (estimate.h) */
#define FAR_ERROR   0.12 /* of PLAN_FAR_SLOPE */
#define LEAST_ERROR 0.03 /* of a slope that was measured */
#define LASTS       0.4  /* of what a slope differs in from others at first */
#define LN_2        0.69314718055994531

void study_shot_scale(struct study_shot *shot)
{
    const uint32_t count = shot->blocks * shot->block_pixels, block = shot->block_pixels;
    double mean = 0;
    for (uint32_t i = 0; i < count; i++)
        for (int c = 0; c < 3; c++)
            mean += shot->pixels[i].mean[c] / (3.0 * count);
    for (uint32_t i = 0; i < count; i++)
        for (int c = 0; c < 3; c++) {
            double y = 0;
            for (uint32_t k = 0; k < block; k++)
                y += shot->pixels[i - i % block + k].mean[c] / block;
            const double scale = y * y + FLOOR * FLOOR * mean * mean;
            shot->pixels[i].scale[c] = scale > 0 ? scale : 1; /* all is black, errors are 0 */
        }
}

static double relative(const double square[3], const double scale[3])
{
    return square[0] / scale[0] + square[1] / scale[1] + square[2] / scale[2];
}

double study_shot_noise(const struct study_shot *shot, const struct study_shot *usual,
                        uint32_t block, enum study_depth depth)
{
    const size_t first = (size_t)block * shot->block_pixels;
    double sum = 0;
    for (size_t i = first; i < first + shot->block_pixels; i++)
        sum += relative(shot->pixels[i].square[depth], usual->pixels[i].scale);
    return sum;
}

/* --- what pixels are like --- */

static bool is_thin(const struct study_pixel *p)
{
    double sum = 0, square = 0;
    for (int r = 0; r < FILM_REPLICATES; r++) {
        const double light = p->sums[r][0] + p->sums[r][1] + p->sums[r][2];
        sum += light;
        square += light * light;
    }
    return square > 0 && sum * sum < THIN * square;
}

struct tail { /* the largest of many numbers, the least first */
    double largest[MOST_TAIL];
    uint32_t count, most;
};

static void tail_note(struct tail *t, double v)
{
    uint32_t at = 0;
    if (t->count == t->most) {
        if (v <= t->largest[0])
            return;
        memmove(t->largest, t->largest + 1, (t->count - 1) * sizeof v);
        t->count--;
    }
    while (at < t->count && t->largest[at] < v)
        at++;
    memmove(t->largest + at + 1, t->largest + at, (t->count - at) * sizeof v);
    t->largest[at] = v;
    t->count++;
}

static void judge_pixels(const struct study_shot *shot, const struct study_shot *usual,
                         struct plan_pilot *p)
{
    const enum study_depth depth = shot->is_picked ? STUDY_FIRST : shot->depth;
    struct tail tail = {.most = min_u32(p->pixels / TAIL_PART + 1, MOST_TAIL)};
    double all = 0, worst = 0;
    uint32_t thin = 0;
    for (uint32_t i = 0; i < p->pixels; i++) {
        const double e = relative(shot->pixels[i].square[depth], usual->pixels[i].scale);
        all += e;
        thin += is_thin(&shot->pixels[i]);
        tail_note(&tail, e);
    }
    for (uint32_t i = 0; i < tail.count; i++)
        worst += tail.largest[i];
    p->tail = all > 0 ? worst / all : 0;
    p->thin = (double)thin / p->pixels;
}

/* --- how much noise there is, and how it falls --- */

struct sums { /* over blocks that speak for others, times how many they speak for */
    double noise[STUDY_DEPTHS];
    double product[STUDY_DEPTHS][STUDY_DEPTHS];
    double share; /* that they had when they were picked */
};

static struct sums add_up(const struct study_shot *shot, const struct study_shot *usual)
{
    struct sums sum = {.share = 0};
    for (uint32_t i = 0; i < shot->blocks; i++) {
        const struct study_block *b = &shot->list[i];
        double n[STUDY_DEPTHS];
        for (int d = 0; d <= (int)shot->depth; d++) {
            n[d] = b->weight * study_shot_noise(shot, usual, i, (enum study_depth)d);
            sum.noise[d] += n[d];
            for (int k = 0; k <= d; k++)
                sum.product[k][d] += n[k] * n[d];
        }
        sum.share += b->weight * b->share;
    }
    return sum;
}

struct slope { /* of squared errors over samples, log by log */
    double is, error;
};

static double doublings(enum study_depth from, enum study_depth to)
{
    return fmath_log2((double)study_depth_spp[to] / study_depth_spp[from]);
}

/* Between two depths, by what is usual and by what was measured, each as far as it can be relied
 * on. */
static struct slope slope_of(const struct sums *s, enum study_depth from, enum study_depth to,
                             struct slope usual)
{
    if (from == to || !(s->noise[from] > 0) || !(s->noise[to] > 0))
        return usual;
    const double ratio = s->noise[to] / s->noise[from], length = doublings(from, to);
    const double off2 = s->product[to][to] - 2 * ratio * s->product[from][to] +
                        ratio * ratio * s->product[from][from];
    const double error = __builtin_sqrt(off2 > 0 ? off2 : 0) / (s->noise[to] * LN_2 * length);
    const double by_usual = 1 / (usual.error * usual.error);
    const double by_measured = 1 / (error * error + LEAST_ERROR * LEAST_ERROR);
    const double all = by_usual + by_measured;
    return (struct slope){(by_usual * usual.is + by_measured * fmath_log2(ratio) / length) / all,
                          1 / __builtin_sqrt(all)};
}

/* From here on: as between the last two depths, if these were far enough on the way already. Never
 * flatter than independent samples have it. */
static double slope_from(const struct sums *s, enum study_depth depth, struct slope so_far)
{
    double slope = PLAN_SLOPE;
    if (depth == STUDY_DEEP)
        slope = PLAN_FAR_SLOPE + LASTS * (so_far.is - PLAN_FAR_SLOPE);
    else if (depth > STUDY_DEEP)
        slope = slope_of(s, STUDY_DEEP, depth, (struct slope){PLAN_FAR_SLOPE, FAR_ERROR}).is;
    return slope < -1 ? slope : -1;
}

static double square_of(double x)
{
    return x * x;
}

/* Of blocks there are only so many, and fewer yet that have much of the noise. */
static double spread_by_blocks(const struct study_shot *shot, const struct sums *s)
{
    const double noise = s->noise[shot->depth];
    double square = 0;
    if (!shot->is_picked)
        return noise > 0 ? __builtin_sqrt(s->product[shot->depth][shot->depth]) / noise : 0;
    for (uint32_t i = 0; i < shot->blocks; i++)
        square += square_of(shot->list[i].share);
    return __builtin_sqrt(square);
}

/* Where blocks were picked it is what all had at first, as it falls. */
static void judge_noise(const struct study_shot *shot, const struct study_shot *usual,
                        struct plan_pilot *p)
{
    const struct sums sum = add_up(shot, usual);
    const struct slope slope =
        slope_of(&sum, STUDY_FIRST, shot->depth, (struct slope){PLAN_SLOPE, PLAN_SLOPE_ERROR});
    const double values = 3.0 * p->pixels, length = doublings(STUDY_FIRST, shot->depth);
    const double blocks = spread_by_blocks(shot, &sum);
    p->slope = slope_from(&sum, shot->depth, slope);
    p->variance = sum.noise[shot->depth] / values * p->spp;
    p->spread = blocks;
    if (!shot->is_picked)
        return;
    const double all = sum.share > 0 ? sum.noise[STUDY_FIRST] / sum.share : 0;
    p->variance = all * fmath_exp2(slope.is * length) / values * p->spp;
    p->spread = __builtin_sqrt(square_of(blocks) + square_of(slope.error * LN_2 * length));
}

/* Units of a sample of a pixel. Of the first ones where those that were picked have taken more:
 * they are not like the others. */
static double work_of(const struct study_shot *shot, uint32_t pixels)
{
    double first = 0;
    if (!shot->is_picked && shot->depth == shot->reached)
        return (double)shot->samples.work.units / ((double)pixels * study_depth_spp[shot->depth]);
    for (uint32_t i = 0; i < shot->blocks; i++)
        first += shot->list[i].units;
    return first / ((double)pixels * study_depth_spp[STUDY_FIRST]);
}

struct plan_pilot study_shot_sum(const struct study_shot *shot, const struct study_shot *usual)
{
    struct plan_pilot p = {.pixels = shot->blocks * shot->block_pixels,
                           .spp = study_depth_spp[shot->depth]};
    p.work = work_of(shot, p.pixels);
    judge_pixels(shot, usual, &p);
    judge_noise(shot, usual, &p);
    return p;
}
