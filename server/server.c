/* SPDX-License-Identifier: MIT */
#include "server/server.h"
#include "server/report.h"

#include <assert.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "common/clock.h"
#include "server/api.h"
#include "server/checkpoint.h"
#include "server/feed.h"
#include "server/output.h"
#include "server/problem.h"
#include "server/round.h"

enum {
    INBOX =
        HTTP_MAX_CONNECTIONS + 2 * 64, /* every connection and task at once: pushing never waits */
    TICK_MS = 1000,
    TURN_MS = 100, /* while a job is open: output may fall due */
    DRAIN_MS = 20,
    BATCH = 64, /* messages between two looks at the clock */
};

void server_random(void *data, size_t bytes)
{
    const int fd = open("/dev/urandom", O_RDONLY | O_CLOEXEC);
    const bool ok = fd >= 0 && read(fd, data, bytes) == (ssize_t)bytes;
    assert(ok);
    (void)ok;
    close(fd);
}

void server_job_directory(const struct server *s, const struct job *j, char *path, size_t bytes)
{
    snprintf(path, bytes, "%s/jobs/%016llx", s->config->state_dir, (unsigned long long)j->row.id);
}

/* ---- jobs ---- */

static size_t id_place(const struct server *s, uint64_t id)
{
    size_t begin = 0, end = s->job_count;
    while (begin < end) {
        const size_t mid = (begin + end) / 2;
        if (s->by_id[mid]->row.id < id)
            begin = mid + 1;
        else
            end = mid;
    }
    return begin;
}

struct job *server_job_find(const struct server *s, uint64_t id)
{
    const size_t at = id_place(s, id);
    return at < s->job_count && s->by_id[at]->row.id == id ? s->by_id[at] : NULL;
}

struct job *server_job_add(struct server *s, const struct store_job *stored)
{
    if (s->job_count == s->job_capacity) {
        s->job_capacity = s->job_capacity ? 2 * s->job_capacity : 64;
        s->jobs = arena_realloc(s->jobs, s->job_capacity, sizeof *s->jobs);
        s->by_id = arena_realloc(s->by_id, s->job_capacity, sizeof *s->by_id);
    }
    struct job *j = job_new(stored);
    const size_t at = id_place(s, j->row.id);
    memmove(s->by_id + at + 1, s->by_id + at, (s->job_count - at) * sizeof *s->by_id);
    s->by_id[at] = j;
    s->jobs[s->job_count++] = j;
    if (!job_is_over(j))
        sched_add(&s->sched, j);
    s->news = true;
    return j;
}

bool server_job_save(struct server *s, struct job *j)
{
    struct err err;
    job_clock(j, s->now_ms);
    j->unsaved = !store_job_save(s->store, &j->row, &err);
    if (j->unsaved)
        log_error("save job=%016llx %s", (unsigned long long)j->row.id, err.text);
    return !j->unsaved;
}

void server_lease_end(struct server *s, struct lease *l)
{
    l->job->lease_count--;
    l->worker->leases--;
    job_touch(l->job);
    lease_drop(s->leases, l);
}

static bool lease_is_good(const struct lease *l)
{
    if (l->tile == JOB_PLAN)
        return true;
    if (!job_in_window(l->job, l->tile, l->pass))
        return false;
    const struct job_slot *slot = job_slot(l->job, l->tile, l->pass);
    return slot->state == SLOT_LEASED && slot->lease == l->id;
}

void server_leases_end(struct server *s, const struct job *j, bool all)
{
    if (!j->lease_count)
        return;
    struct lease **mine = arena_malloc(j->lease_count, sizeof(struct lease *));
    size_t count = 0;
    for (size_t i = 0; i < lease_count(s->leases); i++)
        if (lease_at(s->leases, i)->job == j)
            mine[count++] = lease_at(s->leases, i);
    assert(count == j->lease_count);
    for (size_t i = 0; i < count; i++)
        if (all || !lease_is_good(mine[i]))
            server_lease_end(s, mine[i]);
    free(mine);
}

void server_job_end(struct server *s, struct job *j, enum job_state state)
{
    job_end(j, state, s->now_ms, clock_unix_ms());
    server_leases_end(s, j, true);
    sched_remove(&s->sched, j);
    convergence_release(&j->convergence);
    if (j->open)
        s->film_bytes -= job_film_bytes(j);
    if (state == JOB_DONE)
        job_close(j);
    else
        output_last(s, j);
    for (size_t i = 0; i < s->sched.count; i++)
        s->sched.jobs[i]->starved = false;
    s->news = true;
    server_job_save(s, j);
    log_info("job=%016llx state=%s spp=%u samples=%llu elapsed_ms=%lld%s%s",
             (unsigned long long)j->row.id, store_state_name(state), j->row.spp_done,
             (unsigned long long)j->row.samples, (long long)j->row.elapsed_ms,
             *j->row.failure.reason ? " reason=" : "", j->row.failure.reason);
}

/* ---- films ---- */

static void counters_reset(struct store_job *row)
{
    row->samples = row->passes_done = row->cpu_us = row->invalid_count = 0;
    row->spp_done = row->key_count = 0;
    row->error = -1;
    row->report = report_none();
}

static void film_load(struct server *s, struct job *j)
{
    struct checkpoint c = {.row = j->row, .tile_count = j->tile_count};
    struct err err;
    char path[DISK_PATH];
    server_job_directory(s, j, path, sizeof path - 8);
    strcat(path, "/film");
    const bool anew = !j->row.samples && j->row.image_version; /* continued, but not from there */
    if (!anew && checkpoint_read(&c, path, &err)) {
        c.row.elapsed_ms = max_i64(c.row.elapsed_ms, j->row.elapsed_ms);
        j->row = c.row;
        job_open(j, &c.film, &c.adaptive, c.rounds_judged);
        j->row.spp_done = round_spp(j);
        j->film_samples = j->row.samples;
        log_info("film job=%016llx recovered samples=%llu", (unsigned long long)j->row.id,
                 (unsigned long long)j->row.samples);
        return;
    }
    if (anew)
        unlink(path); /* nor may it be taken later, by a row that counts the new samples */
    if (!anew && (err.code != ERR_NOT_FOUND || j->row.samples))
        log_warn("film job=%016llx starts from zero: %s", (unsigned long long)j->row.id, err.text);
    counters_reset(&j->row);
    film_init(&c.film, j->row.crop);
    film_add_layers(&c.film, j->row.layers);
    adaptive_init(&c.adaptive, j->row.crop);
    job_open(j, &c.film, &c.adaptive, 0);
}

bool server_job_open(struct server *s, struct job *j)
{
    assert(!j->open && !job_is_over(j));
    const uint64_t bytes = job_film_bytes(j);
    j->starved = s->film_bytes + bytes > s->config->memory_bytes;
    if (j->starved)
        return false;
    film_load(s, j);
    s->film_bytes += bytes;
    j->next_film_ms = s->now_ms + s->config->checkpoint_ms;
    j->next_image_ms = s->now_ms;
    job_touch(j);
    return true;
}

/* Whether a job with the target would have come by the very film that this one has in the end: the
 * last pass ends where passes of any job do, and no judgement was due before that it would not have
 * passed. */
static bool film_is_on_the_way(const struct job *j, const struct scene_target *t)
{
    const struct store_job *row = &j->row;
    const uint32_t last = tile_pass_count(row->spp_done) - 1;
    const bool judged = t->error <= 0 || (row->target.error > 0 && t->error <= row->target.error);
    return judged && tile_pass_of(last, SCENE_MAX_SPP).s_end == row->spp_done;
}

bool server_job_continue(struct server *s, struct job *j, const struct scene_target *t,
                         struct err *err)
{
    const struct store_job before = j->row;
    if (!film_is_on_the_way(j, t))
        counters_reset(&j->row);
    if (!convergence_load(&j->convergence, s->store, j->row.number, err))
        goto failed;
    job_continue(j, t);
    if (!server_job_save(s, j)) {
        err_set(err, ERR_IO, "the change is not on disk");
        goto failed;
    }
    j->film_samples = j->image_samples = 0;
    sched_add(&s->sched, j);
    s->news = true;
    log_info("job=%016llx goes on from spp=%u", (unsigned long long)j->row.id, j->row.spp_done);
    return true;
failed:
    j->row = before;
    convergence_release(&j->convergence);
    return false;
}

/* ---- opening ---- */

static void recover_row(void *context, const struct store_job *row)
{
    struct server *s = context;
    struct job *j = server_job_add(s, row);
    if (row->state == JOB_RUNNING)
        job_resume(j, s->now_ms);
}

static bool recover_curves(struct server *s, struct err *err)
{
    for (size_t i = 0; i < s->sched.count; i++) {
        struct job *j = s->sched.jobs[i];
        if (!convergence_load(&j->convergence, s->store, j->row.number, err))
            return false;
    }
    return true;
}

static bool recover(struct server *s, struct err *err)
{
    if (!store_jobs(s->store, recover_row, s, err) || !recover_curves(s, err))
        return false;
    for (size_t i = 0; i < s->sched.count; i++) {
        struct job *j = s->sched.jobs[i];
        if (j->row.started_unix_ms)
            server_job_open(s, j);
    }
    log_info("recovered jobs=%zu active=%zu", s->job_count, s->sched.count);
    return true;
}

static bool state_open(struct server *s, struct err *err)
{
    const char *dir = s->config->state_dir;
    char path[DISK_PATH];
    if (strlen(dir) > DISK_PATH / 2)
        return err_set(err, ERR_INPUT, "--state: path of %zu characters: expected at most %d",
                       strlen(dir), DISK_PATH / 2);
    snprintf(path, sizeof path, "%s/jobs", dir);
    if (!disk_directory(path, err))
        return false;
    snprintf(path, sizeof path, "%s/lock", dir);
    if (!disk_lock(path, err) || !asset_open_store(dir, err))
        return false;
    snprintf(path, sizeof path, "%s/smalti.db", dir);
    s->store = store_open(path, err);
    return s->store != NULL;
}

static bool announce(const struct server *s, struct err *err)
{
    struct disk_file f;
    char text[128];
    const bool six = strchr(s->config->listen, ':') != NULL;
    const int n = snprintf(text, sizeof text, "http://%s%s%s:%u\n", six ? "[" : "",
                           s->config->listen, six ? "]" : "", http_port(s->http));
    log_info("listening at %.*s", n - 1, text);
    if (!s->config->announce)
        return true;
    if (!disk_create(&f, s->config->announce, err))
        return false;
    if (!disk_write(&f, text, (size_t)n, err)) {
        disk_abort(&f);
        return false;
    }
    return disk_commit(&f, err);
}

static bool start(struct server *s, struct err *err)
{
    s->writer = writer_start(s->inbox);
    if (!s->writer)
        return err_set(err, ERR_IO, "cannot start a thread");
    const struct http_setup setup = {s->config, api_routes, api_route_count, s->inbox};
    s->http = http_start(&setup, err);
    if (s->http && announce(s, err))
        return true;
    return false;
}

bool server_open(struct server *s, const struct config *config, struct err *err)
{
    *s = (struct server){.config = config, .now_ms = clock_ms()};
    s->last_waiter = &s->first_waiter;
    s->sched.held_limit_bytes = (uint64_t)256 << 20;
    server_random(&s->nonce, sizeof s->nonce);
    s->inbox = queue_new(INBOX);
    s->leases = lease_table_new(s->nonce);
    farm_init(&s->farm, config->lease_ttl_ms);
    if (state_open(s, err) && recover(s, err) && start(s, err))
        return true;
    server_close(s);
    return false;
}

/* ---- the loop ---- */

static void answer(struct server *s, struct exchange *x)
{
    struct request *rq = http_request(x);
    struct reply *re = http_reply(x);
    if (s->stopping)
        problem_reply(rq, re, 503, "shutting down");
    else
        rq->route->handle(s, rq, re);
    if (re->parked)
        return;
    assert(re->status);
    http_answer(x);
}

static void receive(struct server *s, struct message m)
{
    switch (m.kind) {
    case MESSAGE_REQUEST:
        answer(s, m.data);
        return;
    case MESSAGE_WRITTEN:
        output_written(s, m.data);
        return;
    case MESSAGE_STOP:
        log_info("stopping");
        s->stopping = true;
        return;
    case MESSAGE_WRITE:
        break;
    }
    __builtin_unreachable();
}

static int64_t turn_end_ms(const struct server *s)
{
    if (s->stopping)
        return s->now_ms + DRAIN_MS;
    int64_t until = s->next_tick_ms;
    until = min_i64(until, lease_next_deadline(s->leases));
    until = min_i64(until, feed_next_deadline(s));
    for (size_t i = 0; i < s->sched.count; i++)
        if (s->sched.jobs[i]->open)
            return min_i64(until, s->now_ms + TURN_MS);
    return until;
}

static void receive_some(struct server *s)
{
    struct message m;
    int64_t until = turn_end_ms(s);
    for (int i = 0; i < BATCH && queue_pop(s->inbox, &m, until); i++) {
        s->now_ms = clock_ms();
        receive(s, m);
        until = 0; /* what is there already, without waiting */
    }
    s->now_ms = clock_ms();
}

static void tick(struct server *s)
{
    if (s->now_ms < s->next_tick_ms)
        return;
    s->next_tick_ms = s->now_ms + TICK_MS;
    http_reap(s->http, s->now_ms);
    farm_forget(&s->farm, s->now_ms);
    for (size_t i = 0; i < s->job_count; i++)
        if (s->jobs[i]->unsaved)
            server_job_save(s, s->jobs[i]);
    for (size_t i = 0; i < s->sched.count; i++)
        if (sched_time_is_up(s->sched.jobs[i], s->now_ms))
            server_job_save(s, s->sched.jobs[i]);
    s->news = true; /* what depends on time alone */
}

/* Everyone is answered and every film is on disk. */
static void drain(struct server *s)
{
    feed_release(s);
    http_close(s->http);
    while (!http_is_quiet(s->http) || !output_is_settled(s)) {
        receive_some(s);
        output_turn(s);
    }
}

void server_loop(struct server *s)
{
    while (!s->stopping) {
        receive_some(s);
        tick(s);
        feed_turn(s);
        output_turn(s);
    }
    drain(s);
    for (size_t i = 0; i < s->sched.count; i++)
        server_job_save(s, s->sched.jobs[i]);
    log_info("stopped");
}

void server_close(struct server *s)
{
    s->stopping = true;
    if (s->http) {
        drain(s);
        http_stop(s->http);
    }
    if (s->writer)
        writer_stop(s->writer);
    for (size_t i = 0; i < s->job_count; i++)
        job_free(s->jobs[i]);
    free(s->jobs);
    free(s->by_id);
    sched_release(&s->sched);
    lease_table_free(s->leases);
    farm_release(&s->farm);
    queue_free(s->inbox);
    if (s->store)
        store_close(s->store);
}
