/* SPDX-License-Identifier: MIT */
#include "common/adaptive.h"

#include <assert.h>
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "common/estimate.h"
#include "common/evidence.h"

enum { EIGHTHS = 8, STEP_SPP = 256, PILOT = 2 }; /* PILOT: the index of its round */

/* The upper end of a block's interval may be above its error by so much, as a square. At 1.2 two to
 * four of a hundred stopped blocks were off by more than 1.2 of the target; at 1.1 half as many,
 * for no more work. */
static const double slack = 1.21;
/* Work that the best allocation could save: below that nothing stops. */
static const double worthwhile = 1.05;
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

/* ---- a look ---- */

/* Of the film, whatever a worker may have sent. */
static float sane(double x)
{
    return x <= (double)FLT_MAX ? (float)x : FLT_MAX;
}

static float effective(const struct film *f, size_t i, struct evidence_block e, uint32_t spp)
{
    if (f->blocks[i].sum > 0)
        return e.verdict == EVIDENCE_HEAVY ? -sane((double)e.neff) : sane((double)e.neff);
    const bool fine = e.verdict == EVIDENCE_TRUSTED || spp >= ADAPTIVE_DARK_SPP;
    return fine ? INFINITY : 0;
}

static struct adaptive_block look_at(const struct film *f, size_t i, struct evidence_block e,
                                     const struct adaptive_look *l)
{
    const struct estimate_part part = estimate_part(f, block_rect_of(f->window, i), l->least);
    const double high = part.high / slack;
    return (struct adaptive_block){sane(part.error2 > high ? part.error2 : high),
                                   effective(f, i, e, l->spp)};
}

/* Those that have been flagged in each round from the pilot to this one: none of them has stopped,
 * whatever the target. NULL: that is not to be asked yet, all are equal. */
static const bool *held(const struct adaptive *a, uint32_t spp, struct arena *arena)
{
    if (spp <= ADAPTIVE_PILOT_SPP)
        return NULL;
    bool *is_held = arena_new(arena, bool, a->count);
    for (size_t i = 0; i < a->count; i++) {
        is_held[i] = true;
        for (uint32_t r = PILOT; is_held[i] && r < a->rounds && a->spp[r] < spp; r++)
            is_held[i] = a->blocks[r * a->count + i].neff < 0;
    }
    return is_held;
}

struct adaptive_look adaptive_look(const struct film *f, uint32_t spp, const struct adaptive *a,
                                   struct arena *arena)
{
    assert(adaptive_judges(spp) && (spp <= ADAPTIVE_PILOT_SPP || a->rounds > PILOT));
    struct adaptive_look l = {spp, spp > ADAPTIVE_PILOT_SPP ? a->least : estimate_least(f),
                              arena_new(arena, struct adaptive_block, a->count)};
    const struct evidence e = evidence_among(f, held(a, spp, arena), arena);
    for (size_t i = 0; i < a->count; i++)
        l.blocks[i] = film_block_spp(f, i) == spp ? look_at(f, i, e.blocks[i], &l)
                                                  : (struct adaptive_block){.error2 = -1};
    return l;
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

/* d of the header. */
static double noise_around(const struct adaptive *a, size_t at)
{
    const struct adaptive_block *pilot = round_of(a, PILOT);
    const size_t columns = block_columns(a->window);
    const struct tile_rect r = block_around(a->window, at);
    double sum = 0, pixels = 0;
    for (uint32_t y = r.y_begin; y < r.y_end; y++)
        for (uint32_t x = r.x_begin; x < r.x_end; x++) {
            const size_t i = y * columns + x;
            sum += pixels_of(a, i) * (double)pilot[i].error2;
            pixels += pixels_of(a, i);
        }
    return sqrt(sum / pixels);
}

/* What the pilot says once and for all. */
static void settle(struct adaptive *a)
{
    const struct adaptive_block *pilot = round_of(a, PILOT);
    double lit = 0, sum = 0, square = 0;
    for (size_t i = 0; i < a->count; i++) {
        const double d = noise_around(a, i);
        lit += pilot[i].neff != 0 && isfinite(pilot[i].neff);
        sum += pixels_of(a, i) * d;
        square += pixels_of(a, i) * d * d;
        a->share[i] = sane(d);
    }
    const double shared = ADAPTIVE_LEAST_NEFF / (lit > 1 ? lit : 1);
    const double pixels = tile_rect_pixels(a->window), mean = sum / pixels;
    a->even = mean > 0 && square / pixels < worthwhile * mean * mean;
    a->need = shared > EVIDENCE_LEAST ? shared : EVIDENCE_LEAST;
    for (size_t i = 0; i < a->count; i++)
        a->share[i] = (double)a->share[i] < mean ? (float)((double)a->share[i] / mean) : 1;
}

/* t of the header. */
static double allowed(const struct adaptive *a, size_t i)
{
    return a->target * a->target * (double)a->share[i];
}

static bool has_evidence(const struct adaptive *a, uint32_t round, size_t i)
{
    const struct adaptive_block b = round_of(a, round)[i];
    return b.error2 >= 0 && (double)b.neff >= a->need;
}

static bool becomes_content(const struct adaptive *a, uint32_t round, size_t i)
{
    if (!has_evidence(a, round, i) || !has_evidence(a, round - 1, i))
        return false;
    const double t = allowed(a, i), fewer = (double)a->spp[round - 1] / a->spp[round];
    return (double)round_of(a, round)[i].error2 <= t &&
           (double)round_of(a, round - 1)[i].error2 * fewer <= foretold * t;
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
    if (!(a->target > 0) || round < PILOT || a->even)
        return;
    for (size_t i = 0; i < a->count; i++)
        if (a->content[i] == ADAPTIVE_NEVER && becomes_content(a, round, i))
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
    const double t = allowed(a, i), neff = fabs((double)b.neff);
    const double g =
        b.error2 < 0 ? DBL_MAX : (double)b.error2; /* not sampled: not one's own doing */
    to->error2 += pixels_of(a, i) * (content || g <= t ? t : g);
    if (isinf(neff))
        return;
    to->lit = true;
    to->effective += content || neff > a->need ? a->need : neff;
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
    /* All content, none with t below the target: the same number on both sides, but for rounding */
    const double most = a->target * a->target * tile_rect_pixels(a->window) * (1 + 1e-9);
    if (round < PILOT)
        return is_due_early(a, round, most);
    struct state now = {0};
    for (size_t i = 0; i < a->count; i++)
        judge(a, round, i, &now);
    return now.error2 <= most && (!now.lit || now.effective >= ADAPTIVE_LEAST_NEFF);
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
