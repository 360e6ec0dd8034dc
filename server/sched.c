/* SPDX-License-Identifier: MIT */
#include "server/sched.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "server/round.h"

/* ---- the list of jobs ---- */

static bool goes_before(const struct job *a, const struct job *b)
{
    if (a->row.priority != b->row.priority)
        return a->row.priority > b->row.priority;
    return a->row.number < b->row.number;
}

void sched_release(struct sched *s)
{
    free(s->jobs);
    *s = (struct sched){0};
}

void sched_add(struct sched *s, struct job *job)
{
    if (s->count == s->capacity) {
        s->capacity = s->capacity ? 2 * s->capacity : 16;
        s->jobs = arena_realloc(s->jobs, s->capacity, sizeof *s->jobs);
    }
    size_t at = s->count++;
    for (; at > 0 && goes_before(job, s->jobs[at - 1]); at--)
        s->jobs[at] = s->jobs[at - 1];
    s->jobs[at] = job;
}

void sched_remove(struct sched *s, struct job *job)
{
    size_t at = 0;
    while (s->jobs[at] != job) {
        at++;
        assert(at < s->count);
    }
    memmove(s->jobs + at, s->jobs + at + 1, (--s->count - at) * sizeof *s->jobs);
}

void sched_reorder(struct sched *s, struct job *job)
{
    sched_remove(s, job);
    sched_add(s, job);
}

/* ---- seconds: does another round fit? ---- */

enum decision { DECISION_WAIT, DECISION_GO, DECISION_SETTLED };

/* Samples per second. After a restart or a pause nothing is known but the mean so far, and with
 * nothing leased there is nothing to wait for. */
static double job_speed(const struct job *j, int64_t now_ms)
{
    const double rate = rate_per_second(&j->rate, now_ms);
    const int64_t elapsed_ms = job_elapsed_ms(j, now_ms);
    if (rate > 0 || j->lease_count || elapsed_ms <= 0)
        return rate;
    return (double)j->row.samples * 1000 / (double)elapsed_ms;
}

static void settle(struct job *j, uint32_t spp)
{
    j->row.target.spp = spp;
    j->row.settled = true;
    job_touch(j);
}

/* Called when the first lease of round `pass` would be granted. The work that is out comes
 * first; what the rest of the time allows at the rate so far is cut to a multiple of the
 * replicates, so that every pixel keeps a fair error estimate. */
static enum decision round_decide(struct job *j, uint32_t pass, int64_t now_ms)
{
    if (pass < j->rounds_decided)
        return DECISION_GO;
    const struct tile_pass range = tile_pass_of(pass, j->row.target.spp);
    const struct tile_pass before = tile_pass_of(pass - 1, j->row.target.spp);
    const double pixels = (double)round_pixels(j, pass), owed = (double)round_owed(j, pass);
    const double rate = job_speed(j, now_ms);
    /* Half of the round before tells how fast we are. Without a pixel that wants more the job is
     * about to end. */
    if (rate <= 0 || owed > pixels * (before.s_end - before.s_begin) / 2 || !(pixels > 0))
        return DECISION_WAIT;
    const double left_s = j->row.target.seconds - (double)job_elapsed_ms(j, now_ms) / 1000;
    const double fit = floor((rate * left_s - owed) / pixels);
    if (fit >= range.s_end - range.s_begin) {
        j->rounds_decided = pass + 1;
        return DECISION_GO;
    }
    const uint32_t more = fit > 0 ? (uint32_t)fit / FILM_REPLICATES * FILM_REPLICATES : 0;
    settle(j, range.s_begin + more);
    return DECISION_SETTLED;
}

bool sched_time_is_up(struct job *j, int64_t now_ms)
{
    const bool timed = j->row.target.seconds > 0 && !j->row.settled && j->open;
    if (!timed || j->rounds_done < j->rounds_decided || j->rounds_done == job_passes(j) ||
        (double)job_elapsed_ms(j, now_ms) < j->row.target.seconds * 1000)
        return false;
    settle(j, j->row.spp_done);
    return true;
}

/* ---- inside a job ---- */

static uint32_t round_limit(const struct sched *s,
                            const struct job *j) /* passes below may be leased */
{
    uint32_t ahead = j->row.target.error > 0 ? 2 : JOB_LOOKAHEAD;
    if (j->held_bytes >= s->held_limit_bytes)
        ahead = 1;
    return min_u32(j->rounds_done + ahead, job_passes(j));
}

static bool find_shunned(struct job *j, uint32_t worker, int64_t now_ms, struct sched_pick *pick)
{
    for (uint32_t i = 0; i < j->trouble_count; i++) {
        const struct job_trouble *t = &j->troubles[i];
        if (job_slot(j, t->tile, t->pass)->state != SLOT_SHUNNED ||
            !round_lacks(j, t->tile, t->pass))
            continue;
        bool tried = false;
        for (uint32_t w = 0; w < t->worker_count; w++)
            tried |= t->workers[w] == worker;
        if (tried && now_ms < t->shun_until_ms)
            continue;
        *pick = (struct sched_pick){j, t->tile, t->pass};
        return true;
    }
    return false;
}

static bool find_ready(struct job *j, uint32_t limit, struct sched_pick *pick)
{
    for (; j->cursor_pass < limit; j->cursor_pass++, j->cursor_tile = 0)
        for (; j->cursor_tile < j->tile_count; j->cursor_tile++) {
            const uint32_t tile = j->cursor_tile, pass = j->cursor_pass;
            if (job_in_window(j, tile, pass) && job_slot(j, tile, pass)->state == SLOT_READY &&
                round_lacks(j, tile, pass)) {
                *pick = (struct sched_pick){j, tile, pass};
                return true;
            }
        }
    return false;
}

static enum sched_result job_next(const struct sched *s, struct job *j, uint32_t worker,
                                  int64_t now_ms, struct sched_pick *pick)
{
    *pick = (struct sched_pick){.job = j};
    if (!j->open)
        return j->starved ? SCHED_NOTHING : SCHED_OPEN;
    if (job_wants_plan(j))
        return job_plan_may_try(j, worker, now_ms) ? SCHED_PLAN : SCHED_NOTHING;
    if (find_shunned(j, worker, now_ms, pick))
        return SCHED_PASS;
    const bool timed = j->row.target.seconds > 0 && !j->row.settled;
    for (;;) {
        const uint32_t most = round_limit(s, j);
        if (find_ready(j, timed ? min_u32(most, j->rounds_decided) : most, pick))
            return SCHED_PASS;
        if (!timed || j->rounds_decided >= most)
            return SCHED_NOTHING;
        switch (round_decide(j, j->rounds_decided, now_ms)) {
        case DECISION_WAIT:
            return SCHED_NOTHING;
        case DECISION_SETTLED:
            return SCHED_SETTLE;
        case DECISION_GO:
            break;
        }
    }
}

enum sched_result sched_next(struct sched *s, uint32_t worker, int64_t now_ms,
                             struct sched_pick *pick)
{
    for (size_t i = 0; i < s->count; i++) {
        struct job *j = s->jobs[i];
        if (j->row.state == JOB_PAUSED || j->finishing || j->reached)
            continue;
        const enum sched_result r = job_next(s, j, worker, now_ms, pick);
        if (r != SCHED_NOTHING)
            return r;
    }
    return SCHED_NOTHING;
}

void sched_grant(struct job *j, uint32_t tile, uint32_t pass, uint64_t lease)
{
    struct job_slot *s = job_slot(j, tile, pass);
    assert(s->state == SLOT_READY || s->state == SLOT_SHUNNED);
    const struct block_set blocks = round_blocks(j, tile, pass);
    *s = (struct job_slot){
        .state = SLOT_LEASED, .lease = lease, .blocks = (uint32_t)block_set_count(&blocks)};
    j->lease_count++;
    j->row.granted++;
    job_touch(j);
}
