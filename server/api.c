/* SPDX-License-Identifier: MIT */
#include "server/api.h"

#include <assert.h>
#include <string.h>

#include <jansson.h>

#include "server/body.h"
#include "server/feed.h"
#include "server/problem.h"
#include "server/server.h"
#include "server/static.h"

#define JSON   "application/json"
#define BINARY "application/octet-stream"

static const uint64_t most_asset = (uint64_t)2 << 30;
enum { SMALL = 4096 };

const struct route api_routes[] = {
    {ROUTE_GET, "/", api_static, 0, NULL, NULL, 0},
    {ROUTE_GET, "/app.js", api_static, 0, NULL, NULL, 0},
    {ROUTE_GET, "/curve.js", api_static, 0, NULL, NULL, 0},
    {ROUTE_GET, "/style.css", api_static, 0, NULL, NULL, 0},
    {ROUTE_GET, "/v1/schema/scene.json", api_static, 0, NULL, NULL, 0},
    {ROUTE_GET, "/healthz", api_health, 0, NULL, NULL, 0},
    {ROUTE_GET, "/v1/healthz", api_health, 0, NULL, NULL, 0},
    {ROUTE_POST, "/v1/jobs", api_job_submit, SCENE_MAX_BYTES, JSON, api_prepare_job, 0},
    {ROUTE_GET, "/v1/jobs", api_job_list, 0, NULL, NULL, 0},
    {ROUTE_GET, "/v1/jobs/*", api_job_get, 0, NULL, NULL, 0},
    {ROUTE_PATCH, "/v1/jobs/*", api_job_change, SMALL, JSON, NULL, 0},
    {ROUTE_DELETE, "/v1/jobs/*", api_job_cancel, 0, NULL, NULL, 0},
    {ROUTE_GET, "/v1/jobs/*/document", api_job_document, 0, NULL, NULL, 0},
    {ROUTE_GET, "/v1/jobs/*/plan", api_job_plan, 0, NULL, NULL, 0},
    {ROUTE_GET, "/v1/jobs/*/image.exr", api_job_exr, 0, NULL, NULL, 0},
    {ROUTE_GET, "/v1/jobs/*/preview.png", api_job_png, 0, NULL, NULL, 0},
    {ROUTE_GET, "/v1/jobs/*/convergence", api_job_curve, 0, NULL, NULL, 0},
    {ROUTE_PUT, "/v1/assets/*", api_asset_put, most_asset, BINARY, NULL, ROUTE_SPOOL},
    {ROUTE_GET, "/v1/assets/*", api_asset_get, 0, NULL, NULL, 0},
    {ROUTE_POST, "/v1/leases", feed_lease, SMALL, JSON, NULL, 0},
    {ROUTE_PUT, "/v1/leases/*", feed_deliver, WIRE_MAX_BYTES, BINARY, feed_prepare_delivery, 0},
    {ROUTE_PUT, "/v1/leases/*/plan", feed_plan, PLAN_MAX_BYTES, JSON, NULL, 0},
    {ROUTE_DELETE, "/v1/leases/*", feed_return, SMALL, JSON, NULL, ROUTE_OPTIONAL},
    {ROUTE_POST, "/v1/leases/*/renew", feed_renew, 0, NULL, NULL, 0},
    {ROUTE_GET, "/v1/workers", feed_workers, 0, NULL, NULL, 0},
    {ROUTE_PATCH, "/v1/workers/*", feed_worker, SMALL, JSON, NULL, 0},
};
const size_t api_route_count = countof(api_routes);

/* ---- the page ---- */

void api_static(struct server *s, const struct request *rq, struct reply *re)
{
    (void)s;
    const struct static_file *f = static_find(rq->path);
    assert(f); /* the table above names them */
    char hex[HASH_HEX];
    const size_t bytes = (size_t)(f->end - f->begin);
    hash_hex(f->begin, bytes, hex);
    re->etag = arena_printf(rq->arena, "\"%.32s\"", hex);
    if (route_etag_matches(rq->if_none_match, re->etag)) {
        re->status = 304;
        return;
    }
    re->status = 200;
    re->type = f->type;
    re->body = f->begin;
    re->body_bytes = bytes;
}

void api_health(struct server *s, const struct request *rq, struct reply *re)
{
    json_int_t count[JOB_CANCELLED + 1] = {0};
    for (size_t i = 0; i < s->job_count; i++)
        count[s->jobs[i]->row.state]++;
    json_t *jobs = json_object();
    for (size_t i = 0; i < countof(count); i++)
        json_object_set_new(jobs, store_state_name((enum job_state)i), json_integer(count[i]));
    const size_t workers = farm_present(&s->farm, s->now_ms);
    body_reply(rq, re, 200,
               json_pack("{s:s, s:s, s:o, s:I}", "status", "ok", "version", SMALTI_VERSION, "jobs",
                         jobs, "workers", (json_int_t)workers));
}

/* ---- assets ---- */

static bool name_is_sane(const struct request *rq, struct reply *re)
{
    if (hash_is_hex(rq->part[0]))
        return true;
    problem_reply(rq, re, 400, "asset: expected 64 lower-case hex digits, got '%.80s'",
                  rq->part[0]);
    return false;
}

void api_asset_put(struct server *s, const struct request *rq, struct reply *re)
{
    (void)s;
    struct err err;
    if (!name_is_sane(rq, re))
        return;
    const bool known = asset_exists(rq->part[0]);
    if (strcmp(rq->part[0], rq->spool->hex) != 0)
        problem_reply(rq, re, 422, "the SHA-256 of the bytes is %s", rq->spool->hex);
    else if (!known && !asset_adopt(rq->spool, &err))
        problem_from_err(rq, re, &err);
    else
        re->status = known ? 200 : 201;
}

void api_asset_get(struct server *s, const struct request *rq, struct reply *re)
{
    (void)s;
    uint64_t bytes;
    if (!name_is_sane(rq, re))
        return;
    const int fd = asset_fd(rq->part[0], &bytes);
    if (fd < 0) {
        problem_reply(rq, re, 404, "no such asset: %s", rq->part[0]);
        return;
    }
    re->status = 200;
    re->type = BINARY;
    re->file = fd;
    re->body_bytes = bytes;
    re->immutable = true;
}
