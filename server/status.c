/* SPDX-License-Identifier: MIT */
#include "server/status.h"

#include <stdio.h>

#include <jansson.h>

#include "server/status_report.h"

static json_t *number_or_null(bool known, double v)
{
    return known ? json_real(v) : json_null();
}

static json_t *time_or_null(int64_t unix_ms)
{
    return unix_ms ? json_integer(unix_ms) : json_null();
}

static json_t *rect_json(struct tile_rect r)
{
    return json_pack("[I,I,I,I]", (json_int_t)r.x_begin, (json_int_t)r.y_begin, (json_int_t)r.x_end,
                     (json_int_t)r.y_end);
}

/* ---- how far, how fast, how long ---- */

/* Samples until the error target, in all; 0: unknown, or there is none. */
static struct forecast forecast_of(const struct job *j)
{
    struct forecast f = {0};
    const double target = j->row.target.error;
    if (!(target > 0) || job_is_over(j) || !convergence_forecast(&j->convergence, target, &f))
        return (struct forecast){0};
    return f;
}

static double progress_of(const struct job *j, int64_t now_ms)
{
    const struct scene_target *t = &j->row.target;
    if (j->row.state == JOB_DONE)
        return 1;
    double most = (double)j->row.samples / ((double)j->pixels * t->spp);
    if (t->seconds > 0) {
        const double f = (double)job_elapsed_ms(j, now_ms) / 1000 / t->seconds;
        most = f > most ? f : most;
    }
    const struct forecast fore = forecast_of(j);
    if (fore.samples > 0) {
        const double f = (double)j->row.samples / fore.samples;
        most = f > most ? f : most;
    }
    return most < 1 ? most : 1;
}

static double speed_of(const struct job *j, int64_t now_ms)
{
    if (!job_is_over(j))
        return rate_per_second(&j->rate, now_ms);
    return j->row.elapsed_ms > 0 ? (double)j->row.samples * 1000 / (double)j->row.elapsed_ms : 0;
}

/* Seconds to the nearest target; < 0: unknown. */
static double eta_of(const struct job *j, double speed, int64_t now_ms)
{
    const struct scene_target *t = &j->row.target;
    if (j->row.state != JOB_RUNNING || speed <= 0)
        return -1;
    const double merged = (double)j->row.samples;
    double least = ((double)j->pixels * t->spp - merged) / speed;
    const struct forecast f = forecast_of(j);
    if (f.samples > 0) {
        const double eta = (f.samples - merged) / speed;
        least = eta < least ? eta : least;
    }
    if (t->seconds > 0) {
        const double eta = t->seconds - (double)job_elapsed_ms(j, now_ms) / 1000;
        least = eta < least ? eta : least;
    }
    return least > 0 ? least : 0;
}

/* ---- parts of the document ---- */

static json_t *target_json(const struct scene_target *t)
{
    return json_pack("{s:o, s:I, s:o}", "error", number_or_null(t->error > 0, t->error), "spp",
                     (json_int_t)t->spp, "seconds", number_or_null(t->seconds > 0, t->seconds));
}

/* Which target: of those that are given the first one reached. Before its spp only an error ends a
 * job; seconds do by settling the spp. */
static json_t *ended_by_json(const struct job *j)
{
    const struct store_job *r = &j->row;
    if (r->state != JOB_DONE)
        return json_null();
    if (r->target.error > 0 && r->error >= 0 && r->error <= r->target.error &&
        r->samples < (uint64_t)j->pixels * r->target.spp)
        return json_string("error");
    return json_string(r->target.seconds > 0 ? "seconds" : "spp");
}

static json_t *failure_json(const struct job *j)
{
    const struct store_failure *f = &j->row.failure;
    if (!*f->reason)
        return json_null();
    json_t *reason = json_string(f->reason); /* NULL when a cut has split a character */
    if (!reason)
        reason = json_string("(unreadable)");
    if (!f->has_pass || f->tile >= j->tile_count)
        return json_pack("{s:o, s:n, s:n, s:n}", "reason", reason, "tile", "rect", "pass");
    return json_pack("{s:o, s:I, s:o, s:I}", "reason", reason, "tile", (json_int_t)f->tile, "rect",
                     rect_json(tile_rect_of(&j->grid, f->tile)), "pass", (json_int_t)f->pass);
}

static json_t *warnings_json(const struct store_job *r)
{
    json_t *list = json_loads(r->warnings, 0, NULL);
    return json_is_array(list) ? list : json_array();
}

static size_t workers_of(const struct server *s, const struct job *j)
{
    static uint64_t mark; /* owner thread only */
    size_t n = 0;
    mark++;
    for (size_t i = 0; j->lease_count && i < lease_count(s->leases); i++) {
        const struct lease *l = lease_at(s->leases, i);
        n += l->job == j && l->worker->mark != mark;
        if (l->job == j)
            l->worker->mark = mark;
    }
    return n;
}

/* Of a job that is planned. */
static json_t *method_json(const struct store_job *r)
{
    if (r->method < STORE_METHOD_PLANNED)
        return json_null();
    const struct plan_names n =
        plan_names((enum plan_candidate_kind)(r->method - STORE_METHOD_PLANNED));
    return json_pack("{s:s, s:s}", "integrator", n.integrator, "strategy", n.strategy);
}

static void add_identity(json_t *root, const struct job *j)
{
    const struct store_job *r = &j->row;
    char id[24];
    snprintf(id, sizeof id, "%016llx", (unsigned long long)r->id);
    json_object_set_new(root, "id", json_string(id));
    json_object_set_new(root, "title", json_string(r->title));
    json_object_set_new(root, "state", json_string(store_state_name(r->state)));
    json_object_set_new(root, "priority", json_integer(r->priority));
    json_object_set_new(root, "created_unix_ms", json_integer(r->created_unix_ms));
    json_object_set_new(root, "started_unix_ms", time_or_null(r->started_unix_ms));
    json_object_set_new(root, "finished_unix_ms", time_or_null(r->finished_unix_ms));
    json_object_set_new(root, "document", json_string(r->document));
    json_object_set_new(root, "film",
                        json_pack("{s:I, s:I, s:o}", "width", (json_int_t)r->width_px, "height",
                                  (json_int_t)r->height_px, "crop", rect_json(r->crop)));
    json_object_set_new(root, "tile_px", json_integer(r->tile_px));
    json_object_set_new(root, "tiles", json_integer(j->tile_count));
    json_object_set_new(root, "target", target_json(&r->target));
    json_object_set_new(root, "ended_by", ended_by_json(j));
    json_object_set_new(root, "auto", json_boolean(r->method != STORE_METHOD_GIVEN));
    json_object_set_new(root, "method", method_json(r));
}

static void add_progress(json_t *root, const struct job *j, int64_t now_ms)
{
    const struct store_job *r = &j->row;
    const double speed = speed_of(j, now_ms), eta = eta_of(j, speed, now_ms);
    const uint64_t total = (uint64_t)j->tile_count * job_passes(j);
    json_object_set_new(root, "spp", json_integer(r->spp_done));
    json_object_set_new(
        root, "tile_passes",
        json_pack("{s:I, s:I}", "done", (json_int_t)r->passes_done, "total", (json_int_t)total));
    json_object_set_new(root, "progress", json_real(progress_of(j, now_ms)));
    json_object_set_new(root, "error", number_or_null(r->error >= 0, r->error));
    json_object_set_new(root, "samples", json_integer((json_int_t)r->samples));
    json_object_set_new(root, "samples_per_second", number_or_null(speed > 0, speed));
    json_object_set_new(root, "eta_seconds", number_or_null(eta >= 0, eta));
    json_object_set_new(root, "cpu_seconds", json_real((double)r->cpu_us / 1e6));
    json_object_set_new(root, "elapsed_seconds",
                        json_real((double)job_elapsed_ms(j, now_ms) / 1000));
}

json_t *status_job(const struct server *s, const struct job *j)
{
    const struct store_job *r = &j->row;
    json_t *root = json_object();
    add_identity(root, j);
    add_progress(root, j, s->now_ms);
    json_object_set_new(root, "workers", json_integer((json_int_t)workers_of(s, j)));
    json_object_set_new(root, "invalid_samples", status_report_invalid(r));
    json_object_set_new(root, "leases",
                        json_pack("{s:I, s:I, s:I, s:I}", "granted", (json_int_t)r->granted,
                                  "expired", (json_int_t)r->expired, "returned",
                                  (json_int_t)r->returned, "duplicates",
                                  (json_int_t)r->duplicates));
    json_object_set_new(root, "report", status_report(r));
    json_object_set_new(root, "failure", failure_json(j));
    json_object_set_new(root, "warnings", warnings_json(r));
    json_object_set_new(root, "image",
                        json_pack("{s:I, s:o}", "version", (json_int_t)r->image_version, "digest",
                                  *r->digest ? json_string(r->digest) : json_null()));
    return root;
}

/* ---- the curve ---- */

static json_t *point_json(const struct store_point *p)
{
    json_t *interval =
        p->error_low < 0 ? json_null() : json_pack("[f,f]", p->error_low, p->error_high);
    return json_pack("{s:I, s:I, s:I, s:f, s:f, s:f, s:o}", "samples", (json_int_t)p->samples,
                     "spp", (json_int_t)p->spp, "units", (json_int_t)p->units, "seconds",
                     (double)p->elapsed_ms / 1000, "cpu_seconds", (double)p->cpu_us / 1e6, "error",
                     p->error, "interval", interval);
}

static json_t *forecast_json(const struct server *s, const struct job *j)
{
    const struct forecast f = forecast_of(j);
    if (!(f.samples > 0))
        return json_null();
    const double speed = j->row.state == JOB_RUNNING ? speed_of(j, s->now_ms) : 0;
    const double bounds[] = {f.samples, f.low, f.high};
    static const char *const names[] = {"", "_low", "_high"};
    json_t *root = json_pack("{s:f}", "slope", f.slope);
    for (size_t i = 0; i < countof(bounds); i++) {
        char name[24];
        const double left = bounds[i] - (double)j->row.samples;
        snprintf(name, sizeof name, "samples%s", names[i]);
        json_object_set_new(root, name, json_real(bounds[i]));
        snprintf(name, sizeof name, "seconds_left%s", names[i]);
        json_object_set_new(root, name, number_or_null(speed > 0, left > 0 ? left / speed : 0));
    }
    return root;
}

json_t *status_curve(const struct server *s, const struct job *j, const struct convergence *c)
{
    json_t *points = json_array();
    for (size_t i = 0; i < c->count; i++)
        json_array_append_new(points, point_json(&c->points[i]));
    return json_pack("{s:I, s:o, s:o, s:o}", "pixels", (json_int_t)j->pixels, "points", points,
                     "target", target_json(&j->row.target), "forecast", forecast_json(s, j));
}
