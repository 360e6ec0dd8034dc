/* http_client.h - HTTP requests as function calls, over connections that are kept.
 *
 * A client belongs to one server. Calls may run side by side: start several, then poll for
 * whichever ends first; or run one and wait. An answer of any status is an answer; what a
 * status means is the caller's business. Redirects are not followed, proxies not asked.
 *
 * Thread-safety: one thread at a time per client, but for http_client_stop.
 * Errors: ERR_IO no answer came (may be tried again), ERR_PROTOCOL the answer is larger than
 * was allowed, ERR_INPUT the address makes no sense.
 * SPDX-License-Identifier: MIT */
#ifndef COMMON_HTTP_CLIENT_H
#define COMMON_HTTP_CLIENT_H

#include "common/buf.h"
#include "common/err.h"

struct http_client; /* opaque, heap */

struct http_client_request {
    const char *method;       /* "GET" */
    const char *path;         /* "/v1/jobs?limit=2" */
    const char *content_type; /* NULL: no body */
    const void *body;         /* borrowed until the call is over */
    size_t body_bytes;
    const char *if_none_match; /* an ETag, or NULL */
    size_t max_bytes;          /* of the answer's body */
    int64_t timeout_ms;        /* of the whole call; 0: as long as bytes keep coming */
};

struct http_client_reply {
    int status;      /* 0: there is none, `err` says why */
    struct buf body; /* the receiver's: buf_release */
    char etag[80];   /* "" when absent or longer */
    struct err err;
};

/* url: http://HOST[:PORT], at most a slash behind it. NULL: `err` is set. */
struct http_client *http_client_new(const char *url, struct err *err);
void http_client_free(struct http_client *); /* calls that still run are dropped */

void http_client_start(struct http_client *, const struct http_client_request *, void *tag);

/* Waits for a call to end, for one of `fds` to become readable or for the time to pass.
 * True: a call has ended. */
bool http_client_poll(struct http_client *, int64_t timeout_ms, const int *fds, size_t fd_count,
                      void **tag, struct http_client_reply *);

/* Starts one call and waits for its end; no other may be running. */
bool http_client_run(struct http_client *, const struct http_client_request *,
                     struct http_client_reply *, struct err *) MUST_CHECK;

/* From any thread: the run that waits now and all later ones fail with ERR_IO. */
void http_client_stop(struct http_client *);

#endif
