/* http.h - libmicrohttpd on one side, struct request and struct reply on the other.
 *
 * Pool threads collect a request (refusing what is malformed, too large or of the wrong type),
 * run its route's `prepare`, push it into `inbox` as MESSAGE_REQUEST and suspend the connection.
 * The owner thread fills http_reply and calls http_answer, once per exchange; until then the
 * exchange and its request belong to the owner.
 * SPDX-License-Identifier: MIT */
#ifndef SERVER_HTTP_H
#define SERVER_HTTP_H

#include "server/config.h"
#include "server/queue.h"
#include "server/route.h"

struct http; /* opaque */

struct http_setup {
    const struct config *config;
    const struct route *routes; /* outlive the server */
    size_t route_count;
    struct queue *inbox;
};

struct http *http_start(const struct http_setup *, struct err *); /* NULL: could not listen */
uint16_t http_port(const struct http *);

struct request *http_request(struct exchange *);
struct reply *http_reply(struct exchange *);
void http_answer(struct exchange *);
bool http_peer_is_gone(struct exchange *); /* a parked client that closed its connection */

void http_reap(struct http *, int64_t now_ms); /* ends connections that dawdle; call every second */

/* Stopping: new requests are refused from http_close on; the owner answers what is left in the
 * inbox until http_is_quiet; then http_stop waits a moment for answers to leave, and frees. */
void http_close(struct http *);
bool http_is_quiet(struct http *);
void http_stop(struct http *);

enum { HTTP_MAX_CONNECTIONS = 480, HTTP_POOL = 4 };

#endif
