/* jansson: every tree is owned by the function that parses or builds it, members are borrowed.
 * SPDX-License-Identifier: MIT */
#include "worker/link.h"

#include <inttypes.h>
#include <jansson.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/arena.h"
#include "common/clock.h"
#include "common/http_client.h"
#include "common/log.h"
#include "common/http_problem.h"
#include "common/scene.h"

enum {
    BACKOFF_FIRST_MS = 100,
    BACKOFF_MOST_MS = 10000,
    ANSWER_MAX_BYTES = 256 * 1024,
    CALL_MS = 15000,    /* until a short call is given up */
    DELIVER_MS = 60000, /* the largest payload at 100 kB/s */
    TTL_LEAST_MS = 100,
    TTL_MOST_MS = 24 * 3600 * 1000,
};

struct link {
    struct http_client *http;
    const char *name;
    uint32_t threads;
    struct link_call *calls; /* under way */
    uint32_t running;        /* how many those are */
    int64_t delay_ms;        /* of the back-off; 0: the last answer was good */
    int64_t opens_ms;
    uint64_t random;
};

struct link_call {
    enum link_kind kind;
    char id[LINK_ID];
    uint32_t wanted;
    char *body; /* owned, from jansson; NULL: none, or borrowed */
    struct link_call *next;
};

struct link *link_new(const char *server, const char *name, uint32_t threads, struct err *err)
{
    struct http_client *http = http_client_new(server, err);
    if (!http)
        return NULL;
    struct link *l = arena_malloc(1, sizeof *l);
    *l = (struct link){.http = http, .name = name, .threads = threads};
    for (const char *c = name; *c; c++) /* names differ, so the jitter does */
        l->random = (l->random ^ (unsigned char)*c) * UINT64_C(0x100000001b3) + 1;
    return l;
}

static void call_free(struct link *l, struct link_call *call)
{
    struct link_call **at = &l->calls;
    while (*at != call)
        at = &(*at)->next;
    *at = call->next;
    l->running--;
    free(call->body);
    free(call);
}

void link_free(struct link *l)
{
    http_client_free(l->http); /* before the bodies it sends */
    while (l->calls)
        call_free(l, l->calls);
    free(l);
}

bool link_is_open(const struct link *l, int64_t now_ms)
{
    return now_ms >= l->opens_ms;
}

int64_t link_opens_ms(const struct link *l)
{
    return l->opens_ms;
}

uint32_t link_running(const struct link *l)
{
    return l->running;
}

static void note_failure(struct link *l, const char *text)
{
    const int64_t now = clock_ms();
    if (!link_is_open(l, now))
        return; /* one outage makes all calls fail: counted once */
    if (!l->delay_ms)
        log_warn("coordinator_lost reason=\"%s\"", text);
    l->delay_ms = l->delay_ms ? min_i64(l->delay_ms * 2, BACKOFF_MOST_MS) : BACKOFF_FIRST_MS;
    l->random = l->random * UINT64_C(6364136223846793005) + UINT64_C(1442695040888963407);
    l->opens_ms =
        now + l->delay_ms / 2 + (int64_t)((l->random >> 33) % (uint64_t)(l->delay_ms / 2 + 1));
    log_debug("backoff ms=%lld", (long long)(l->opens_ms - now));
}

static void note_answer(struct link *l)
{
    if (l->delay_ms)
        log_info("coordinator_back");
    l->delay_ms = 0;
    l->opens_ms = 0;
}

/* ------------------------------------------------------------------ calls */

static void start(struct link *l, struct link_call call, struct http_client_request r)
{
    struct link_call *tag = arena_malloc(1, sizeof *tag);
    *tag = call;
    tag->next = l->calls;
    l->calls = tag;
    l->running++;
    r.max_bytes = ANSWER_MAX_BYTES;
    http_client_start(l->http, &r, tag);
}

/* Takes over the tree. */
static char *dump(json_t *tree)
{
    char *text = json_dumps(tree, JSON_COMPACT);
    json_decref(tree);
    return text;
}

static void start_json(struct link *l, struct link_call call, const char *method, const char *path,
                       int64_t timeout_ms)
{
    start(l, call,
          (struct http_client_request){
              .method = method,
              .path = path,
              .content_type = call.body ? "application/json" : NULL,
              .body = call.body,
              .body_bytes = call.body ? strlen(call.body) : 0,
              .timeout_ms = timeout_ms,
          });
}

void link_ask(struct link *l, uint32_t want, uint32_t wait_ms)
{
    struct link_call call = {.kind = LINK_ASK, .wanted = min_u32(want, LINK_MAX_LEASES)};
    call.body = dump(json_pack("{s:s, s:i, s:s, s:i, s:i}", "worker", l->name, "threads",
                               (int)l->threads, "version", SMALTI_VERSION, "want", (int)call.wanted,
                               "wait_ms", (int)wait_ms));
    start_json(l, call, "POST", "/v1/leases", wait_ms + CALL_MS);
}

static struct link_call call_of(enum link_kind kind, const char *id)
{
    struct link_call call = {.kind = kind};
    snprintf(call.id, sizeof call.id, "%s", id);
    return call;
}

void link_renew(struct link *l, const char *id)
{
    char path[64];
    snprintf(path, sizeof path, "/v1/leases/%s/renew", id);
    start_json(l, call_of(LINK_RENEW, id), "POST", path, CALL_MS);
}

static void deliver(struct link *l, const char *id, const struct buf *payload, uint32_t want,
                    bool plan)
{
    struct link_call call = call_of(LINK_DELIVER, id);
    call.wanted = min_u32(want, LINK_MAX_LEASES);
    char path[160];
    snprintf(path, sizeof path, "/v1/leases/%s%s?worker=%s&want=%u", id, plan ? "/plan" : "",
             l->name, call.wanted);
    start(l, call,
          (struct http_client_request){
              .method = "PUT",
              .path = path,
              .content_type = plan ? "application/json" : "application/octet-stream",
              .body = payload->data,
              .body_bytes = payload->size,
              .timeout_ms = DELIVER_MS,
          });
}

void link_deliver(struct link *l, const char *id, const struct buf *payload, uint32_t want)
{
    deliver(l, id, payload, want, false);
}

void link_deliver_plan(struct link *l, const char *id, const struct buf *text, uint32_t want)
{
    deliver(l, id, text, want, true);
}

void link_return(struct link *l, const char *id, const char *kind, const char *reason)
{
    struct link_call call = call_of(LINK_RETURN, id);
    if (kind) {
        json_t *body = json_pack("{s:s, s:s}", "reason", reason, "kind", kind);
        if (!body) /* cut in the middle of a character */
            body = json_pack("{s:s, s:s}", "reason", "see the worker's log", "kind", kind);
        call.body = dump(body);
    }
    char path[64];
    snprintf(path, sizeof path, "/v1/leases/%s", id);
    start_json(l, call, "DELETE", path, CALL_MS);
}

void link_state(struct link *l, const char *state)
{
    struct link_call call = {.kind = LINK_STATE};
    call.body = dump(json_pack("{s:s}", "state", state));
    char path[128];
    snprintf(path, sizeof path, "/v1/workers/%s", l->name);
    start_json(l, call, "PATCH", path, CALL_MS);
}

/* ---------------------------------------------------------------- answers */

static bool read_whole(const json_t *value, uint64_t least, uint64_t most, uint64_t *out)
{
    const json_int_t v = json_integer_value(value);
    *out = (uint64_t)v;
    return json_is_integer(value) && v >= 0 && *out >= least && *out <= most;
}

static bool read_array(const json_t *array, size_t count, uint64_t most, uint32_t *out)
{
    if (json_array_size(array) != count)
        return false;
    for (size_t i = 0; i < count; i++) {
        uint64_t v;
        if (!read_whole(json_array_get(array, i), 0, most, &v))
            return false;
        out[i] = (uint32_t)v;
    }
    return true;
}

static bool read_id(const json_t *value, char id[LINK_ID])
{
    const char *text = json_string_value(value);
    if (!text || strlen(text) != LINK_ID - 1 || strspn(text, "0123456789abcdef") != LINK_ID - 1)
        return false;
    memcpy(id, text, LINK_ID);
    return true;
}

/* The method of a planned job; of others none is said. */
static bool read_method(const json_t *value, enum plan_candidate_kind *k)
{
    *k = PLAN_REAL;
    if (!value)
        return true;
    const char *integrator = json_string_value(json_object_get(value, "integrator"));
    const char *strategy = json_string_value(json_object_get(value, "strategy"));
    if (integrator && strategy)
        *k = plan_find(integrator, strategy);
    return *k != PLAN_REAL;
}

/* Without a word, all of the tile. */
static bool read_blocks(const json_t *value, struct link_lease *lease, struct err *err)
{
    const size_t count = block_count(lease->rect);
    lease->blocks = block_set_all(count);
    const char *text = json_string_value(value);
    if (!value || (text && block_set_parse(&lease->blocks, count, text)))
        return true;
    return err_set(err, ERR_PROTOCOL,
                   "blocks: expected %zu hex digits that name some of %zu, got '%.40s'",
                   (count + 3) / 4, count, text ? text : "no text");
}

static bool read_pass(const json_t *o, struct link_lease *lease, struct err *err)
{
    uint32_t rect[4], samples[2];
    uint64_t tile, pass;
    if (!read_whole(json_object_get(o, "tile"), 0, UINT32_MAX, &tile) ||
        !read_whole(json_object_get(o, "pass"), 0, UINT32_MAX, &pass) ||
        !read_array(json_object_get(o, "rect"), 4, SCENE_MAX_SIDE_PX, rect) ||
        !read_array(json_object_get(o, "samples"), 2, SCENE_MAX_SPP, samples) ||
        !read_method(json_object_get(o, "method"), &lease->method))
        return err_set(err, ERR_PROTOCOL, "expected tile, pass, rect, samples, and a known method");
    if (rect[0] >= rect[2] || rect[1] >= rect[3] || rect[2] - rect[0] > TILE_MAX_PX ||
        rect[3] - rect[1] > TILE_MAX_PX || samples[0] >= samples[1])
        return err_set(err, ERR_PROTOCOL,
                       "expected samples of a tile of at most %d px, got [%u, %u) of [%u, %u, %u, "
                       "%u]",
                       TILE_MAX_PX, samples[0], samples[1], rect[0], rect[1], rect[2], rect[3]);
    lease->tile = (uint32_t)tile;
    lease->rect = (struct tile_rect){rect[0], rect[1], rect[2], rect[3]};
    lease->pass_index = (uint32_t)pass;
    lease->pass = (struct tile_pass){samples[0], samples[1]};
    return read_blocks(json_object_get(o, "blocks"), lease, err);
}

static bool read_lease(const json_t *o, struct link_lease *lease, struct err *err)
{
    uint64_t ttl;
    const char *document = json_string_value(json_object_get(o, "document"));
    if (!read_id(json_object_get(o, "lease"), lease->id) ||
        !read_id(json_object_get(o, "job"), lease->job) || !document || !hash_is_hex(document) ||
        !read_whole(json_object_get(o, "ttl_ms"), TTL_LEAST_MS, TTL_MOST_MS, &ttl))
        return err_set(err, ERR_PROTOCOL, "expected lease, job, document and ttl_ms");
    memcpy(lease->document, document, HASH_HEX);
    lease->job_number = strtoull(lease->job, NULL, 16);
    lease->ttl_ms = (int64_t)ttl;
    lease->plan = json_is_true(json_object_get(o, "plan"));
    lease->method = PLAN_REAL;
    return lease->plan || read_pass(o, lease, err);
}

static bool read_leases(const json_t *root, struct link_event *e, struct err *err)
{
    const json_t *list = json_object_get(root, "leases");
    if (!json_is_array(list) || json_array_size(list) > e->wanted)
        return err_set(err, ERR_PROTOCOL, "leases: expected at most %u", e->wanted);
    for (size_t i = 0; i < json_array_size(list); i++)
        if (!read_lease(json_array_get(list, i), &e->leases[e->lease_count++], err))
            return err_at(err, "leases[%zu]", i);
    e->drain = json_is_true(json_object_get(root, "drain"));
    return true;
}

static bool read_answer(const struct buf *body, struct link_event *e, struct err *err)
{
    if (e->kind == LINK_RETURN || e->kind == LINK_STATE)
        return true; /* nothing in there is needed */
    json_t *root = json_loadb(body->size ? (const char *)body->data : "", body->size, 0, NULL);
    bool good = json_is_object(root);
    uint64_t ttl = 0;
    if (!good) {
        err_set(err, ERR_PROTOCOL, "expected a JSON object");
    } else if (e->kind == LINK_RENEW) {
        good = read_whole(json_object_get(root, "ttl_ms"), TTL_LEAST_MS, TTL_MOST_MS, &ttl) ||
               err_set(err, ERR_PROTOCOL, "ttl_ms: expected %d to %d", TTL_LEAST_MS, TTL_MOST_MS);
        e->ttl_ms = (int64_t)ttl;
    } else {
        const char *result = json_string_value(json_object_get(root, "result"));
        snprintf(e->result, sizeof e->result, "%s", result ? result : "");
        good = read_leases(root, e, err);
    }
    json_decref(root);
    return good;
}

static void fill(struct link *l, const struct http_client_reply *reply, struct link_event *e)
{
    struct err err;
    e->status = reply->status;
    if (!reply->status) {
        snprintf(e->text, sizeof e->text, "%s", reply->err.text);
    } else if (reply->status / 100 != 2) {
        http_problem_text(reply->status, &reply->body, e->text, sizeof e->text);
    } else if (!read_answer(&reply->body, e, &err)) {
        /* Leases in it lapse by themselves; whoever answers so is no coordinator of ours. */
        snprintf(e->text, sizeof e->text, "the answer is not one of a coordinator's: %.400s",
                 err.text);
        e->status = 0;
        e->lease_count = 0;
    }
    if (e->status == 0 || e->status / 100 == 5)
        note_failure(l, e->text);
    else
        note_answer(l);
}

bool link_poll(struct link *l, int64_t timeout_ms, const int *fds, size_t fd_count,
               struct link_event *e)
{
    void *tag = NULL;
    struct http_client_reply reply;
    if (!http_client_poll(l->http, timeout_ms, fds, fd_count, &tag, &reply))
        return false;
    struct link_call *call = tag;
    *e = (struct link_event){.kind = call->kind, .wanted = call->wanted};
    memcpy(e->id, call->id, sizeof e->id);
    fill(l, &reply, e);
    buf_release(&reply.body);
    call_free(l, call);
    return true;
}
