/* JSON: body_parse's object is owned by the handler and released before it returns.
 * SPDX-License-Identifier: MIT */
#include "server/api_job.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <jansson.h>

#include "common/clock.h"
#include "server/api.h"
#include "server/body.h"
#include "server/problem.h"
#include "server/report.h"
#include "server/server.h"
#include "server/status.h"
#include "server/status_warnings.h"

enum { MAX_PRIORITY = 100, MAX_LIST = 200, LIST = 50 };

/* True: the reader knows it as it is. */
static bool is_known(const struct server *s, const struct request *rq, struct reply *re,
                     const struct job *j)
{
    re->etag = arena_printf(rq->arena, "\"%08x-%llu\"", s->nonce, (unsigned long long)j->version);
    if (rq->route->method != ROUTE_GET || !route_etag_matches(rq->if_none_match, re->etag))
        return false;
    re->status = 304;
    return true;
}

void api_job_reply(const struct server *s, const struct request *rq, struct reply *re, int status,
                   const struct job *j)
{
    if (!is_known(s, rq, re, j))
        body_reply(rq, re, status, status_job(s, j));
}

struct job *api_job_of(const struct server *s, const struct request *rq, struct reply *re,
                       const char *text)
{
    struct job *j = NULL;
    if (strlen(text) == 16 && strspn(text, "0123456789abcdef") == 16)
        j = server_job_find(s, strtoull(text, NULL, 16));
    if (!j)
        problem_reply(rq, re, 404, "no such job: %.40s", text);
    return j;
}

/* ---- submit ---- */

void api_prepare_job(struct request *rq, struct reply *re)
{
    struct scene_errors errors = {0};
    struct scene *scene = arena_new(rq->arena, struct scene, 1);
    if (scene_parse(scene, rq->body.data ? (const char *)rq->body.data : "", rq->body.size,
                    SCENE_FROM_NET, rq->arena, &errors))
        rq->scene = scene;
    else
        problem_scene(rq, re, &errors);
}

struct missing { /* assets, each once */
    const char **list;
    size_t count;
};

static void look_for(struct missing *m, const char *asset)
{
    bool known = asset_exists(asset);
    for (size_t k = 0; k < m->count; k++)
        known |= !strcmp(m->list[k], asset);
    if (!known)
        m->list[m->count++] = asset;
}

static bool assets_are_here(const struct request *rq, struct reply *re)
{
    const struct scene *scene = rq->scene;
    struct missing m = {
        arena_new(rq->arena, const char *, (size_t)scene->mesh_count + scene->image_count), 0};
    for (uint32_t i = 0; i < scene->mesh_count; i++)
        if (scene->meshes[i].format != MESH_INLINE)
            look_for(&m, scene->meshes[i].asset);
    for (uint32_t i = 0; i < scene->image_count; i++)
        look_for(&m, scene->images[i].asset);
    if (m.count)
        problem_missing(rq, re, m.list, m.count);
    return m.count == 0;
}

static struct store_job row_of(const struct server *s, const struct scene *scene, int64_t priority)
{
    const struct scene_film *f = &scene->film;
    struct store_job row = {
        .state = JOB_QUEUED,
        .priority = (int32_t)priority,
        .width_px = f->width_px,
        .height_px = f->height_px,
        .tile_px = s->config->tile_px,
        .crop = {f->crop_x_begin, f->crop_y_begin, f->crop_x_end, f->crop_y_end},
        .layers = f->layers,
        .stratified = scene->settings.sampler == SAMPLER_STRATIFIED,
        .target = scene->settings.target,
        .created_unix_ms = clock_unix_ms(),
        .error = -1,
        .report = report_none(),
    };
    do
        server_random(&row.id, sizeof row.id);
    while (!row.id || server_job_find(s, row.id));
    snprintf(row.title, sizeof row.title, "%s", scene->title);
    status_warnings_print(scene, row.warnings, sizeof row.warnings);
    return row;
}

static bool film_fits(const struct server *s, const struct request *rq, struct reply *re,
                      const struct store_job *row)
{
    struct job *j = job_new(row);
    const uint64_t bytes = job_film_bytes(j);
    job_free(j);
    if (bytes <= s->config->memory_bytes)
        return true;
    struct scene_error e = {
        .code = ERR_LIMIT,
        .where = "/film",
        .what = arena_printf(
            rq->arena, "takes %llu MiB of memory; this coordinator has %llu MiB (--memory)",
            (unsigned long long)(bytes >> 20), (unsigned long long)(s->config->memory_bytes >> 20)),
    };
    problem_scene(rq, re, &(struct scene_errors){&e, 1});
    return false;
}

void api_job_submit(struct server *s, const struct request *rq, struct reply *re)
{
    int64_t priority;
    struct err err;
    if (!route_query_int(rq, "priority", -MAX_PRIORITY, MAX_PRIORITY, 0, &priority, &err)) {
        problem_from_err(rq, re, &err);
        return;
    }
    struct store_job row = row_of(s, rq->scene, priority);
    if (!assets_are_here(rq, re) || !film_fits(s, rq, re, &row))
        return;
    if (!asset_put(rq->body.data, rq->body.size, row.document, &err) ||
        !store_job_add(s->store, &row, &err)) {
        log_error("submit %s", err.text);
        problem_from_err(rq, re, &err);
        return;
    }
    const struct job *j = server_job_add(s, &row);
    log_info("job=%016llx submitted %ux%u spp=%u error=%g seconds=%g priority=%d title=%s",
             (unsigned long long)row.id, row.width_px, row.height_px, row.target.spp,
             row.target.error, row.target.seconds, row.priority, row.title);
    re->location = arena_printf(rq->arena, "/v1/jobs/%016llx", (unsigned long long)row.id);
    api_job_reply(s, rq, re, 201, j);
}

/* ---- look ---- */

static size_t place_of(const struct server *s, uint64_t number) /* in s->jobs, by age */
{
    size_t begin = 0, end = s->job_count;
    while (begin < end) {
        const size_t mid = (begin + end) / 2;
        if (s->jobs[mid]->row.number < number)
            begin = mid + 1;
        else
            end = mid;
    }
    return begin;
}

void api_job_list(struct server *s, const struct request *rq, struct reply *re)
{
    int64_t limit;
    struct err err;
    if (!route_query_int(rq, "limit", 1, MAX_LIST, LIST, &limit, &err)) {
        problem_from_err(rq, re, &err);
        return;
    }
    size_t at = s->job_count; /* the next one is before it */
    const char *after = route_query(rq, "after");
    if (after) {
        const struct job *j = api_job_of(s, rq, re, after);
        if (!j)
            return;
        at = place_of(s, j->row.number);
    }
    json_t *list = json_array(), *next = json_null();
    for (int64_t n = 0; n < limit && at > 0; n++)
        json_array_append_new(list, status_job(s, s->jobs[--at]));
    if (at > 0) {
        char id[24];
        snprintf(id, sizeof id, "%016llx", (unsigned long long)s->jobs[at]->row.id);
        next = json_string(id);
    }
    body_reply(rq, re, 200, json_pack("{s:o, s:o}", "jobs", list, "next", next));
}

void api_job_get(struct server *s, const struct request *rq, struct reply *re)
{
    const struct job *j = api_job_of(s, rq, re, rq->part[0]);
    if (j)
        api_job_reply(s, rq, re, 200, j);
}

void api_job_curve(struct server *s, const struct request *rq, struct reply *re)
{
    const struct job *j = api_job_of(s, rq, re, rq->part[0]);
    struct convergence stored = {0};
    struct err err;
    if (!j || is_known(s, rq, re, j))
        return;
    if (job_is_over(j) && !convergence_load(&stored, s->store, j->row.number, &err)) {
        log_error("curve job=%016llx %s", (unsigned long long)j->row.id, err.text);
        problem_from_err(rq, re, &err);
        return;
    }
    body_reply(rq, re, 200, status_curve(s, j, job_is_over(j) ? &stored : &j->convergence));
    convergence_release(&stored);
}

void api_job_document(struct server *s, const struct request *rq, struct reply *re)
{
    const struct job *j = api_job_of(s, rq, re, rq->part[0]);
    if (!j)
        return;
    uint64_t bytes;
    re->file = asset_fd(j->row.document, &bytes);
    if (re->file < 0) {
        problem_reply(rq, re, 404, "the document is no longer here");
        return;
    }
    re->status = 200;
    re->type = "application/json";
    re->body_bytes = bytes;
    re->immutable = true;
}

static void reply_image(const struct server *s, const struct request *rq, struct reply *re,
                        const char *name, const char *type)
{
    const struct job *j = api_job_of(s, rq, re, rq->part[0]);
    if (!j)
        return;
    re->etag = arena_printf(rq->arena, "\"%08x-%llu\"", s->nonce,
                            (unsigned long long)j->row.image_version);
    if (j->row.image_version && route_etag_matches(rq->if_none_match, re->etag)) {
        re->status = 304;
        return;
    }
    char directory[DISK_PATH - 32], path[DISK_PATH];
    uint64_t bytes;
    server_job_directory(s, j, directory, sizeof directory);
    snprintf(path, sizeof path, "%s/%s", directory, name);
    re->file = j->row.image_version ? disk_open(path, &bytes) : -1;
    if (re->file < 0) {
        re->etag = NULL;
        problem_reply(rq, re, 404, "there is no image yet");
        return;
    }
    re->status = 200;
    re->type = type;
    re->body_bytes = bytes;
}

void api_job_exr(struct server *s, const struct request *rq, struct reply *re)
{
    reply_image(s, rq, re, "image.exr", "image/x-exr");
}

void api_job_png(struct server *s, const struct request *rq, struct reply *re)
{
    reply_image(s, rq, re, "preview.png", "image/png");
}

/* ---- end ---- */

void api_job_cancel(struct server *s, const struct request *rq, struct reply *re)
{
    struct job *j = api_job_of(s, rq, re, rq->part[0]);
    if (!j)
        return;
    if (j->row.state == JOB_DONE || j->row.state == JOB_FAILED) {
        problem_reply(rq, re, 409, "the job is %s", store_state_name(j->row.state));
        return;
    }
    if (j->row.state != JOB_CANCELLED)
        server_job_end(s, j, JOB_CANCELLED);
    if (j->unsaved)
        problem_reply(rq, re, 503, "the change is not on disk yet");
    else
        api_job_reply(s, rq, re, 200, j);
}
