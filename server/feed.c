/* JSON: body_parse's object is owned by the handler and released before it returns; strings taken
 * from it are borrowed until then. SPDX-License-Identifier: MIT */
#include "server/feed.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <jansson.h>

#include "server/body.h"
#include "server/grant.h"
#include "server/merge.h"
#include "server/problem.h"

enum { MAX_WAIT_MS = 25000, MAX_THREADS = 65536 };

struct waiter {
    struct waiter *next;
    struct exchange *exchange;
    struct worker *worker;
    uint32_t want;
    int64_t deadline_ms;
};

/* ---- POST /v1/leases ---- */

struct lease_call {
    const char *worker, *version;
    json_int_t threads, want, wait_ms;
};

static bool call_read(json_t *root, struct lease_call *c, struct err *err)
{
    json_error_t e;
    if (json_unpack_ex(root, &e, JSON_STRICT, "{s:s, s:I, s:s, s:I, s?I}", "worker", &c->worker,
                       "threads", &c->threads, "version", &c->version, "want", &c->want, "wait_ms",
                       &c->wait_ms) != 0)
        return err_set(err, ERR_INPUT, "%s", e.text);
    if (!farm_name_is_sane(c->worker))
        return err_set(err, ERR_INPUT, "worker: expected 1 to 64 characters of A-Z a-z 0-9 . _ -");
    if (c->threads < 1 || c->threads > MAX_THREADS)
        return err_set(err, ERR_INPUT, "threads: expected 1 to %d, got %lld", MAX_THREADS,
                       (long long)c->threads);
    if (c->want < 1 || c->want > GRANT_MAX_WANT)
        return err_set(err, ERR_INPUT, "want: expected 1 to %d, got %lld", GRANT_MAX_WANT,
                       (long long)c->want);
    if (c->wait_ms < 0 || c->wait_ms > MAX_WAIT_MS)
        return err_set(err, ERR_INPUT, "wait_ms: expected 0 to %d, got %lld", MAX_WAIT_MS,
                       (long long)c->wait_ms);
    if (strcmp(c->version, SMALTI_VERSION) != 0)
        return err_set(err, ERR_CONFLICT,
                       "version: this coordinator is %s, the worker %.20s: images could differ",
                       SMALTI_VERSION, c->version);
    return true;
}

static void park(struct server *s, const struct request *rq, struct reply *re, struct worker *w,
                 const struct lease_call *c)
{
    struct waiter *p = arena_malloc(1, sizeof *p);
    p->exchange = rq->exchange;
    p->worker = w;
    p->want = (uint32_t)c->want;
    p->deadline_ms = s->now_ms + c->wait_ms;
    w->parked++;
    *s->last_waiter = p;
    s->last_waiter = &p->next;
    re->parked = true;
}

static void lease_or_park(struct server *s, const struct request *rq, struct reply *re,
                          const struct lease_call *c)
{
    struct worker *w = farm_call(&s->farm, c->worker, s->now_ms);
    if (!w) {
        problem_reply(rq, re, 503, "too many workers: expected at most %d", FARM_MAX_WORKERS);
        return;
    }
    w->threads = (uint32_t)c->threads;
    size_t granted;
    json_t *root = grant_leases(s, w, (uint32_t)c->want, &granted);
    if (granted || c->wait_ms == 0 || w->state == WORKER_DRAINING || !rq->exchange) {
        body_reply(rq, re, 200, root);
        return;
    }
    json_decref(root);
    park(s, rq, re, w, c);
}

void feed_lease(struct server *s, const struct request *rq, struct reply *re)
{
    json_t *root = body_parse(rq, re);
    if (!root)
        return;
    struct lease_call call = {0};
    struct err err;
    if (call_read(root, &call, &err))
        lease_or_park(s, rq, re, &call);
    else
        problem_from_err(rq, re, &err);
    json_decref(root);
}

/* ---- PUT /v1/leases/ID ---- */

void feed_prepare_delivery(struct request *rq, struct reply *re)
{
    struct err err;
    struct wire_samples *w = arena_new(rq->arena, struct wire_samples, 1);
    if (!wire_decode(w, rq->body.data ? (const void *)rq->body.data : "", rq->body.size, rq->arena,
                     &err)) {
        problem_from_err(rq, re, &err);
        return;
    }
    rq->samples = w;
    buf_release(&rq->body);
}

static bool lease_id(const struct request *rq, struct reply *re, uint64_t *id)
{
    const char *text = rq->part[0];
    if (strlen(text) != 16 || strspn(text, "0123456789abcdef") != 16) {
        problem_reply(rq, re, 400, "lease: expected 16 hex digits, got '%.40s'", text);
        return false;
    }
    *id = strtoull(text, NULL, 16);
    return true;
}

/* The job, if the payload may be merged into it now. */
static struct job *receiver_of(struct server *s, const struct wire_samples *w, uint64_t id,
                               struct err *err)
{
    struct job *j = server_job_find(s, w->job);
    const struct lease *l = lease_find(s->leases, id);
    if (!j)
        err_set(err, ERR_NOT_FOUND, "no such job: %016llx", (unsigned long long)w->job);
    else if (l && (l->job != j || l->tile != w->tile || l->pass != w->pass))
        err_set(err, ERR_PROTOCOL, "payload of tile %u, pass %u: the lease is for tile %u, pass %u",
                w->tile, w->pass, l->tile, l->pass);
    else if (job_wants_plan(j))
        err_set(err, ERR_CONFLICT, "the job has no plan yet");
    else if (job_is_over(j))
        err_set(err, ERR_CONFLICT, "the job is %s", store_state_name(j->row.state));
    else if (!j->open && !server_job_open(s, j))
        err_set(err, ERR_CONFLICT, "the job waits for memory");
    else if (merge_check(j, w, err))
        return j;
    return NULL;
}

/* The lease on this pass, whoever holds it; 0: none. */
static uint64_t lease_on(struct job *j, const struct wire_samples *w)
{
    if (!job_in_window(j, w->tile, w->pass))
        return 0;
    const struct job_slot *slot = job_slot(j, w->tile, w->pass);
    return slot->state == SLOT_LEASED ? slot->lease : 0;
}

static void reply_delivered(struct server *s, const struct request *rq, struct reply *re,
                            struct worker *w, uint32_t want, enum merge_result r)
{
    size_t granted;
    json_t *root = grant_leases(s, w, want, &granted);
    json_object_set_new(root, "result", json_string(merge_result_name(r)));
    body_reply(rq, re, 200, root);
}

static bool delivery_read(const struct request *rq, struct reply *re, uint64_t *id, int64_t *want)
{
    struct err err;
    const char *name = route_query(rq, "worker");
    if (!lease_id(rq, re, id))
        return false;
    if (!name || !farm_name_is_sane(name))
        err_set(&err, ERR_INPUT, "worker: expected 1 to 64 characters of A-Z a-z 0-9 . _ -");
    else if (route_query_int(rq, "want", 0, GRANT_MAX_WANT, 0, want, &err))
        return true;
    problem_from_err(rq, re, &err);
    return false;
}

void feed_deliver(struct server *s, const struct request *rq, struct reply *re)
{
    uint64_t id;
    int64_t want;
    struct err err;
    if (!delivery_read(rq, re, &id, &want))
        return;
    struct worker *w = farm_call(&s->farm, route_query(rq, "worker"), s->now_ms);
    if (!w) {
        problem_reply(rq, re, 503, "too many workers: expected at most %d", FARM_MAX_WORKERS);
        return;
    }
    struct job *j = receiver_of(s, rq->samples, id, &err);
    if (!j) {
        problem_from_err(rq, re, &err);
        return;
    }
    const uint64_t out = lease_on(j, rq->samples);
    const enum merge_result r = merge_deliver(j, rq->samples, s->now_ms);
    if (out && (r == MERGE_MERGED || r == MERGE_HELD)) /* its holder need not go on */
        server_lease_end(s, lease_find(s->leases, out));
    s->news = true;
    w->delivered++;
    w->cpu_us += rq->samples->cpu_us;
    log_debug("deliver job=%016llx tile=%u pass=%u worker=%s result=%s",
              (unsigned long long)j->row.id, rq->samples->tile, rq->samples->pass, w->name,
              merge_result_name(r));
    if (r == MERGE_UNWANTED)
        problem_reply(rq, re, 409, "pass %u of tile %u comes too %s", rq->samples->pass,
                      rq->samples->tile, j->finishing || j->reached ? "late" : "early");
    else
        reply_delivered(s, rq, re, w, (uint32_t)want, r);
}

/* ---- PUT /v1/leases/ID/plan ---- */

/* A plan's method; the rest of it is for people to read, and is passed on as it came. */
static bool plan_read(json_t *root, enum plan_candidate_kind *k, struct err *err)
{
    const char *integrator, *strategy;
    int version;
    json_error_t e;
    if (json_unpack_ex(root, &e, 0, "{s:i, s:{s:s, s:s}}", "version", &version, "method",
                       "integrator", &integrator, "strategy", &strategy) != 0)
        return err_set(err, ERR_INPUT, "%s", e.text);
    if (version != PLAN_VERSION)
        return err_set(err, ERR_INPUT, "version: expected %d, got %d", PLAN_VERSION, version);
    *k = plan_find(integrator, strategy);
    return *k < PLAN_REAL || err_set(err, ERR_INPUT, "method: there is no \"%.20s\", \"%.20s\"",
                                     integrator, strategy);
}

/* The file first, the row second: a row never claims a plan that is not on disk. */
static bool plan_keep(struct server *s, struct job *j, const struct buf *text,
                      enum plan_candidate_kind k, struct err *err)
{
    char directory[DISK_PATH - 32], path[DISK_PATH];
    struct disk_file f;
    server_job_directory(s, j, directory, sizeof directory);
    snprintf(path, sizeof path, "%s/plan.json", directory);
    if (!disk_directory(directory, err) || !disk_create(&f, path, err))
        return false;
    if (!disk_write(&f, text->data, text->size, err)) {
        disk_abort(&f);
        return false;
    }
    if (!disk_commit(&f, err))
        return false;
    job_plan_made(j, k);
    if (server_job_save(s, j))
        return true;
    j->row.method = STORE_METHOD_OPEN;
    return err_set(err, ERR_IO, "the plan is not on disk yet");
}

static void plan_deliver(struct server *s, const struct request *rq, struct reply *re,
                         struct lease *l, uint32_t want)
{
    struct err err;
    enum plan_candidate_kind k = PLAN_REAL;
    struct job *j = l->job;
    struct worker *w = l->worker;
    json_t *root = body_parse(rq, re);
    if (!root)
        return;
    const bool good = plan_read(root, &k, &err) && plan_keep(s, j, &rq->body, k, &err);
    json_decref(root);
    if (!good) {
        problem_from_err(rq, re, &err);
        return;
    }
    job_plan_back(j);
    server_lease_end(s, l);
    s->news = true;
    w->delivered++;
    const struct plan_names n = plan_names(k);
    log_info("plan job=%016llx integrator=%s strategy=%s worker=%s", (unsigned long long)j->row.id,
             n.integrator, n.strategy, w->name);
    size_t granted;
    root = grant_leases(s, w, want, &granted);
    json_object_set_new(root, "result", json_string("planned"));
    body_reply(rq, re, 200, root);
}

void feed_plan(struct server *s, const struct request *rq, struct reply *re)
{
    uint64_t id;
    int64_t want;
    if (!delivery_read(rq, re, &id, &want))
        return;
    struct lease *l = lease_find(s->leases, id);
    if (!l)
        problem_reply(rq, re, 404, "no such lease: %s", rq->part[0]);
    else if (l->tile != JOB_PLAN)
        problem_reply(rq, re, 400, "the lease is for tile %u, pass %u, not for a plan", l->tile,
                      l->pass);
    else
        plan_deliver(s, rq, re, l, (uint32_t)want);
}

/* ---- renew, give back ---- */

static struct lease *held_lease(struct server *s, const struct request *rq, struct reply *re)
{
    uint64_t id;
    if (!lease_id(rq, re, &id))
        return NULL;
    struct lease *l = lease_find(s->leases, id);
    if (!l)
        problem_reply(rq, re, 404, "no such lease: %s", rq->part[0]);
    else
        l->worker->seen_ms = s->now_ms;
    return l;
}

void feed_renew(struct server *s, const struct request *rq, struct reply *re)
{
    struct lease *l = held_lease(s, rq, re);
    if (!l)
        return;
    lease_renew(s->leases, l, s->now_ms + s->config->lease_ttl_ms);
    body_reply(rq, re, 200, json_pack("{s:I}", "ttl_ms", (json_int_t)s->config->lease_ttl_ms));
}

static bool give_back(struct server *s, struct lease *l, json_t *root, struct err *err)
{
    const char *reason = NULL, *kind = NULL;
    json_error_t e;
    if (root &&
        json_unpack_ex(root, &e, JSON_STRICT, "{s:s, s:s}", "reason", &reason, "kind", &kind) != 0)
        return err_set(err, ERR_INPUT, "%s", e.text);
    if (!root)
        grant_returned(s, l);
    else if (!strcmp(kind, "worker"))
        grant_failed(s, l, reason);
    else if (!strcmp(kind, "input"))
        grant_job_failed(s, l->job, reason);
    else
        return err_set(err, ERR_INPUT, "kind: expected \"worker\" or \"input\", got \"%.20s\"",
                       kind);
    return true;
}

void feed_return(struct server *s, const struct request *rq, struct reply *re)
{
    struct lease *l = held_lease(s, rq, re);
    if (!l)
        return;
    json_t *root = NULL;
    if (rq->body.size && !(root = body_parse(rq, re)))
        return;
    struct err err;
    if (give_back(s, l, root, &err))
        re->status = 204;
    else
        problem_from_err(rq, re, &err);
    json_decref(root);
}

/* ---- workers ---- */

static json_t *worker_json(const struct server *s, const struct worker *w)
{
    const char *state = farm_is_lost(&s->farm, w, s->now_ms) ? "lost"
                        : w->state == WORKER_DRAINING        ? "draining"
                                                             : "active";
    return json_pack("{s:s, s:I, s:s, s:I, s:I, s:f, s:I}", "name", w->name, "threads",
                     (json_int_t)w->threads, "state", state, "leases", (json_int_t)w->leases,
                     "delivered", (json_int_t)w->delivered, "cpu_seconds", (double)w->cpu_us / 1e6,
                     "seen_ms_ago", (json_int_t)(s->now_ms - w->seen_ms));
}

void feed_workers(struct server *s, const struct request *rq, struct reply *re)
{
    json_t *list = json_array();
    for (size_t i = 0; i < s->farm.count; i++)
        json_array_append_new(list, worker_json(s, s->farm.workers[i]));
    body_reply(rq, re, 200, json_pack("{s:o}", "workers", list));
}

void feed_worker(struct server *s, const struct request *rq, struct reply *re)
{
    struct worker *w = farm_find(&s->farm, rq->part[0]);
    if (!w) {
        problem_reply(rq, re, 404, "no such worker: %.64s", rq->part[0]);
        return;
    }
    json_t *root = body_parse(rq, re);
    if (!root)
        return;
    const char *state;
    json_error_t e;
    if (json_unpack_ex(root, &e, JSON_STRICT, "{s:s}", "state", &state) != 0) {
        problem_reply(rq, re, 400, "%s", e.text);
    } else if (strcmp(state, "draining") != 0 && strcmp(state, "active") != 0) {
        problem_reply(rq, re, 400, "state: expected \"draining\" or \"active\", got \"%.20s\"",
                      state);
    } else {
        w->state = *state == 'd' ? WORKER_DRAINING : WORKER_ACTIVE;
        s->news = true;
        body_reply(rq, re, 200, worker_json(s, w));
    }
    json_decref(root);
}

/* ---- parked calls ---- */

/* Fills the reply when its time is up, when it shall drain, or when there is work. A client that
 * has gone is let go before it is given a pass that nobody would trace. */
static bool waiter_turn(struct server *s, struct waiter *p)
{
    const bool over = s->now_ms >= p->deadline_ms || p->worker->state == WORKER_DRAINING;
    if (!over && !grant_possible(s, p->worker))
        return false;
    size_t granted = 0;
    const uint32_t want = http_peer_is_gone(p->exchange) ? 0 : p->want;
    json_t *root = grant_leases(s, p->worker, want, &granted);
    if (over || granted || !want) {
        p->worker->seen_ms = s->now_ms;
        body_reply(http_request(p->exchange), http_reply(p->exchange), 200, root);
        return true;
    }
    json_decref(root);
    return false;
}

static void waiter_remove(struct server *s, struct waiter **link)
{
    struct waiter *p = *link;
    *link = p->next;
    if (!p->next)
        s->last_waiter = link;
    p->worker->parked--;
    http_reply(p->exchange)->parked = false;
    http_answer(p->exchange);
    free(p);
}

int64_t feed_next_deadline(const struct server *s)
{
    int64_t least = INT64_MAX;
    for (const struct waiter *p = s->first_waiter; p; p = p->next)
        least = min_i64(least, p->deadline_ms);
    return least;
}

void feed_turn(struct server *s)
{
    for (struct lease *l; (l = lease_first_due(s->leases, s->now_ms));)
        grant_expired(s, l);
    if (!s->news && s->now_ms < feed_next_deadline(s))
        return;
    s->news = false;
    for (struct waiter **link = &s->first_waiter; *link;)
        if (waiter_turn(s, *link))
            waiter_remove(s, link);
        else
            link = &(*link)->next;
}

void feed_release(struct server *s)
{
    while (s->first_waiter) {
        struct exchange *x = s->first_waiter->exchange;
        problem_reply(http_request(x), http_reply(x), 503, "shutting down");
        waiter_remove(s, &s->first_waiter);
    }
}
