/* route.h - what a handler sees: a request that was checked, and the reply it fills.
 *
 * A request's memory (names, query, body, decoded body, the reply's text) is its arena's, which
 * lives until the reply is sent. `prepare` runs in a pool thread and touches nothing but its
 * request; `handle` runs in the owner thread. Neither knows a socket, so tests call them.
 * SPDX-License-Identifier: MIT */
#ifndef SERVER_ROUTE_H
#define SERVER_ROUTE_H

#include "common/buf.h"
#include "common/scene.h"
#include "common/wire.h"
#include "server/asset.h"

struct exchange; /* the HTTP side of a request (http.c); opaque */
struct server;

enum route_method {
    ROUTE_GET, /* and HEAD */
    ROUTE_POST,
    ROUTE_PUT,
    ROUTE_PATCH,
    ROUTE_DELETE,
    ROUTE_OTHER,
};

struct request_field {
    const char *name, *value;
};

struct request {
    const struct route *route;
    const char *path;
    const char *part[2];          /* what the stars of the route's pattern stand for */
    const char *if_none_match;    /* NULL: absent */
    struct request_field *query;
    size_t query_count;
    struct buf body;              /* empty when spooled */
    struct asset_spool *spool;    /* a ROUTE_SPOOL body, on disk and hashed; else NULL */
    struct scene *scene;          /* decoded by `prepare`; else NULL */
    struct wire_samples *samples; /* decoded by `prepare`; else NULL */
    struct arena *arena;
    struct exchange *exchange; /* for whom parks the request */
};

struct reply {
    int status;              /* 0: not decided yet */
    const char *type;        /* content type; NULL: no body */
    const void *body;        /* memory of the request's arena or static; unused when file >= 0 */
    size_t body_bytes;
    int file;                /* a descriptor whose body_bytes bytes are the body, or -1 */
    const char *etag, *location, *allow; /* NULL: no such header */
    bool immutable;          /* may be cached for ever */
    int retry_after_s;       /* 0: no such header */
    bool parked;             /* the handler keeps the exchange and answers later */
};

typedef void route_handler(struct server *, const struct request *, struct reply *);
typedef void route_prepare(struct request *, struct reply *); /* sets reply->status to refuse */

enum route_flag {
    ROUTE_SPOOL = 1,    /* the body goes to a file */
    ROUTE_OPTIONAL = 2, /* the body may be absent, and its Content-Type then too */
};

struct route {
    enum route_method method;
    const char *pattern; /* "/v1/jobs/" "*": a star is one path segment */
    route_handler *handle;
    uint64_t body_limit; /* bytes; 0: takes no body */
    const char *media;   /* Content-Type of the body; NULL: takes no body */
    route_prepare *prepare;
    unsigned flags;
};

enum route_match { ROUTE_FOUND, ROUTE_WRONG_METHOD, ROUTE_NONE };

/* Fills request->route and ->part; for ROUTE_WRONG_METHOD reply->allow. request->path is set. */
enum route_match route_find(const struct route *routes, size_t count, enum route_method,
                            struct request *, struct reply *);
enum route_method route_method_of(const char *name);

const char *route_query(const struct request *, const char *name); /* NULL: absent */

/* A whole number of the query within [least, most]; `otherwise` when absent. False: malformed. */
bool route_query_int(const struct request *, const char *name, int64_t least, int64_t most,
                     int64_t otherwise, int64_t *out, struct err *) MUST_CHECK;

bool route_media_is(const char *content_type, const char *media); /* parameters may follow */
bool route_host_is_loopback(const char *host);                    /* "localhost:7080", "[::1]" */
bool route_target_is_sane(const char *raw); /* the request target as sent: no %00, no controls */
bool route_etag_matches(const char *if_none_match, const char *etag);

#endif
