/* conn.h - the open connections, and how long each may take over what it is doing.
 *
 * libmicrohttpd's timeout is one of inactivity: a client that sends a byte now and then would
 * hold its connection for ever (slow-loris). Here every phase has an allowance from its begin; a body
 * and a download earn time by their bytes. Any thread; conn_reap shuts overdue sockets down.
 * SPDX-License-Identifier: MIT */
#ifndef SERVER_CONN_H
#define SERVER_CONN_H

#include "common/base.h"

enum conn_phase {
    CONN_HEADERS,  /* fresh: the first request line and headers */
    CONN_BODY,     /* receiving */
    CONN_ANSWER,   /* ours: no limit */
    CONN_DOWNLOAD, /* sending */
    CONN_IDLE,     /* between requests, or into the headers of the next one */
};

struct conn;
struct conn_list; /* opaque */

struct conn_list *conn_list_new(void);
void conn_list_free(struct conn_list *);

struct conn *conn_new(struct conn_list *, int fd, int64_t now_ms);
void conn_free(struct conn_list *, struct conn *); /* before the descriptor is closed */
void conn_enter(struct conn_list *, struct conn *, enum conn_phase, uint64_t bytes, int64_t now_ms);
void conn_received(struct conn_list *, struct conn *, uint64_t bytes); /* CONN_BODY earns time */
size_t conn_reap(struct conn_list *, int64_t now_ms);                  /* how many were shut down */

#endif
