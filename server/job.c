/* SPDX-License-Identifier: MIT */
#include "server/job.h"

#include <assert.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "server/round.h"

struct job *job_new(const struct store_job *row)
{
    struct job *j = arena_malloc(1, sizeof *j);
    j->row = *row;
    j->grid = tile_grid_make(row->crop, row->tile_px);
    j->tile_count = tile_count(&j->grid);
    j->pixels = tile_rect_pixels(row->crop);
    j->running_from_ms = -1;
    return j;
}

void job_free(struct job *j)
{
    job_close(j);
    convergence_release(&j->convergence);
    free(j);
}

/* ---- memory ---- */

/* The passes that the film's blocks have. */
static uint32_t passes_in(const struct film *f)
{
    uint32_t most = 0;
    for (size_t i = 0; i < tile_rect_pixels(f->window); i++)
        most = max_u32(most, f->spp[i]);
    return most ? tile_pass_count(most) : 0;
}

void job_open(struct job *j, struct film *film, struct adaptive *records, uint32_t rounds_judged)
{
    assert(!j->open);
    j->film = *film;
    j->adaptive = *records;
    *film = (struct film){0};
    *records = (struct adaptive){0};
    adaptive_aim(&j->adaptive, j->row.target.error);
    j->tiles = arena_malloc(j->tile_count, sizeof *j->tiles);
    const uint32_t passes = passes_in(&j->film), seen = max_u32(passes, rounds_judged + 1);
    uint32_t least = UINT32_MAX;
    for (uint32_t t = 0; t < j->tile_count; t++) {
        j->tiles[t].merged = round_passes_of(j, t, min_u32(seen, job_passes(j)));
        least = min_u32(least, j->tiles[t].merged);
    }
    j->rounds_done = least;
    for (uint32_t t = 0; t < j->tile_count; t++)
        j->tiles_ahead += j->tiles[t].merged > j->rounds_done;
    /* Those that begin again, for another target, were judged before. */
    j->rounds_judged = min_u32(rounds_judged, j->rounds_done);
    j->rounds_decided = max_u32(passes, 1);
    j->cursor_pass = j->rounds_done;
    j->open = true;
}

void job_close(struct job *j)
{
    if (!j->open)
        return;
    for (uint32_t t = 0; t < j->tile_count; t++)
        for (int i = 0; i < JOB_LOOKAHEAD; i++)
            free(j->tiles[t].slots[i].held);
    free(j->tiles);
    free(j->troubles);
    film_release(&j->film);
    adaptive_release(&j->adaptive);
    j->tiles = NULL;
    j->troubles = NULL;
    j->trouble_count = j->trouble_capacity = 0;
    j->rounds_done = j->tiles_ahead = j->rounds_judged = j->rounds_decided = 0;
    j->cursor_pass = j->cursor_tile = 0;
    j->held_bytes = 0;
    j->open = false;
}

uint64_t job_film_bytes(const struct job *j)
{
    struct film f = {.window = j->row.crop, .layers = j->row.layers};
    return film_bytes(&f) + (uint64_t)j->tile_count * sizeof *j->tiles;
}

/* ---- what it is ---- */

bool job_is_over(const struct job *j)
{
    switch (j->row.state) {
    case JOB_QUEUED:
    case JOB_RUNNING:
    case JOB_PAUSED:
        return false;
    case JOB_DONE:
    case JOB_FAILED:
    case JOB_CANCELLED:
        return true;
    }
    __builtin_unreachable();
}

uint32_t job_passes(const struct job *j)
{
    return tile_pass_count(j->row.target.spp);
}

int64_t job_elapsed_ms(const struct job *j, int64_t now_ms)
{
    return j->row.elapsed_ms + (j->running_from_ms >= 0 ? now_ms - j->running_from_ms : 0);
}

void job_touch(struct job *j)
{
    j->version++;
}

void job_clock(struct job *j, int64_t now_ms)
{
    j->row.elapsed_ms = job_elapsed_ms(j, now_ms);
    if (j->running_from_ms >= 0)
        j->running_from_ms = now_ms;
}

/* ---- transitions ---- */

void job_start(struct job *j, int64_t now_ms, int64_t unix_ms)
{
    assert(j->row.state == JOB_QUEUED);
    j->row.state = JOB_RUNNING;
    if (!j->row.started_unix_ms)
        j->row.started_unix_ms = unix_ms;
    j->running_from_ms = now_ms;
    job_touch(j);
}

void job_continue(struct job *j, const struct scene_target *target)
{
    assert(j->row.state == JOB_DONE && !j->open && !j->writing);
    j->row.state = JOB_QUEUED;
    j->row.target = *target;
    j->row.settled = false;
    j->row.finished_unix_ms = 0;
    *j->row.digest = 0;
    j->rate = (struct rate){0};
    j->finishing = j->reached = j->film_failed = false;
    j->retry_ms = 0;
    job_touch(j);
}

void job_pause(struct job *j, int64_t now_ms)
{
    assert(j->row.state == JOB_QUEUED || j->row.state == JOB_RUNNING);
    job_clock(j, now_ms);
    j->running_from_ms = -1;
    j->row.state = JOB_PAUSED;
    j->rate = (struct rate){0};
    job_touch(j);
}

/* One that never had a lease is queued again; also how a running job comes back after a restart. */
void job_resume(struct job *j, int64_t now_ms)
{
    assert(j->row.state == JOB_PAUSED || (j->row.state == JOB_RUNNING && j->running_from_ms < 0));
    j->row.state = j->row.started_unix_ms ? JOB_RUNNING : JOB_QUEUED;
    j->running_from_ms = j->row.started_unix_ms ? now_ms : -1;
    job_touch(j);
}

void job_end(struct job *j, enum job_state state, int64_t now_ms, int64_t unix_ms)
{
    assert(!job_is_over(j));
    assert(state == JOB_DONE || state == JOB_FAILED || state == JOB_CANCELLED);
    job_clock(j, now_ms);
    j->running_from_ms = -1;
    j->row.state = state;
    j->row.finished_unix_ms = unix_ms;
    job_touch(j);
}

/* ---- passes ---- */

bool job_in_window(const struct job *j, uint32_t tile, uint32_t pass)
{
    const uint32_t merged = j->tiles[tile].merged;
    return pass >= merged && pass - merged < JOB_LOOKAHEAD && pass < job_passes(j);
}

struct job_slot *job_slot(struct job *j, uint32_t tile, uint32_t pass)
{
    assert(job_in_window(j, tile, pass));
    return &j->tiles[tile].slots[pass % JOB_LOOKAHEAD];
}

void job_slot_ready(struct job *j, uint32_t tile, uint32_t pass)
{
    struct job_slot *s = job_slot(j, tile, pass);
    assert(s->state != SLOT_READY);
    free(s->held);
    *s = (struct job_slot){.state = SLOT_READY};
    if (pass < j->cursor_pass || (pass == j->cursor_pass && tile < j->cursor_tile)) {
        j->cursor_pass = pass;
        j->cursor_tile = tile;
    }
}

static struct job_trouble *trouble_find(struct job *j, uint32_t tile, uint32_t pass)
{
    for (uint32_t i = 0; i < j->trouble_count; i++)
        if (j->troubles[i].tile == tile && j->troubles[i].pass == pass)
            return &j->troubles[i];
    return NULL;
}

struct job_trouble *job_trouble_of(struct job *j, uint32_t tile, uint32_t pass)
{
    struct job_trouble *t = trouble_find(j, tile, pass);
    if (t)
        return t;
    if (j->trouble_count == j->trouble_capacity) {
        j->trouble_capacity = j->trouble_capacity ? 2 * j->trouble_capacity : 8;
        j->troubles = arena_realloc(j->troubles, j->trouble_capacity, sizeof *j->troubles);
    }
    t = &j->troubles[j->trouble_count++];
    *t = (struct job_trouble){.tile = tile, .pass = pass};
    return t;
}

void job_trouble_forget(struct job *j, uint32_t tile, uint32_t pass)
{
    struct job_trouble *t = trouble_find(j, tile, pass);
    if (t)
        *t = j->troubles[--j->trouble_count];
}

static bool give_up(struct job *j, uint32_t tile, uint32_t pass)
{
    j->row.failure.has_pass = tile != JOB_PLAN;
    j->row.failure.tile = tile;
    j->row.failure.pass = pass;
    return false;
}

static bool note_expiry(struct job *j, uint32_t tile, uint32_t pass)
{
    j->row.expired++;
    job_touch(j);
    struct job_trouble *t = job_trouble_of(j, tile, pass);
    if (++t->expiries < JOB_MAX_EXPIRIES)
        return true;
    snprintf(j->row.failure.reason, STORE_REASON,
             "the lease lapsed %u times: the pass may stop its workers", t->expiries);
    return give_up(j, tile, pass);
}

bool job_pass_expired(struct job *j, uint32_t tile, uint32_t pass)
{
    job_slot_ready(j, tile, pass);
    return note_expiry(j, tile, pass);
}

/* The reason was cut to fit: not in the middle of a character (UTF-8, RFC 3629). */
static void trim(char *text)
{
    size_t n = strlen(text), tail = 0;
    while (tail < n && tail < 3 && ((unsigned char)text[n - 1 - tail] & 0xc0) == 0x80)
        tail++;
    if (tail == n)
        return;
    const unsigned char lead = (unsigned char)text[n - 1 - tail];
    const size_t want = lead >= 0xf0 ? 3 : lead >= 0xe0 ? 2 : lead >= 0xc0 ? 1 : 0;
    if (tail < want)
        text[n - 1 - tail] = '\0';
}

static bool note_failure(struct job *j, struct job_trouble *t, uint32_t worker, const char *reason,
                         int64_t now_ms)
{
    job_touch(j);
    bool known = false;
    for (uint32_t i = 0; i < t->worker_count; i++)
        known |= t->workers[i] == worker;
    if (!known)
        t->workers[t->worker_count++] = worker;
    t->failures++;
    t->shun_until_ms = now_ms + JOB_SHUN_MS;
    if (t->worker_count < JOB_MAX_WORKERS && t->failures < JOB_MAX_FAILURES)
        return true;
    snprintf(j->row.failure.reason, STORE_REASON, "failed %u times on %u workers, last: %s",
             t->failures, t->worker_count, reason);
    trim(j->row.failure.reason);
    return give_up(j, t->tile, t->pass);
}

bool job_pass_failed(struct job *j, uint32_t tile, uint32_t pass, uint32_t worker,
                     const char *reason, int64_t now_ms)
{
    if (!note_failure(j, job_trouble_of(j, tile, pass), worker, reason, now_ms))
        return false;
    *job_slot(j, tile, pass) = (struct job_slot){.state = SLOT_SHUNNED};
    return true;
}

/* ---- the plan ---- */

bool job_wants_plan(const struct job *j)
{
    return j->row.method == STORE_METHOD_OPEN;
}

bool job_plan_may_try(const struct job *j, uint32_t worker, int64_t now_ms)
{
    if (j->plan_lease)
        return false;
    for (uint32_t i = 0; i < j->trouble_count; i++) {
        const struct job_trouble *t = &j->troubles[i];
        for (uint32_t w = 0; t->tile == JOB_PLAN && w < t->worker_count; w++)
            if (t->workers[w] == worker && now_ms < t->shun_until_ms)
                return false;
    }
    return true;
}

void job_plan_granted(struct job *j, uint64_t lease)
{
    assert(job_wants_plan(j) && !j->plan_lease);
    j->plan_lease = lease;
    j->lease_count++;
    j->row.granted++;
    job_touch(j);
}

void job_plan_back(struct job *j)
{
    j->plan_lease = 0;
    job_touch(j);
}

bool job_plan_expired(struct job *j)
{
    job_plan_back(j);
    return note_expiry(j, JOB_PLAN, 0);
}

bool job_plan_failed(struct job *j, uint32_t worker, const char *reason, int64_t now_ms)
{
    job_plan_back(j);
    return note_failure(j, job_trouble_of(j, JOB_PLAN, 0), worker, reason, now_ms);
}

void job_plan_made(struct job *j, enum plan_candidate_kind k)
{
    assert(job_wants_plan(j) && k < PLAN_REAL);
    j->row.method = STORE_METHOD_PLANNED + (uint32_t)k;
    job_trouble_forget(j, JOB_PLAN, 0);
    job_touch(j);
}

void job_fail_reason(struct job *j, const char *reason)
{
    j->row.failure = (struct store_failure){0};
    snprintf(j->row.failure.reason, STORE_REASON, "%s", reason);
    trim(j->row.failure.reason);
}
