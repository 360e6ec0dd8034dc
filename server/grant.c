/* SPDX-License-Identifier: MIT */
#include "server/grant.h"

#include <stdio.h>

#include <jansson.h>

#include "common/clock.h"
#include "server/round.h"

static json_t *plan_lease_json(const struct server *s, const struct lease *l)
{
    char lease[24], job[24];
    snprintf(lease, sizeof lease, "%016llx", (unsigned long long)l->id);
    snprintf(job, sizeof job, "%016llx", (unsigned long long)l->job->row.id);
    return json_pack("{s:s, s:s, s:s, s:b, s:I}", "lease", lease, "job", job, "document",
                     l->job->row.document, "plan", 1, "ttl_ms",
                     (json_int_t)s->config->lease_ttl_ms);
}

static json_t *pass_lease_json(const struct server *s, const struct lease *l)
{
    const struct job *j = l->job;
    const struct tile_rect r = tile_rect_of(&j->grid, l->tile);
    const struct tile_pass p = tile_pass_of(l->pass, j->row.target.spp);
    char lease[24], job[24];
    snprintf(lease, sizeof lease, "%016llx", (unsigned long long)l->id);
    snprintf(job, sizeof job, "%016llx", (unsigned long long)j->row.id);
    return json_pack("{s:s, s:s, s:s, s:I, s:[I,I,I,I], s:I, s:[I,I], s:I}", "lease", lease, "job",
                     job, "document", j->row.document, "tile", (json_int_t)l->tile, "rect",
                     (json_int_t)r.x_begin, (json_int_t)r.y_begin, (json_int_t)r.x_end,
                     (json_int_t)r.y_end, "pass", (json_int_t)l->pass, "samples",
                     (json_int_t)p.s_begin, (json_int_t)p.s_end, "ttl_ms",
                     (json_int_t)s->config->lease_ttl_ms);
}

/* All of the tile are not worth a word. */
static void add_blocks(json_t *root, const struct lease *l)
{
    const struct job *j = l->job;
    const size_t count = block_count(tile_rect_of(&j->grid, l->tile));
    const struct block_set blocks = round_blocks(j, l->tile, l->pass);
    char hex[BLOCK_SET_HEX];
    if (block_set_count(&blocks) == count)
        return;
    block_set_print(&blocks, count, hex);
    json_object_set_new(root, "blocks", json_string(hex));
}

static json_t *lease_json(const struct server *s, const struct lease *l)
{
    if (l->tile == JOB_PLAN)
        return plan_lease_json(s, l);
    json_t *root = pass_lease_json(s, l);
    add_blocks(root, l);
    if (l->job->row.method >= STORE_METHOD_PLANNED) {
        const struct plan_names n =
            plan_names((enum plan_candidate_kind)(l->job->row.method - STORE_METHOD_PLANNED));
        json_object_set_new(
            root, "method",
            json_pack("{s:s, s:s}", "integrator", n.integrator, "strategy", n.strategy));
    }
    return root;
}

static struct lease *grant(struct server *s, struct worker *w, const struct sched_pick *pick)
{
    struct job *j = pick->job;
    struct lease *l =
        lease_grant(s->leases, j, pick->tile, pick->pass, w, s->now_ms + s->config->lease_ttl_ms);
    if (pick->tile == JOB_PLAN)
        job_plan_granted(j, l->id);
    else
        sched_grant(j, pick->tile, pick->pass, l->id);
    w->leases++;
    if (j->row.state == JOB_QUEUED) {
        job_start(j, s->now_ms, clock_unix_ms());
        server_job_save(s, j);
    }
    return l;
}

/* A pass, or a plan, for this worker. Where a job settles on fewer samples, that is on disk before
 * anybody is given a pass of it. */
static bool find_work(struct server *s, const struct worker *w, struct sched_pick *pick)
{
    for (;;)
        switch (sched_next(&s->sched, w->number, s->now_ms, pick)) {
        case SCHED_NOTHING:
            return false;
        case SCHED_PASS:
            return true;
        case SCHED_PLAN:
            pick->tile = JOB_PLAN;
            return true;
        case SCHED_OPEN:
            server_job_open(s, pick->job);
            break;
        case SCHED_SETTLE:
            log_info("job=%016llx settles on spp=%u", (unsigned long long)pick->job->row.id,
                     pick->job->row.target.spp);
            server_job_save(s, pick->job);
            break;
        }
}

bool grant_possible(struct server *s, const struct worker *w)
{
    struct sched_pick pick;
    return w->state == WORKER_ACTIVE && w->leases < GRANT_MAX_HELD && find_work(s, w, &pick);
}

json_t *grant_leases(struct server *s, struct worker *w, uint32_t want, size_t *granted)
{
    json_t *list = json_array();
    *granted = 0;
    const bool draining = w->state == WORKER_DRAINING;
    struct sched_pick pick;
    while (!draining && *granted < want && w->leases < GRANT_MAX_HELD && find_work(s, w, &pick)) {
        json_array_append_new(list, lease_json(s, grant(s, w, &pick)));
        ++*granted;
    }
    json_t *root = json_pack("{s:o}", "leases", list);
    if (draining)
        json_object_set_new(root, "drain", json_true());
    return root;
}

/* ---- the other end ---- */

/* Its target is met: what is still out was a guess at a further round, and no longer matters. */
static bool is_decided(const struct job *j)
{
    return j->finishing || j->reached;
}

void grant_expired(struct server *s, struct lease *l)
{
    struct job *j = l->job;
    const uint32_t tile = l->tile, pass = l->pass;
    log_warn("lease=%016llx lapsed job=%016llx tile=%u pass=%u worker=%s",
             (unsigned long long)l->id, (unsigned long long)j->row.id, tile, pass, l->worker->name);
    server_lease_end(s, l);
    s->news = true;
    const bool goes_on = tile == JOB_PLAN ? job_plan_expired(j) : job_pass_expired(j, tile, pass);
    if (!goes_on && !is_decided(j))
        server_job_end(s, j, JOB_FAILED);
}

void grant_returned(struct server *s, struct lease *l)
{
    struct job *j = l->job;
    const uint32_t tile = l->tile, pass = l->pass;
    server_lease_end(s, l);
    j->row.returned++;
    if (tile == JOB_PLAN)
        job_plan_back(j);
    else
        job_slot_ready(j, tile, pass);
    s->news = true;
}

void grant_failed(struct server *s, struct lease *l, const char *reason)
{
    struct job *j = l->job;
    const uint32_t tile = l->tile, pass = l->pass, worker = l->worker->number;
    log_warn("lease=%016llx failed job=%016llx tile=%u pass=%u worker=%s reason=%s",
             (unsigned long long)l->id, (unsigned long long)j->row.id, tile, pass, l->worker->name,
             reason);
    server_lease_end(s, l);
    j->row.returned++;
    s->news = true;
    const bool goes_on = tile == JOB_PLAN
                             ? job_plan_failed(j, worker, reason, s->now_ms)
                             : job_pass_failed(j, tile, pass, worker, reason, s->now_ms);
    if (!goes_on && !is_decided(j))
        server_job_end(s, j, JOB_FAILED);
}

void grant_job_failed(struct server *s, struct job *j, const char *reason)
{
    if (is_decided(j))
        return;
    job_fail_reason(j, reason);
    server_job_end(s, j, JOB_FAILED);
}
