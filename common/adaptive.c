/* SPDX-License-Identifier: MIT */
#include "common/adaptive.h"

#include <assert.h>
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "common/evidence.h"

enum { EIGHTHS = 8, STEP_SPP = 256, PILOT = ADAPTIVE_PILOT_ROUND };

/* Work that the best allocation could save: below that nothing stops. */
static const double worthwhile = 1.05;
/* Of a block, of the target's square. */
static const double least_share = .05, most_share = 2;
/* What is left below most_share may have so much more than its part of Neyman's. */
static const double most_raised = 1.5;
/* What the round before must have foretold: a tenth more error, as a square. */
static const double foretold = 1.21;

/* ---- which rounds ---- */

static bool is_power_of_2(uint32_t n)
{
    return (n & (n - 1)) == 0;
}

bool adaptive_judges(uint32_t spp)
{
    if (spp < STEP_SPP)
        return spp >= ADAPTIVE_FIRST_SPP && is_power_of_2(spp);
    uint32_t step = STEP_SPP;
    while (spp / step >= 2 * EIGHTHS)
        step *= 2;
    return spp % step == 0;
}

static uint32_t judged_after(uint32_t spp)
{
    do
        spp++;
    while (!adaptive_judges(spp));
    return spp;
}

/* ---- life ---- */

void adaptive_init(struct adaptive *a, struct tile_rect window)
{
    const size_t count = block_count(window);
    *a = (struct adaptive){
        .window = window,
        .count = count,
        .share = arena_malloc(count, sizeof *a->share),
        .content = arena_malloc(count, sizeof *a->content),
        .stop = arena_malloc(count, sizeof *a->stop),
    };
    adaptive_aim(a, 0);
}

void adaptive_resize(struct adaptive *a, uint32_t rounds)
{
    assert(rounds <= ADAPTIVE_MAX_ROUNDS);
    if (rounds)
        a->blocks = arena_realloc(a->blocks, rounds * a->count, sizeof *a->blocks);
    a->rounds = rounds;
}

void adaptive_copy(struct adaptive *to, const struct adaptive *from)
{
    struct adaptive copy = *from;
    copy.blocks = NULL;
    copy.share = arena_malloc(from->count, sizeof *copy.share);
    copy.content = arena_malloc(from->count, sizeof *copy.content);
    copy.stop = arena_malloc(from->count, sizeof *copy.stop);
    adaptive_resize(&copy, from->rounds);
    if (from->rounds)
        memcpy(copy.blocks, from->blocks, from->rounds * from->count * sizeof *copy.blocks);
    memcpy(copy.share, from->share, from->count * sizeof *copy.share);
    memcpy(copy.content, from->content, from->count * sizeof *copy.content);
    memcpy(copy.stop, from->stop, from->count * sizeof *copy.stop);
    *to = copy;
}

void adaptive_release(struct adaptive *a)
{
    free(a->blocks);
    free(a->share);
    free(a->content);
    free(a->stop);
    *a = (struct adaptive){0};
}

/* ---- what follows ---- */

static const struct adaptive_block *round_of(const struct adaptive *a, uint32_t round)
{
    return a->blocks + round * a->count;
}

static double pixels_of(const struct adaptive *a, size_t i)
{
    return tile_rect_pixels(block_rect_of(a->window, i));
}

/* t / target^2 of the header, for a multiple of d. */
static double share_of(double noise)
{
    return noise < least_share ? least_share : noise < most_share ? noise : most_share;
}

/* The sum of the shares, times pixels, at this many times of the blocks' noise. */
static double sum_of_shares(const struct adaptive *a, double times)
{
    double sum = 0;
    for (size_t i = 0; i < a->count; i++)
        sum += pixels_of(a, i) * share_of(times * sqrt((double)round_of(a, PILOT)[i].error2));
    return sum;
}

/* As many times as the mean of the shares allows, by halving. */
static double times_noise(const struct adaptive *a, double mean)
{
    double low = 0, high = most_raised / mean;
    for (int i = 0; i < 50; i++) {
        const double middle = (low + high) / 2;
        *(sum_of_shares(a, middle) <= tile_rect_pixels(a->window) ? &low : &high) = middle;
    }
    return low;
}

/* What the pilot says once and for all. */
static void settle(struct adaptive *a)
{
    const struct adaptive_block *pilot = round_of(a, PILOT);
    double lit = 0, sum = 0, square = 0;
    for (size_t i = 0; i < a->count; i++) {
        lit += pilot[i].neff != 0 && isfinite(pilot[i].neff);
        sum += pixels_of(a, i) * sqrt((double)pilot[i].error2);
        square += pixels_of(a, i) * (double)pilot[i].error2;
    }
    const double shared = ADAPTIVE_LEAST_NEFF / (lit > 1 ? lit : 1);
    const double mean = sum / tile_rect_pixels(a->window);
    a->even = mean > 0 && square / tile_rect_pixels(a->window) < worthwhile * mean * mean;
    a->need = shared > EVIDENCE_LEAST ? shared : EVIDENCE_LEAST;
    const double times = mean > 0 ? times_noise(a, mean) : 0;
    for (size_t i = 0; i < a->count; i++)
        a->share[i] = (float)share_of(times * sqrt((double)pilot[i].error2));
}

static bool has_evidence(const struct adaptive *a, uint32_t round, size_t i)
{
    const struct adaptive_block b = round_of(a, round)[i];
    return b.error2 >= 0 && (double)b.neff >= a->need;
}

/* The square of the least target for which this round, and the one before, make the block content;
 * +infinity: for none. */
static double asks(const struct adaptive *a, uint32_t round, size_t i)
{
    if (a->even || !has_evidence(a, round, i) || !has_evidence(a, round - 1, i))
        return (double)INFINITY;
    const double fewer = (double)a->spp[round - 1] / a->spp[round];
    const double is = (double)round_of(a, round)[i].error2;
    const double was = (double)round_of(a, round - 1)[i].error2 * fewer / foretold;
    const double share = (double)a->share[i];
    return max_f64(is, was) / (round == PILOT && share > 1 ? 1 : share);
}

/* A heavy tail is its own block's matter; too few samples that show anything are not. */
static bool has_seen(const struct adaptive *a, uint32_t round, size_t i)
{
    const struct adaptive_block b = round_of(a, round)[i];
    return b.error2 >= 0 && fabs((double)b.neff) >= a->need;
}

static bool may_stop(const struct adaptive *a, uint32_t round, size_t at)
{
    const struct tile_rect r = block_around(a->window, at);
    for (uint32_t y = r.y_begin; y < r.y_end; y++)
        for (uint32_t x = r.x_begin; x < r.x_end; x++) {
            const size_t i = y * block_columns(a->window) + x;
            if (a->content[i] == ADAPTIVE_NEVER && !has_seen(a, round, i))
                return false;
        }
    return true;
}

static void follow(struct adaptive *a, uint32_t round)
{
    if (round == PILOT)
        settle(a);
    if (!(a->target > 0) || round < PILOT)
        return;
    for (size_t i = 0; i < a->count; i++)
        if (a->content[i] == ADAPTIVE_NEVER && asks(a, round, i) <= a->target * a->target)
            a->content[i] = (uint8_t)round;
    for (size_t i = 0; i < a->count; i++)
        if (a->stop[i] == ADAPTIVE_NEVER && a->content[i] != ADAPTIVE_NEVER &&
            may_stop(a, round, i))
            a->stop[i] = (uint8_t)round;
}

void adaptive_aim(struct adaptive *a, double target)
{
    a->target = target;
    memset(a->content, ADAPTIVE_NEVER, a->count);
    memset(a->stop, ADAPTIVE_NEVER, a->count);
    for (uint32_t r = 0; r < a->rounds; r++)
        follow(a, r);
}

/* ---- rounds come ---- */

static uint32_t round_that_ends_at(const struct adaptive *a, uint32_t spp)
{
    uint32_t r = 0;
    while (r < a->rounds && a->spp[r] < spp)
        r++;
    return r;
}

static void add_last(struct adaptive *a, const struct adaptive_look *l)
{
    assert(l->spp == (a->rounds ? judged_after(a->spp[a->rounds - 1]) : ADAPTIVE_FIRST_SPP));
    const uint32_t round = a->rounds;
    adaptive_resize(a, round + 1);
    a->spp[round] = l->spp;
    if (round <= PILOT)
        a->least = l->least;
    memcpy(a->blocks + round * a->count, l->blocks, a->count * sizeof *l->blocks);
    follow(a, round);
}

void adaptive_add(struct adaptive *a, const struct adaptive_look *l)
{
    const uint32_t round = round_that_ends_at(a, l->spp);
    if (round == a->rounds) {
        add_last(a, l);
        return;
    }
    struct adaptive_block *to = a->blocks + round * a->count;
    for (size_t i = 0; i < a->count; i++)
        if (to[i].error2 < 0)
            to[i] = l->blocks[i];
    adaptive_aim(a, a->target);
}

/* ---- decisions ---- */

/* Of a target with this square. All content, all shares used: the same number on both sides, but
 * for rounding. */
static double most_for(const struct adaptive *a, double target2)
{
    return target2 * tile_rect_pixels(a->window) * (1 + 1e-9);
}

/* Of the whole image, in this round. */
struct state {
    double error2;    /* the sum, times pixels */
    double effective; /* samples, of a block at most its need */
    bool lit;         /* is anything else than fine and black? */
};

static void judge(const struct adaptive *a, uint32_t round, size_t i, struct state *to)
{
    const bool content = a->content[i] <= round;
    const struct adaptive_block b = round_of(a, content ? a->content[i] : round)[i];
    const double neff = fabs((double)b.neff);
    /* Not sampled: not one's own doing. */
    to->error2 += pixels_of(a, i) * (b.error2 < 0 ? DBL_MAX : (double)b.error2);
    if (isinf(neff))
        return;
    to->lit = true;
    to->effective += content || neff > a->need ? a->need : neff;
}

/* For targets whose square is `from` and more a block's error counts by so much more. */
struct change {
    double from, more;
};

static int rising(const void *a, const void *b)
{
    const struct change *x = a, *y = b;
    if (x->from != y->from)
        return x->from < y->from ? -1 : 1;
    return (x->more > y->more) - (x->more < y->more);
}

/* Where the block would have become content before, for larger and larger targets. */
static size_t changes_of(const struct adaptive *a, uint32_t round, size_t i, struct change *to)
{
    const double now = a->target * a->target;
    struct change found[ADAPTIVE_MAX_ROUNDS];
    size_t count = 0;
    double least = (double)INFINITY; /* of the targets, to be content in a round before */
    for (uint32_t r = PILOT; r <= round && least > now; r++) {
        const double from = asks(a, r, i), g = (double)round_of(a, r)[i].error2;
        if (from >= least)
            continue;
        found[count++] = (struct change){from, g};
        least = from;
    }
    double after = least <= now ? found[--count].more : (double)round_of(a, round)[i].error2;
    for (size_t k = 0; k < count; k++) { /* the least target last: from there on */
        to[k] = found[count - 1 - k];
        const double g = to[k].more;
        to[k].more = pixels_of(a, i) * (g - after);
        after = g;
    }
    return count;
}

/* Would a job with any larger target have met it in this round, too? error2: the sum, for one's
 * own. */
static bool is_due_for_larger(const struct adaptive *a, uint32_t round, double error2)
{
    struct change *changes = arena_malloc(a->count * (round - PILOT + 1), sizeof *changes);
    size_t count = 0;
    for (size_t i = 0; i < a->count; i++)
        count += changes_of(a, round, i, changes + count);
    qsort(changes, count, sizeof *changes, rising);
    bool due = true;
    for (size_t k = 0; due && k < count; k++) {
        error2 += changes[k].more;
        const bool last = k + 1 == count || changes[k + 1].from > changes[k].from;
        due = !last || error2 <= most_for(a, changes[k].from);
    }
    free(changes);
    return due;
}

/* Before the pilot, when all blocks have as many samples: only with evidence everywhere. */
static bool is_due_early(const struct adaptive *a, uint32_t round, double most)
{
    double error2 = 0, effective = 0;
    bool lit = false;
    for (size_t i = 0; i < a->count; i++) {
        const struct adaptive_block b = round_of(a, round)[i];
        if (!(b.neff >= EVIDENCE_LEAST))
            return false;
        error2 += pixels_of(a, i) * (double)b.error2;
        lit = lit || isfinite(b.neff);
        effective += isfinite(b.neff) ? (double)b.neff : 0;
    }
    return error2 <= most && (!lit || effective >= ADAPTIVE_LEAST_NEFF);
}

bool adaptive_is_due(const struct adaptive *a, uint32_t spp)
{
    const uint32_t round = round_that_ends_at(a, spp);
    if (!(a->target > 0) || round == a->rounds || a->spp[round] != spp)
        return false;
    const double most = most_for(a, a->target * a->target);
    if (round < PILOT)
        return is_due_early(a, round, most);
    struct state now = {0};
    for (size_t i = 0; i < a->count; i++)
        judge(a, round, i, &now);
    return now.error2 <= most && (!now.lit || now.effective >= ADAPTIVE_LEAST_NEFF) &&
           is_due_for_larger(a, round, now.error2);
}

/* Having [0, spp) already. */
static bool has_stopped(const struct adaptive *a, size_t i, uint32_t spp)
{
    return a->stop[i] != ADAPTIVE_NEVER && a->spp[a->stop[i]] <= spp;
}

struct block_set adaptive_blocks(const struct adaptive *a, const struct film *f,
                                 struct tile_rect rect, struct tile_pass pass)
{
    struct block_set set = {0};
    const uint32_t columns = block_columns(rect);
    const size_t first =
        (size_t)(rect.y_begin - a->window.y_begin) / BLOCK_PX * block_columns(a->window) +
        (rect.x_begin - a->window.x_begin) / BLOCK_PX;
    for (size_t i = 0; i < block_count(rect); i++) {
        const size_t at = first + i / columns * block_columns(a->window) + i % columns;
        if (!has_stopped(a, at, pass.s_begin) && film_block_spp(f, at) <= pass.s_begin)
            block_set_add(&set, i);
    }
    return set;
}

double adaptive_stopped(const struct adaptive *a, uint32_t spp)
{
    double stopped = 0;
    for (size_t i = 0; i < a->count; i++)
        stopped += has_stopped(a, i, spp) ? pixels_of(a, i) : 0;
    return stopped / tile_rect_pixels(a->window);
}

/* ---- checkpoints ---- */

static bool check_block(const struct adaptive *a, uint32_t round, size_t i, struct err *err)
{
    const struct adaptive_block b = round_of(a, round)[i];
    const bool absent = b.error2 == -1 && b.neff == 0;
    if (!absent && !(b.error2 >= 0 && b.error2 <= FLT_MAX))
        return err_set(err, ERR_INPUT, "error2 %g: expected at least 0, or -1", (double)b.error2);
    if (!(b.neff >= -FLT_MAX))
        return err_set(err, ERR_INPUT, "neff %g: expected a number", (double)b.neff);
    if (absent && round <= PILOT)
        return err_set(err, ERR_INPUT, "not sampled: expected only after %d samples",
                       ADAPTIVE_PILOT_SPP);
    if (!absent && round > 0 && round_of(a, round - 1)[i].error2 < 0)
        return err_set(err, ERR_INPUT, "sampled: expected no samples after a round without");
    return true;
}

bool adaptive_check(const struct adaptive *a, struct err *err)
{
    if (!(a->least >= 0 && a->least <= DBL_MAX))
        return err_set(err, ERR_INPUT, "least %g: expected at least 0", a->least);
    for (uint32_t r = 0; r < a->rounds; r++) {
        const uint32_t want = r ? judged_after(a->spp[r - 1]) : ADAPTIVE_FIRST_SPP;
        if (a->spp[r] != want)
            return err_set(err, ERR_INPUT, "round %u ends at %u samples: expected %u", r, a->spp[r],
                           want);
        for (size_t i = 0; i < a->count; i++)
            if (!check_block(a, r, i, err))
                return err_at(err, "round %u, block %zu", r, i);
    }
    return true;
}
