/* What was measured: libmicrohttpd 0.9.75 stalls with exactly 128 ready connections per epoll
 * thread, so the limit over the pool stays below that; it takes two Content-Lengths, or one beside
 * a Transfer-Encoding, and a %00 in the target, so those are refused here; it
 * panics when stopped with a suspended connection, hence http_close and http_is_quiet.
 * SPDX-License-Identifier: MIT */
#include "server/http.h"

#include <assert.h>
#include <errno.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

#include <microhttpd.h>

#include "common/clock.h"
#include "server/conn.h"
#include "server/head.h"
#include "server/listen.h"
#include "server/problem.h"

enum {
    MEMORY_PER_CONNECTION = 32 * 1024, /* request line and headers; more is answered 431 */
    INACTIVITY_S = 90,
    MAX_QUERY = 16,
    MAX_DROPPED = 16 * 1024 * 1024, /* of a body that is refused already; then we hang up */
    LINGER_MS = 500, /* for answers to leave at the end */
};

static const uint64_t max_bodies_bytes = (uint64_t)512 << 20; /* in memory, all requests together */

struct http {
    struct http_setup setup;
    struct MHD_Daemon *daemon;
    struct conn_list *conns;
    uint16_t port;
    pthread_mutex_t lock; /* guards the rest */
    bool closed;
    size_t with_owner; /* exchanges pushed and not yet answered */
    uint64_t bodies_bytes;
};

enum step { STEP_NEW, STEP_BODY, STEP_OWNER, STEP_SENT };

struct exchange {
    struct http *http;
    struct MHD_Connection *connection;
    struct arena arena;
    struct request request;
    struct reply reply;
    enum step step;
    bool sane; /* the raw target was */
    uint64_t reserved_bytes, dropped_bytes;
};

static struct conn *conn_of(struct MHD_Connection *c)
{
    const union MHD_ConnectionInfo *info =
        MHD_get_connection_info(c, MHD_CONNECTION_INFO_SOCKET_CONTEXT);
    return info->socket_context;
}

static void enter(struct exchange *x, enum conn_phase phase, uint64_t bytes)
{
    conn_enter(x->http->conns, conn_of(x->connection), phase, bytes, clock_ms());
}

/* ---- what the request is ---- */

static enum MHD_Result keep_header(void *to, enum MHD_ValueKind kind, const char *name,
                                   const char *value)
{
    (void)kind;
    head_add(to, name, value ? value : "");
    return MHD_YES;
}

static enum MHD_Result keep_query(void *to, enum MHD_ValueKind kind, const char *name,
                                  const char *value)
{
    (void)kind;
    struct request *rq = to;
    if (rq->query_count == MAX_QUERY)
        return MHD_NO;
    struct request_field *f = &rq->query[rq->query_count++];
    f->name = arena_strdup(rq->arena, name);
    f->value = arena_strdup(rq->arena, value ? value : "");
    return MHD_YES;
}

/* ---- memory of bodies ---- */

static bool reserve(struct exchange *x, uint64_t bytes)
{
    struct http *h = x->http;
    pthread_mutex_lock(&h->lock);
    const bool room = h->bodies_bytes + bytes <= max_bodies_bytes;
    if (room) {
        h->bodies_bytes += bytes;
        x->reserved_bytes += bytes;
    }
    pthread_mutex_unlock(&h->lock);
    return room;
}

static void give_back(struct exchange *x)
{
    pthread_mutex_lock(&x->http->lock);
    x->http->bodies_bytes -= x->reserved_bytes;
    pthread_mutex_unlock(&x->http->lock);
    x->reserved_bytes = 0;
}

static void take_spooled(struct exchange *x, const void *data, size_t bytes)
{
    struct request *rq = &x->request;
    struct err err;
    if (!rq->spool && !(rq->spool = asset_spool_new(&err)))
        problem_from_err(rq, &x->reply, &err);
    else if (bytes && !asset_spool_add(rq->spool, data, bytes, &err))
        problem_from_err(rq, &x->reply, &err);
}

/* After a failure the rest of the body is dropped: the reply can only follow it. */
static void take_body(struct exchange *x, const void *data, size_t bytes)
{
    struct request *rq = &x->request;
    conn_received(x->http->conns, conn_of(x->connection), bytes);
    if (x->reply.status) {
        x->dropped_bytes += bytes;
        return;
    }
    const bool spooled = rq->route->flags & ROUTE_SPOOL;
    const uint64_t have = spooled && rq->spool ? rq->spool->bytes : rq->body.size;
    if (have + bytes > rq->route->body_limit)
        problem_reply(rq, &x->reply, 413, "body: expected at most %llu bytes",
                      (unsigned long long)rq->route->body_limit);
    else if (spooled)
        take_spooled(x, data, bytes);
    else if (!reserve(x, bytes))
        problem_reply(rq, &x->reply, 503, "too many requests at once: try again");
    else
        buf_append(&rq->body, data, bytes);
}

/* ---- answering ---- */

static struct MHD_Response *response_of(struct reply *re)
{
    if (re->file < 0) {
        /* Copied by libmicrohttpd: the request's arena goes when the exchange is completed, and
         * the order of that and of the last write is the library's business. */
        const union {
            const void *in;
            void *out; /* the library's prototype is older than const */
        } body = {re->body ? re->body : ""};
        return MHD_create_response_from_buffer(re->body ? re->body_bytes : 0, body.out,
                                               MHD_RESPMEM_MUST_COPY);
    }
    struct MHD_Response *r = MHD_create_response_from_fd64(re->body_bytes, re->file);
    if (!r)
        close(re->file);
    re->file = -1;
    return r;
}

static void add_headers(struct MHD_Response *r, const struct reply *re)
{
    char seconds[16];
    snprintf(seconds, sizeof seconds, "%d", re->retry_after_s);
    const struct {
        const char *name, *value;
    } headers[] = {
        {MHD_HTTP_HEADER_CONTENT_TYPE, re->type},
        {MHD_HTTP_HEADER_ETAG, re->etag},
        {MHD_HTTP_HEADER_LOCATION, re->location},
        {MHD_HTTP_HEADER_ALLOW, re->allow},
        {MHD_HTTP_HEADER_RETRY_AFTER, re->retry_after_s ? seconds : NULL},
        {MHD_HTTP_HEADER_CACHE_CONTROL,
         re->immutable ? "max-age=31536000, immutable" : "no-cache"},
        {"X-Content-Type-Options", "nosniff"},
        {"Referrer-Policy", "no-referrer"},
        {"Cross-Origin-Resource-Policy", "same-origin"},
        {"Content-Security-Policy", "default-src 'self'; img-src 'self' data:; base-uri 'none'; "
                                    "form-action 'none'; frame-ancestors 'none'"},
    };
    for (size_t i = 0; i < countof(headers); i++)
        if (headers[i].value)
            MHD_add_response_header(r, headers[i].name, headers[i].value);
}

static enum MHD_Result send_reply(struct exchange *x)
{
    const uint64_t bytes = x->reply.body_bytes;
    struct MHD_Response *r = response_of(&x->reply);
    if (!r)
        return MHD_NO;
    add_headers(r, &x->reply);
    enter(x, CONN_DOWNLOAD, bytes);
    x->step = STEP_SENT;
    const enum MHD_Result sent =
        MHD_queue_response(x->connection, (unsigned)x->reply.status, r);
    MHD_destroy_response(r);
    return sent;
}

/* ---- the pool thread's side ---- */

static enum MHD_Result first_call(struct exchange *x, const char *url, const char *method,
                                  const char *version)
{
    struct request *rq = &x->request;
    struct head head = {.method = method, .version = version, .target_is_sane = x->sane};
    rq->path = arena_strdup(rq->arena, url);
    rq->query = arena_new(rq->arena, struct request_field, MAX_QUERY);
    MHD_get_connection_values(x->connection, MHD_HEADER_KIND, keep_header, &head);
    MHD_get_connection_values(x->connection, MHD_GET_ARGUMENT_KIND, keep_query, rq);
    rq->if_none_match =
        head.if_none_match ? arena_strdup(rq->arena, head.if_none_match) : NULL;
    x->step = STEP_BODY;
    const struct http_setup *s = &x->http->setup;
    if (!head_check(&head, s->routes, s->route_count, rq, &x->reply))
        return send_reply(x);
    enter(x, CONN_BODY, 0);
    return MHD_YES;
}

static bool finish_body(struct exchange *x)
{
    struct request *rq = &x->request;
    struct err err;
    if (rq->route->flags & ROUTE_SPOOL && !x->reply.status)
        take_spooled(x, NULL, 0); /* an empty body is one too */
    if (!x->reply.status && rq->spool && !asset_spool_finish(rq->spool, &err))
        problem_from_err(rq, &x->reply, &err);
    if (!x->reply.status && rq->route->prepare)
        rq->route->prepare(rq, &x->reply);
    return x->reply.status == 0;
}

static enum MHD_Result last_call(struct exchange *x)
{
    struct http *h = x->http;
    enter(x, CONN_ANSWER, 0);
    if (!finish_body(x))
        return send_reply(x);
    pthread_mutex_lock(&h->lock);
    const bool closed = h->closed;
    h->with_owner += !closed;
    pthread_mutex_unlock(&h->lock);
    if (closed) {
        problem_reply(&x->request, &x->reply, 503, "shutting down");
        return send_reply(x);
    }
    x->step = STEP_OWNER;
    MHD_suspend_connection(x->connection); /* first: the owner may answer before push returns */
    queue_push(h->setup.inbox, (struct message){MESSAGE_REQUEST, x});
    return MHD_YES;
}

static enum MHD_Result on_request(void *cls, struct MHD_Connection *c, const char *url,
                                  const char *method, const char *version, const char *data,
                                  size_t *bytes, void **context)
{
    (void)cls;
    struct exchange *x = *context;
    x->connection = c;
    switch (x->step) {
    case STEP_NEW:
        return first_call(x, url, method, version);
    case STEP_BODY:
        if (*bytes == 0)
            return last_call(x);
        take_body(x, data, *bytes);
        *bytes = 0;
        return x->dropped_bytes > MAX_DROPPED ? MHD_NO : MHD_YES;
    case STEP_OWNER:
        return send_reply(x);
    case STEP_SENT:
        *bytes = 0;
        return MHD_YES;
    }
    __builtin_unreachable();
}

/* The first we hear of a request, with its target as it was sent. */
static void *on_target(void *cls, const char *target, struct MHD_Connection *c)
{
    struct exchange *x = arena_malloc(1, sizeof *x);
    x->http = cls;
    x->connection = c;
    x->request.arena = &x->arena;
    x->request.exchange = x;
    x->reply.file = -1;
    x->sane = route_target_is_sane(target);
    return x;
}

static void on_completed(void *cls, struct MHD_Connection *c, void **context,
                         enum MHD_RequestTerminationCode code)
{
    (void)cls;
    (void)code;
    struct exchange *x = *context;
    if (!x)
        return;
    conn_enter(x->http->conns, conn_of(c), CONN_IDLE, 0, clock_ms());
    give_back(x);
    buf_release(&x->request.body);
    asset_spool_free(x->request.spool);
    if (x->reply.file >= 0)
        close(x->reply.file);
    arena_release(&x->arena);
    free(x);
    *context = NULL;
}

static void on_connection(void *cls, struct MHD_Connection *c, void **context,
                          enum MHD_ConnectionNotificationCode code)
{
    struct http *h = cls;
    if (code == MHD_CONNECTION_NOTIFY_STARTED) {
        const union MHD_ConnectionInfo *info =
            MHD_get_connection_info(c, MHD_CONNECTION_INFO_CONNECTION_FD);
        *context = conn_new(h->conns, info->connect_fd, clock_ms());
    } else if (*context) {
        conn_free(h->conns, *context);
        *context = NULL;
    }
}

/* ---- the owner's side ---- */

struct request *http_request(struct exchange *x)
{
    return &x->request;
}

struct reply *http_reply(struct exchange *x)
{
    return &x->reply;
}

void http_answer(struct exchange *x)
{
    struct http *h = x->http;
    assert(x->reply.status && x->step == STEP_OWNER);
    MHD_resume_connection(x->connection); /* x may be gone from here on */
    pthread_mutex_lock(&h->lock);
    h->with_owner--;
    pthread_mutex_unlock(&h->lock);
}

bool http_peer_is_gone(struct exchange *x)
{
    const union MHD_ConnectionInfo *info =
        MHD_get_connection_info(x->connection, MHD_CONNECTION_INFO_CONNECTION_FD);
    char byte;
    const ssize_t n = recv(info->connect_fd, &byte, 1, MSG_PEEK | MSG_DONTWAIT);
    return n == 0 || (n < 0 && errno != EAGAIN && errno != EWOULDBLOCK && errno != EINTR);
}

void http_reap(struct http *h, int64_t now_ms)
{
    const size_t n = conn_reap(h->conns, now_ms);
    if (n)
        log_info("connections reaped=%zu", n);
}

void http_close(struct http *h)
{
    const MHD_socket listening = MHD_quiesce_daemon(h->daemon);
    if (listening != MHD_INVALID_SOCKET)
        close(listening);
    pthread_mutex_lock(&h->lock);
    h->closed = true;
    pthread_mutex_unlock(&h->lock);
}

bool http_is_quiet(struct http *h)
{
    pthread_mutex_lock(&h->lock);
    const bool quiet = h->with_owner == 0;
    pthread_mutex_unlock(&h->lock);
    return quiet;
}

void http_stop(struct http *h)
{
    const int64_t until_ms = clock_ms() + LINGER_MS;
    while (clock_ms() < until_ms) {
        const union MHD_DaemonInfo *info =
            MHD_get_daemon_info(h->daemon, MHD_DAEMON_INFO_CURRENT_CONNECTIONS);
        if (!info || info->num_connections == 0)
            break;
        clock_sleep_ms(10);
    }
    MHD_stop_daemon(h->daemon);
    conn_list_free(h->conns);
    pthread_mutex_destroy(&h->lock);
    free(h);
}

static struct MHD_Daemon *daemon_start(struct http *h, int fd)
{
    return MHD_start_daemon(
        MHD_USE_EPOLL_INTERNAL_THREAD | MHD_ALLOW_SUSPEND_RESUME | MHD_USE_ITC, 0, NULL, NULL,
        on_request, h, MHD_OPTION_LISTEN_SOCKET, fd, MHD_OPTION_THREAD_POOL_SIZE,
        (unsigned)HTTP_POOL, MHD_OPTION_CONNECTION_LIMIT, (unsigned)HTTP_MAX_CONNECTIONS,
        MHD_OPTION_CONNECTION_MEMORY_LIMIT, (size_t)MEMORY_PER_CONNECTION,
        MHD_OPTION_CONNECTION_TIMEOUT, (unsigned)INACTIVITY_S, MHD_OPTION_STRICT_FOR_CLIENT, 1,
        MHD_OPTION_URI_LOG_CALLBACK, on_target, h, MHD_OPTION_NOTIFY_COMPLETED, on_completed, h,
        MHD_OPTION_NOTIFY_CONNECTION, on_connection, h, MHD_OPTION_END);
}

struct http *http_start(const struct http_setup *setup, struct err *err)
{
    uint16_t port = 0;
    const int fd = listen_open(setup->config->listen, setup->config->port, &port, err);
    if (fd < 0)
        return NULL;
    struct http *h = arena_malloc(1, sizeof *h);
    h->setup = *setup;
    h->port = port;
    h->conns = conn_list_new();
    pthread_mutex_init(&h->lock, NULL);
    h->daemon = daemon_start(h, fd);
    if (h->daemon)
        return h;
    err_set(err, ERR_IO, "the HTTP server does not start: %s", strerror(errno));
    close(fd);
    conn_list_free(h->conns);
    pthread_mutex_destroy(&h->lock);
    free(h);
    return NULL;
}

uint16_t http_port(const struct http *h)
{
    return h->port;
}
