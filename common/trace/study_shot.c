/* SPDX-License-Identifier: MIT */
#include "common/trace/study_shot.h"

#include <assert.h>
#include <string.h>

#include "common/trace/render.h"

enum { SALT = 4 };

#define PICK_EVENLY 0.5

const uint32_t study_depth_spp[STUDY_DEPTHS] = {[STUDY_FIRST] = FILM_REPLICATES,
                                                [STUDY_PILOT] = PLAN_PILOT_SPP,
                                                [STUDY_DEEP] = 64,
                                                [STUDY_DEEPEST] = 256};

static uint32_t block_side(uint32_t begin, uint32_t end)
{
    return end - begin < STUDY_BLOCK ? end - begin : STUDY_BLOCK;
}

static struct tile_rect block_rect(const struct stage *s, uint32_t i)
{
    const struct scene_film *f = &s->film;
    const struct study_place at = study_place(s, i, SALT);
    const uint32_t w = block_side(f->crop_x_begin, f->crop_x_end);
    const uint32_t h = block_side(f->crop_y_begin, f->crop_y_end);
    const uint32_t x = min_u32(at.x_px, f->crop_x_end - w), y = min_u32(at.y_px, f->crop_y_end - h);
    return (struct tile_rect){x, y, x + w, y + h};
}

void study_shot_init(struct study_shot *shot, const struct stage *s, struct arena *arena)
{
    const struct tile_rect most = {0, 0, STUDY_BLOCK, STUDY_BLOCK};
    const size_t pixels = (size_t)STUDY_BLOCKS * STUDY_BLOCK_PIXELS;
    *shot = (struct study_shot){
        .stage = s,
        .pixels = arena_new(arena, struct study_pixel, pixels),
        .list = arena_new(arena, struct study_block, STUDY_BLOCKS),
        .block_pixels = tile_rect_pixels(block_rect(s, 0)),
        .samples = film_samples_make(most, (struct tile_pass){0, 1}, arena),
    };
}

/* Squared errors of the means of sums of so many samples, by the replicates. */
static void judge(double sums[FILM_REPLICATES][3], uint32_t spp, double square[3], double mean[3])
{
    const double n = (double)spp / FILM_REPLICATES;
    for (int c = 0; c < 3; c++) {
        mean[c] = square[c] = 0;
        for (int r = 0; r < FILM_REPLICATES; r++)
            mean[c] += sums[r][c] / n / FILM_REPLICATES;
        for (int r = 0; r < FILM_REPLICATES; r++) {
            const double off = sums[r][c] / n - mean[c];
            square[c] += off * off / (FILM_REPLICATES * (FILM_REPLICATES - 1));
        }
    }
}

/* The sums of a pass onto those of the pixels of its block. */
static void take(struct study_pixel *to, const struct film_samples *from)
{
    const uint32_t pixels = tile_rect_pixels(from->rect);
    for (uint32_t i = 0; i < pixels; i++)
        for (uint32_t r = 0; r < FILM_REPLICATES; r++)
            for (uint32_t c = 0; c < 3; c++)
                to[i].sums[r][c] += (double)from->sums[i * FILM_CHANNELS + 3 * r + c];
}

static void render(struct study_shot *shot, struct tile_pass pass, struct study_pixel *to)
{
    struct film_samples *samples = &shot->samples;
    const size_t floats = (size_t)tile_rect_pixels(samples->rect) * FILM_CHANNELS;
    samples->pass = pass;
    memset(samples->sums, 0, floats * sizeof *samples->sums);
    render_tile(shot->stage, samples);
    take(to, samples);
}

static struct study_pixel *pixels_of(const struct study_shot *shot, uint32_t block)
{
    return shot->pixels + (size_t)block * shot->block_pixels;
}

/* A block to a depth, if it is not there; by all depths on the way. */
static void shoot(struct study_shot *shot, uint32_t block, enum study_depth depth)
{
    struct study_pixel *to = pixels_of(shot, block);
    struct study_block *b = &shot->list[block];
    shot->samples.rect = block_rect(shot->stage, block);
    for (int d = 0; d <= (int)depth; d++) {
        const uint64_t before = shot->samples.work.units;
        if (study_depth_spp[d] <= b->spp)
            continue;
        render(shot, (struct tile_pass){b->spp, study_depth_spp[d]}, to);
        b->spp = study_depth_spp[d];
        b->units += d == STUDY_FIRST ? (double)(shot->samples.work.units - before) : 0;
        for (uint32_t i = 0; i < shot->block_pixels; i++)
            judge(to[i].sums, b->spp, to[i].square[d], to[i].mean);
    }
}

bool study_shot_go(struct study_shot *shot, const struct study *t, uint32_t blocks,
                   enum study_depth depth)
{
    assert(blocks >= shot->blocks && blocks <= STUDY_BLOCKS);
    for (uint32_t i = 0; i < blocks; i++) {
        if (study_is_halted(t))
            return false;
        shoot(shot, i, depth);
        shot->list[i].weight = 1;
    }
    shot->blocks = blocks;
    shot->depth = depth;
    shot->reached = depth > shot->reached ? depth : shot->reached;
    shot->is_picked = false;
    return true;
}

/* --- some of them deeper --- */

/* Sets each block's share of all noise by its first samples: of none, all have the same. */
static void share_out(struct study_shot *shot)
{
    double all = 0;
    for (uint32_t i = 0; i < shot->blocks; i++)
        all += shot->list[i].share = study_shot_noise(shot, shot, i, STUDY_FIRST);
    for (uint32_t i = 0; i < shot->blocks; i++)
        shot->list[i].share = all > 0 ? shot->list[i].share / all : 1.0 / shot->blocks;
}

/* Of being picked, over the mean of all blocks. */
static double chance_of(const struct study_shot *shot, uint32_t block)
{
    return PICK_EVENLY + (1 - PICK_EVENLY) * shot->list[block].share * shot->blocks;
}

double study_shot_price(struct study_shot *shot)
{
    double sum = 0;
    share_out(shot);
    for (uint32_t i = 0; i < shot->blocks; i++)
        sum += chance_of(shot, i) * shot->list[i].units / study_depth_spp[STUDY_FIRST];
    return sum / shot->blocks;
}

bool study_shot_deepen(struct study_shot *shot, const struct study *t, uint32_t blocks,
                       enum study_depth depth)
{
    double place = 0.5; /* in the sum of chances: a block is picked where that reaches 1 */
    for (uint32_t i = 0; i < shot->blocks; i++) {
        const double chance = chance_of(shot, i) * blocks / shot->blocks;
        const double p = chance < 1 ? chance : 1;
        place += p;
        shot->list[i].weight = 0;
        if (place < 1)
            continue;
        if (study_is_halted(t))
            return false;
        place -= 1;
        shot->list[i].weight = 1 / p;
        shoot(shot, i, depth);
    }
    shot->depth = depth;
    shot->reached = depth > shot->reached ? depth : shot->reached;
    shot->is_picked = true;
    return true;
}
