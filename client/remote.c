/* jansson: every tree is owned by the function that parses it and released there; members are
 * borrowed.
 * SPDX-License-Identifier: MIT */
#include "client/remote.h"

#include <jansson.h>
#include <stdio.h>
#include <string.h>

#include "common/http_client.h"
#include "common/http_problem.h"

enum {
    CALL_MS = 30000,
    JSON_MAX_BYTES = 16 * 1024 * 1024,
    MAX_FAULTS = 100,
};

#define IMAGE_MAX_BYTES ((size_t)4 << 30)

static const char *const state_names[] = {
    [REMOTE_QUEUED] = "queued", [REMOTE_RUNNING] = "running", [REMOTE_PAUSED] = "paused",
    [REMOTE_DONE] = "done",     [REMOTE_FAILED] = "failed",   [REMOTE_CANCELLED] = "cancelled",
};

bool remote_open(struct remote *r, const char *server, struct err *err)
{
    r->http = http_client_new(server, err);
    return r->http != NULL;
}

void remote_close(struct remote *r)
{
    http_client_free(r->http);
}

bool remote_is_id(const char *text)
{
    return strlen(text) == 16 && strspn(text, "0123456789abcdef") == 16;
}

const char *remote_state_name(enum remote_state state)
{
    return state_names[state];
}

bool remote_is_over(enum remote_state state)
{
    return state == REMOTE_DONE || state == REMOTE_FAILED || state == REMOTE_CANCELLED;
}

static enum err_code code_of(int status)
{
    if (status == 404)
        return ERR_NOT_FOUND;
    if (status == 409)
        return ERR_CONFLICT;
    if (status == 413)
        return ERR_LIMIT;
    return status / 100 == 4 ? ERR_INPUT : status / 100 == 5 ? ERR_IO : ERR_PROTOCOL;
}

/* The problem document's text and its list of errors, as far as they fit. */
static bool refused(const struct http_client_reply *reply, struct err *err)
{
    char text[256], pointer[128], detail[256], list[400] = "";
    http_problem_text(reply->status, &reply->body, text, sizeof text);
    size_t used = 0;
    for (size_t i = 0; i < MAX_FAULTS && used < sizeof list; i++) {
        if (!http_problem_entry(&reply->body, i, pointer, sizeof pointer, detail, sizeof detail))
            break;
        used += (size_t)snprintf(list + used, sizeof list - used, "; %s: %s", pointer, detail);
    }
    return err_set(err, code_of(reply->status), "the coordinator answered %s%s", text, list);
}

/* One call; any 2xx (or 304, when asked with an ETag) is good. reply->body is the caller's then. */
static bool call(struct remote *r, struct http_client_request request,
                 struct http_client_reply *reply, struct err *err)
{
    if (!http_client_run(r->http, &request, reply, err))
        return false;
    if (reply->status / 100 == 2 || (reply->status == 304 && request.if_none_match))
        return true;
    refused(reply, err);
    buf_release(&reply->body);
    return false;
}

/* ------------------------------------------------------------------- jobs */

static double number_or(const json_t *object, const char *key, double otherwise)
{
    const json_t *v = json_object_get(object, key);
    return json_is_number(v) ? json_number_value(v) : otherwise;
}

static uint64_t whole(const json_t *object, const char *key)
{
    const json_int_t v = json_integer_value(json_object_get(object, key));
    return v > 0 ? (uint64_t)v : 0;
}

static void copy(char *out, size_t room, const json_t *object, const char *key)
{
    const char *text = json_string_value(json_object_get(object, key));
    snprintf(out, room, "%s", text ? text : "");
    for (char *c = out; *c; c++)
        if ((unsigned char)*c < ' ' || *c == 127)
            *c = ' '; /* nothing from there may move a terminal's cursor */
}

static bool read_state(const json_t *root, enum remote_state *state)
{
    const char *name = json_string_value(json_object_get(root, "state"));
    for (size_t i = 0; name && i < countof(state_names); i++)
        if (!strcmp(name, state_names[i])) {
            *state = (enum remote_state)i;
            return true;
        }
    return false;
}

/* What the report says of the error: an interval of two numbers, and the pixels it holds for. */
static void read_report(const json_t *report, struct remote_job *job)
{
    const json_t *interval = json_object_get(json_object_get(report, "error"), "interval");
    const double trusted = number_or(json_object_get(report, "pixels"), "trusted", -1);
    const bool known = json_array_size(interval) == 2;
    job->error_low = known ? json_number_value(json_array_get(interval, 0)) : -1;
    job->error_high = known ? json_number_value(json_array_get(interval, 1)) : -1;
    job->untrusted = trusted < 0 ? -1 : 1 - trusted;
}

static bool read_job(const json_t *root, struct remote_job *job, struct err *err)
{
    *job = (struct remote_job){
        .progress = number_or(root, "progress", 0),
        .error = number_or(root, "error", -1),
        .rate = number_or(root, "samples_per_second", -1),
        .eta_seconds = number_or(root, "eta_seconds", -1),
        .elapsed_seconds = number_or(root, "elapsed_seconds", 0),
        .cpu_seconds = number_or(root, "cpu_seconds", 0),
        .spp = (uint32_t)whole(root, "spp"),
        .target_spp = (uint32_t)whole(json_object_get(root, "target"), "spp"),
        .target_error = number_or(json_object_get(root, "target"), "error", 0),
        .workers = (uint32_t)whole(root, "workers"),
        .samples = whole(root, "samples"),
        .invalid_samples = whole(json_object_get(root, "invalid_samples"), "count"),
    };
    copy(job->ended_by, sizeof job->ended_by, root, "ended_by");
    read_report(json_object_get(root, "report"), job);
    copy(job->id, sizeof job->id, root, "id");
    copy(job->title, sizeof job->title, root, "title");
    copy(job->digest, sizeof job->digest, json_object_get(root, "image"), "digest");
    copy(job->failure, sizeof job->failure, json_object_get(root, "failure"), "reason");
    if (!remote_is_id(job->id) || !read_state(root, &job->state))
        return err_set(err, ERR_PROTOCOL, "the answer is not a job of a smalti coordinator");
    return true;
}

/* Takes over the body. */
static bool take_job(struct buf *body, struct remote_job *job, struct buf *json, struct err *err)
{
    json_t *root = json_loadb(body->size ? (const char *)body->data : "", body->size, 0, NULL);
    const bool good = read_job(root, job, err);
    json_decref(root);
    if (good && json)
        buf_append(json, body->data, body->size);
    buf_release(body);
    return good;
}

bool remote_submit(struct remote *r, const char *document, size_t bytes, int32_t priority,
                   struct remote_job *job, struct buf *json, struct err *err)
{
    char path[64];
    snprintf(path, sizeof path, "/v1/jobs?priority=%d", (int)priority);
    const struct http_client_request request = {
        .method = "POST",
        .path = path,
        .content_type = "application/json",
        .body = document,
        .body_bytes = bytes,
        .max_bytes = JSON_MAX_BYTES,
        .timeout_ms = CALL_MS,
    };
    struct http_client_reply reply;
    return call(r, request, &reply, err) && take_job(&reply.body, job, json, err);
}

static struct http_client_request simple(const char *method, const char *path)
{
    return (struct http_client_request){
        .method = method, .path = path, .max_bytes = JSON_MAX_BYTES, .timeout_ms = CALL_MS};
}

bool remote_cancel(struct remote *r, const char *id, struct remote_job *job, struct err *err)
{
    char path[64], etag[80] = "";
    snprintf(path, sizeof path, "/v1/jobs/%s", id);
    struct http_client_reply reply;
    bool changed;
    if (!call(r, simple("DELETE", path), &reply, err))
        return false;
    buf_release(&reply.body);
    return remote_look(r, id, etag, &changed, job, NULL, err);
}

static char *target_text(const struct remote_target *t)
{
    json_t *target = json_object();
    if (t->error > 0)
        json_object_set_new(target, "error", json_real(t->error));
    if (t->spp)
        json_object_set_new(target, "spp", json_integer(t->spp));
    json_t *root = json_pack("{s:o}", "target", target);
    char *text = json_dumps(root, JSON_COMPACT);
    json_decref(root);
    return text;
}

bool remote_continue(struct remote *r, const char *id, const struct remote_target *target,
                     struct err *err)
{
    char path[64], *text = target_text(target);
    snprintf(path, sizeof path, "/v1/jobs/%s", id);
    struct http_client_request request = simple("PATCH", path);
    request.content_type = "application/json";
    request.body = text;
    request.body_bytes = strlen(text);
    struct http_client_reply reply;
    const bool good = call(r, request, &reply, err);
    if (good)
        buf_release(&reply.body);
    free(text);
    return good;
}

bool remote_look(struct remote *r, const char *id, char etag[80], bool *changed,
                 struct remote_job *job, struct buf *json, struct err *err)
{
    char path[64];
    snprintf(path, sizeof path, "/v1/jobs/%s", id);
    struct http_client_request request = simple("GET", path);
    request.if_none_match = *etag ? etag : NULL;
    struct http_client_reply reply;
    if (!call(r, request, &reply, err))
        return false;
    *changed = reply.status != 304;
    if (!*changed) {
        buf_release(&reply.body);
        return true;
    }
    snprintf(etag, 80, "%s", reply.etag);
    return take_job(&reply.body, job, json, err);
}

static void read_curve(const json_t *root, struct remote_curve *c)
{
    const json_t *points = json_object_get(root, "points"),
                 *target = json_object_get(root, "target");
    const size_t count = json_array_size(points), from = count - min_size(count, REMOTE_CURVE);
    const double pixels = number_or(root, "pixels", 1);
    *c = (struct remote_curve){
        .target_error = number_or(target, "error", 0),
        .forecast_spp = number_or(json_object_get(root, "forecast"), "samples", 0) / pixels,
    };
    for (size_t i = from; i < count; i++) {
        const json_t *p = json_array_get(points, i);
        c->points[c->count++] =
            (struct remote_point){number_or(p, "samples", 0) / pixels, number_or(p, "error", 0)};
    }
}

bool remote_convergence(struct remote *r, const char *id, struct remote_curve *curve,
                        struct err *err)
{
    char path[64];
    snprintf(path, sizeof path, "/v1/jobs/%s/convergence", id);
    struct http_client_reply reply;
    if (!call(r, simple("GET", path), &reply, err))
        return false;
    const struct buf *body = &reply.body;
    json_t *root = json_loadb(body->size ? (const char *)body->data : "", body->size, 0, NULL);
    const bool good = json_is_array(json_object_get(root, "points")) ||
                      err_set(err, ERR_PROTOCOL, "the answer is not a curve");
    if (good)
        read_curve(root, curve);
    json_decref(root);
    buf_release(&reply.body);
    return good;
}

bool remote_list(struct remote *r, struct remote_job *jobs, size_t most, size_t *count,
                 struct buf *json, struct err *err)
{
    char path[64];
    snprintf(path, sizeof path, "/v1/jobs?limit=%zu", most);
    struct http_client_reply reply;
    if (!call(r, simple("GET", path), &reply, err))
        return false;
    const struct buf *body = &reply.body;
    json_t *root = json_loadb(body->size ? (const char *)body->data : "", body->size, 0, NULL);
    const json_t *list = json_object_get(root, "jobs");
    bool good = json_is_array(list) ||
                err_set(err, ERR_PROTOCOL, "the answer is not a smalti coordinator's");
    *count = min_size(json_array_size(list), most);
    for (size_t i = 0; good && i < *count; i++)
        good = read_job(json_array_get(list, i), &jobs[i], err);
    json_decref(root);
    if (good && json)
        buf_append(json, reply.body.data, reply.body.size);
    buf_release(&reply.body);
    return good;
}

bool remote_fetch(struct remote *r, const char *id, const char *what, struct buf *out,
                  struct err *err)
{
    char path[96];
    snprintf(path, sizeof path, "/v1/jobs/%s/%s", id, what);
    struct http_client_request request = simple("GET", path);
    request.max_bytes = IMAGE_MAX_BYTES;
    request.timeout_ms = 0;
    struct http_client_reply reply;
    if (!call(r, request, &reply, err))
        return false;
    buf_append(out, reply.body.data, reply.body.size);
    buf_release(&reply.body);
    return true;
}

/* ----------------------------------------------------------------- assets */

bool remote_has_asset(struct remote *r, const char hex[HASH_HEX], bool *here, struct err *err)
{
    char path[96];
    snprintf(path, sizeof path, "/v1/assets/%s", hex);
    struct http_client_reply reply;
    *here = call(r, simple("HEAD", path), &reply, err);
    if (*here)
        buf_release(&reply.body);
    return *here || err->code == ERR_NOT_FOUND;
}

bool remote_get_asset(struct remote *r, const char *hex, size_t max_bytes, struct buf *out,
                      struct err *err)
{
    char path[96], found[HASH_HEX];
    snprintf(path, sizeof path, "/v1/assets/%s", hex);
    struct http_client_request request = simple("GET", path);
    request.max_bytes = max_bytes;
    request.timeout_ms = 0;
    struct http_client_reply reply;
    if (!call(r, request, &reply, err))
        return false;
    hash_hex(reply.body.data ? reply.body.data : (const unsigned char *)"", reply.body.size, found);
    if (strcmp(found, hex) != 0) {
        buf_release(&reply.body);
        return err_set(err, ERR_PROTOCOL, "the bytes that came have the SHA-256 %s", found);
    }
    *out = reply.body;
    return true;
}

bool remote_put_asset(struct remote *r, const char hex[HASH_HEX], const struct buf *bytes,
                      struct err *err)
{
    char path[96];
    snprintf(path, sizeof path, "/v1/assets/%s", hex);
    struct http_client_request request = simple("PUT", path);
    request.content_type = "application/octet-stream";
    request.body = bytes->data;
    request.body_bytes = bytes->size;
    request.timeout_ms = 0;
    struct http_client_reply reply;
    if (!call(r, request, &reply, err))
        return false;
    buf_release(&reply.body);
    return true;
}
