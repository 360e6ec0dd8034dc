/* PATCH of a job: its state, its priority; and, of one that is done, a target further on.
 * SPDX-License-Identifier: MIT */
#include <string.h>

#include <jansson.h>

#include "server/api.h"
#include "server/api_job.h"
#include "server/body.h"
#include "server/problem.h"

enum { MAX_PRIORITY = 100 };

struct change {
    const char *state;      /* NULL: as it is */
    json_t *priority_value; /* NULL: as it is */
    int32_t priority;
    json_t *target_value; /* NULL: as it is */
    struct scene_target target;
};

/* As in a document, but for seconds: those are over. */
static bool target_read(json_t *value, struct scene_target *t, struct err *err)
{
    json_error_t e;
    json_t *error = NULL, *spp = NULL;
    if (json_unpack_ex(value, &e, JSON_STRICT, "{s?o, s?o}", "error", &error, "spp", &spp) != 0)
        return err_set(err, ERR_INPUT, "target: %s", e.text);
    if (!error && !spp)
        return err_set(err, ERR_INPUT, "target: expected error, spp, or both");
    const double most = json_number_value(error);
    if (error && (!json_is_number(error) || !(most >= 1e-5 && most <= 1)))
        return err_set(err, ERR_INPUT, "target: error: expected a number in [1e-05, 1]");
    const json_int_t n = json_integer_value(spp);
    if (spp && (!json_is_integer(spp) || n < 1 || n > SCENE_MAX_SPP))
        return err_set(err, ERR_INPUT, "target: spp: expected a whole number in [1, %d]",
                       SCENE_MAX_SPP);
    *t = (struct scene_target){.error = most, .spp = spp ? (uint32_t)n : SCENE_MAX_SPP};
    return true;
}

static bool change_read(json_t *root, struct change *c, struct err *err)
{
    json_error_t e;
    if (json_unpack_ex(root, &e, JSON_STRICT, "{s?s, s?o, s?o}", "state", &c->state, "priority",
                       &c->priority_value, "target", &c->target_value) != 0)
        return err_set(err, ERR_INPUT, "%s", e.text);
    if (!c->state && !c->priority_value && !c->target_value)
        return err_set(err, ERR_INPUT, "expected state, priority or target");
    if (c->state && strcmp(c->state, "paused") != 0 && strcmp(c->state, "running") != 0)
        return err_set(err, ERR_INPUT, "state: expected \"paused\" or \"running\", got \"%.20s\"",
                       c->state);
    if (c->target_value && c->state)
        return err_set(err, ERR_INPUT, "expected a state or a target, not both");
    if (c->target_value && !target_read(c->target_value, &c->target, err))
        return false;
    if (!c->priority_value)
        return true;
    const json_int_t p = json_integer_value(c->priority_value);
    if (!json_is_integer(c->priority_value) || p < -MAX_PRIORITY || p > MAX_PRIORITY)
        return err_set(err, ERR_INPUT, "priority: expected a whole number from %d to %d",
                       -MAX_PRIORITY, MAX_PRIORITY);
    c->priority = (int32_t)p;
    return true;
}

/* What was done goes on, to the bytes of a job that had been asked for that much at once. */
static bool continue_job(struct server *s, struct job *j, const struct change *c, struct err *err)
{
    const struct store_job *row = &j->row;
    const struct scene_target *t = &c->target;
    if (row->state != JOB_DONE)
        return err_set(err, ERR_CONFLICT,
                       "the job is %s: only one that is done gets another target",
                       store_state_name(row->state));
    if (row->stratified)
        return err_set(err, ERR_CONFLICT,
                       "stratified samples are made for the spp of their document: "
                       "submit another one");
    if (t->spp <= row->spp_done)
        return err_set(err, ERR_CONFLICT, "target: spp: every pixel has %u samples already",
                       row->spp_done);
    if (t->error > 0 && row->error >= 0 && row->error <= t->error)
        return err_set(err, ERR_CONFLICT, "target: error: it is %.3g already", row->error);
    const int32_t priority = row->priority;
    if (c->priority_value)
        j->row.priority = c->priority;
    if (server_job_continue(s, j, t, err))
        return true;
    j->row.priority = priority;
    return false;
}

static bool change_apply(struct server *s, struct job *j, const struct change *c, struct err *err)
{
    if (c->target_value)
        return continue_job(s, j, c, err);
    if (job_is_over(j))
        return err_set(err, ERR_CONFLICT, "the job is %s", store_state_name(j->row.state));
    if (c->state && *c->state == 'p' && j->row.state != JOB_PAUSED)
        job_pause(j, s->now_ms);
    if (c->state && *c->state == 'r' && j->row.state == JOB_PAUSED)
        job_resume(j, s->now_ms);
    if (c->priority_value) {
        j->row.priority = c->priority;
        sched_reorder(&s->sched, j);
        job_touch(j);
    }
    s->news = true;
    return server_job_save(s, j) || err_set(err, ERR_IO, "the change is not on disk yet");
}

void api_job_change(struct server *s, const struct request *rq, struct reply *re)
{
    struct job *j = api_job_of(s, rq, re, rq->part[0]);
    if (!j)
        return;
    json_t *root = body_parse(rq, re);
    if (!root)
        return;
    struct change change = {0};
    struct err err;
    if (change_read(root, &change, &err) && change_apply(s, j, &change, &err))
        api_job_reply(s, rq, re, 200, j);
    else
        problem_from_err(rq, re, &err);
    json_decref(root);
}
