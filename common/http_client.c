/* SPDX-License-Identifier: MIT */
#include "common/http_client.h"

#include <curl/curl.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "common/arena.h"

enum {
    MAX_FDS = 4,
    CONNECT_MS = 5000,
    STALL_SECONDS = 30, /* a transfer that moves nothing for so long is dead */
};

struct call {
    CURL *easy;
    struct curl_slist *headers;
    struct http_client_reply reply;
    size_t max_bytes;
    bool too_large;
    void *tag;
    char detail[CURL_ERROR_SIZE];
    struct call *next;
};

struct http_client {
    CURLM *multi;
    char url[256]; /* without the slash at the end */
    struct call *calls;
    atomic_bool stopped; /* any thread sets it, http_client_run reads it */
};

static void init_library(void)
{
    if (curl_global_init(CURL_GLOBAL_ALL)) {
        fputs("libcurl cannot start\n", stderr);
        abort();
    }
}

static bool check_url(const char *url, size_t length, struct err *err)
{
    CURLU *parsed = curl_url();
    char *query = NULL, *path = NULL, *user = NULL;
    bool good = length < sizeof((struct http_client *)0)->url &&
                (!strncasecmp(url, "http://", 7) || !strncasecmp(url, "https://", 8)) &&
                !curl_url_set(parsed, CURLUPART_URL, url, 0);
    if (good) {
        good = curl_url_get(parsed, CURLUPART_QUERY, &query, 0) != CURLUE_OK &&
               curl_url_get(parsed, CURLUPART_USER, &user, 0) != CURLUE_OK &&
               !curl_url_get(parsed, CURLUPART_PATH, &path, 0) && !strcmp(path, "/");
    }
    curl_free(query);
    curl_free(user);
    curl_free(path);
    curl_url_cleanup(parsed);
    return good ||
           err_set(err, ERR_INPUT, "expected an address like http://127.0.0.1:7080, got '%s'", url);
}

struct http_client *http_client_new(const char *url, struct err *err)
{
    static pthread_once_t once = PTHREAD_ONCE_INIT;
    pthread_once(&once, init_library);

    size_t length = strlen(url);
    while (length && url[length - 1] == '/')
        length--;
    if (!check_url(url, length, err))
        return NULL;
    struct http_client *c = arena_malloc(1, sizeof *c);
    snprintf(c->url, sizeof c->url, "%.*s", (int)length, url);
    c->multi = curl_multi_init();
    curl_multi_setopt(c->multi, CURLMOPT_MAX_HOST_CONNECTIONS, 8L);
    atomic_init(&c->stopped, false);
    return c;
}

static void call_free(struct http_client *c, struct call *call)
{
    for (struct call **at = &c->calls; *at; at = &(*at)->next)
        if (*at == call) {
            *at = call->next;
            break;
        }
    curl_multi_remove_handle(c->multi, call->easy);
    curl_easy_cleanup(call->easy);
    curl_slist_free_all(call->headers);
    buf_release(&call->reply.body);
    free(call);
}

void http_client_free(struct http_client *c)
{
    if (!c)
        return;
    while (c->calls)
        call_free(c, c->calls);
    curl_multi_cleanup(c->multi);
    free(c);
}

static size_t on_body(char *data, size_t size, size_t count, void *user)
{
    struct call *call = user;
    const size_t bytes = size * count;
    if (bytes > call->max_bytes - call->reply.body.size) {
        call->too_large = true;
        return 0; /* not `bytes`: the transfer is broken off */
    }
    buf_append(&call->reply.body, data, bytes);
    return bytes;
}

static size_t on_header(char *data, size_t size, size_t count, void *user)
{
    struct call *call = user;
    const size_t bytes = size * count;
    if (bytes > 5 && !strncasecmp(data, "etag:", 5)) {
        const char *begin = data + 5, *end = data + bytes;
        while (begin < end && *begin == ' ')
            begin++;
        while (end > begin && (unsigned char)end[-1] <= ' ')
            end--;
        if ((size_t)(end - begin) < sizeof call->reply.etag)
            snprintf(call->reply.etag, sizeof call->reply.etag, "%.*s", (int)(end - begin), begin);
    }
    return bytes;
}

static void add_header(struct call *call, const char *name, const char *value)
{
    char line[256];
    snprintf(line, sizeof line, "%s: %s", name, value);
    call->headers = curl_slist_append(call->headers, line);
}

static void set_body(struct call *call, const struct http_client_request *r)
{
    if (r->content_type) {
        curl_easy_setopt(call->easy, CURLOPT_POSTFIELDS, r->body_bytes ? r->body : "");
        curl_easy_setopt(call->easy, CURLOPT_POSTFIELDSIZE_LARGE, (curl_off_t)r->body_bytes);
        add_header(call, "Content-Type", r->content_type);
        /* Else a large body waits up to a second for "100 Continue". */
        call->headers = curl_slist_append(call->headers, "Expect:");
    } else if (!strcmp(r->method, "POST")) {
        curl_easy_setopt(call->easy, CURLOPT_POSTFIELDS, "");
        curl_easy_setopt(call->easy, CURLOPT_POSTFIELDSIZE_LARGE, (curl_off_t)0);
        call->headers = curl_slist_append(call->headers, "Content-Type:");
    }
    if (!strcmp(r->method, "HEAD"))
        curl_easy_setopt(call->easy, CURLOPT_NOBODY, 1L);
    else
        curl_easy_setopt(call->easy, CURLOPT_CUSTOMREQUEST, r->method);
    if (r->if_none_match && *r->if_none_match)
        add_header(call, "If-None-Match", r->if_none_match);
    curl_easy_setopt(call->easy, CURLOPT_HTTPHEADER, call->headers);
}

void http_client_start(struct http_client *c, const struct http_client_request *r, void *tag)
{
    struct call *call = arena_malloc(1, sizeof *call);
    call->tag = tag;
    call->max_bytes = r->max_bytes;
    call->next = c->calls;
    c->calls = call;
    CURL *easy = call->easy = curl_easy_init();

    char url[sizeof c->url + 512];
    snprintf(url, sizeof url, "%s%s", c->url, r->path);
    curl_easy_setopt(easy, CURLOPT_URL, url);
    curl_easy_setopt(easy, CURLOPT_PROTOCOLS_STR, "http,https");
    curl_easy_setopt(easy, CURLOPT_HTTP_VERSION, (long)CURL_HTTP_VERSION_1_1);
    curl_easy_setopt(easy, CURLOPT_PROXY, "");
    curl_easy_setopt(easy, CURLOPT_NOSIGNAL, 1L);
    curl_easy_setopt(easy, CURLOPT_TCP_NODELAY, 1L);
    curl_easy_setopt(easy, CURLOPT_TCP_KEEPALIVE, 1L);
    curl_easy_setopt(easy, CURLOPT_USERAGENT, "smalti/" SMALTI_VERSION);
    curl_easy_setopt(easy, CURLOPT_CONNECTTIMEOUT_MS, (long)CONNECT_MS);
    if (r->timeout_ms) {
        curl_easy_setopt(easy, CURLOPT_TIMEOUT_MS, (long)r->timeout_ms);
    } else {
        curl_easy_setopt(easy, CURLOPT_LOW_SPEED_LIMIT, 1L);
        curl_easy_setopt(easy, CURLOPT_LOW_SPEED_TIME, (long)STALL_SECONDS);
    }
    curl_easy_setopt(easy, CURLOPT_ERRORBUFFER, call->detail);
    curl_easy_setopt(easy, CURLOPT_WRITEFUNCTION, on_body);
    curl_easy_setopt(easy, CURLOPT_WRITEDATA, call);
    curl_easy_setopt(easy, CURLOPT_HEADERFUNCTION, on_header);
    curl_easy_setopt(easy, CURLOPT_HEADERDATA, call);
    curl_easy_setopt(easy, CURLOPT_PRIVATE, call);
    set_body(call, r);
    curl_multi_add_handle(c->multi, easy);
}

static void finish(struct http_client *c, struct call *call, CURLcode code,
                   struct http_client_reply *reply)
{
    struct http_client_reply *r = &call->reply;
    long status = 0;
    if (code == CURLE_OK)
        curl_easy_getinfo(call->easy, CURLINFO_RESPONSE_CODE, &status);
    r->status = (int)status;
    if (call->too_large)
        err_set(&r->err, ERR_PROTOCOL, "%s: the answer is larger than %zu bytes", c->url,
                call->max_bytes);
    else if (!status)
        err_set(&r->err, ERR_IO, "%s: %s", c->url,
                *call->detail ? call->detail : curl_easy_strerror(code));
    if (!status)
        buf_release(&r->body);
    *reply = *r;
    r->body = (struct buf){0}; /* now the receiver's */
}

/* A call that has ended, if there is one. */
static bool take(struct http_client *c, void **tag, struct http_client_reply *reply)
{
    int left;
    for (CURLMsg *m; (m = curl_multi_info_read(c->multi, &left));) {
        if (m->msg != CURLMSG_DONE)
            continue;
        struct call *call = NULL;
        const CURLcode code = m->data.result; /* m dies with the handle */
        curl_easy_getinfo(m->easy_handle, CURLINFO_PRIVATE, (char **)&call);
        finish(c, call, code, reply);
        *tag = call->tag;
        call_free(c, call);
        return true;
    }
    return false;
}

bool http_client_poll(struct http_client *c, int64_t timeout_ms, const int *fds, size_t fd_count,
                      void **tag, struct http_client_reply *reply)
{
    struct curl_waitfd extra[MAX_FDS];
    fd_count = min_size(fd_count, MAX_FDS);
    for (size_t i = 0; i < fd_count; i++)
        extra[i] = (struct curl_waitfd){.fd = fds[i], .events = CURL_WAIT_POLLIN};

    int running;
    curl_multi_perform(c->multi, &running);
    if (take(c, tag, reply))
        return true;
    curl_multi_poll(c->multi, extra, (unsigned)fd_count, (int)min_i64(timeout_ms, 60000), NULL);
    curl_multi_perform(c->multi, &running);
    return take(c, tag, reply);
}

bool http_client_run(struct http_client *c, const struct http_client_request *r,
                     struct http_client_reply *reply, struct err *err)
{
    void *tag;
    http_client_start(c, r, NULL);
    while (!atomic_load(&c->stopped))
        if (http_client_poll(c, 1000, NULL, 0, &tag, reply)) {
            if (!reply->status)
                *err = reply->err;
            return reply->status != 0;
        }
    call_free(c, c->calls);
    return err_set(err, ERR_IO, "%s: stopped", c->url);
}

void http_client_stop(struct http_client *c)
{
    atomic_store(&c->stopped, true);
    curl_multi_wakeup(c->multi);
}
