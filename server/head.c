/* SPDX-License-Identifier: MIT */
#include "server/head.h"

#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "server/problem.h"

void head_add(struct head *h, const char *name, const char *value)
{
    if (!strcasecmp(name, "Host")) {
        h->host_count++;
        h->host = value;
    } else if (!strcasecmp(name, "Content-Length")) {
        h->length_count++;
        h->length_bytes = strtoull(value, NULL, 10); /* the library has checked that it is one */
    } else if (!strcasecmp(name, "Transfer-Encoding")) {
        h->transfer_count++;
        h->transfer = value;
    } else if (!strcasecmp(name, "Content-Type")) {
        h->content_type = value;
    } else if (!strcasecmp(name, "If-None-Match")) {
        h->if_none_match = value;
    }
}

static bool check_framing(const struct head *h, const struct request *rq, struct reply *re)
{
    if (strcmp(h->version, "HTTP/1.1") != 0 && strcmp(h->version, "HTTP/1.0") != 0)
        problem_reply(rq, re, 400, "expected HTTP/1.1 or HTTP/1.0");
    else if (!h->target_is_sane)
        problem_reply(rq, re, 400, "malformed request target");
    else if (h->length_count > 1 || h->transfer_count > 1 ||
             (h->length_count && h->transfer_count))
        problem_reply(rq, re, 400, "the length of the body is given more than once");
    else if (h->transfer_count && strcasecmp(h->transfer, "chunked") != 0)
        problem_reply(rq, re, 400, "Transfer-Encoding: expected chunked");
    else if (h->host_count != 1)
        problem_reply(rq, re, 400, "expected one Host header, got %u", h->host_count);
    else if (!route_host_is_loopback(h->host))
        problem_reply(rq, re, 421, "Host: expected a loopback name, got '%.100s'", h->host);
    return re->status == 0;
}

static bool check_route(const struct head *h, const struct route *routes, size_t count,
                        struct request *rq, struct reply *re)
{
    switch (route_find(routes, count, route_method_of(h->method), rq, re)) {
    case ROUTE_FOUND:
        return true;
    case ROUTE_WRONG_METHOD:
        problem_reply(rq, re, 405, "%.20s: expected %s", h->method, re->allow);
        return false;
    case ROUTE_NONE:
        problem_reply(rq, re, 404, "no such route: %.200s", rq->path);
        return false;
    }
    __builtin_unreachable();
}

/* Sizes are refused before the first byte is taken ("Expect: 100-continue" then costs nothing). */
static bool check_body(const struct head *h, const struct request *rq, struct reply *re)
{
    const struct route *route = rq->route;
    const bool some = h->transfer_count || h->length_bytes > 0;
    const bool may_lack = route->flags & ROUTE_OPTIONAL && !some;
    if (h->length_bytes > route->body_limit || (some && !route->media))
        problem_reply(rq, re, 413, "body: expected at most %llu bytes",
                      (unsigned long long)route->body_limit);
    else if (route->media && !may_lack && !route_media_is(h->content_type, route->media))
        problem_reply(rq, re, 415, "Content-Type: expected %s, got '%.100s'", route->media,
                      h->content_type ? h->content_type : "");
    return re->status == 0;
}

bool head_check(const struct head *h, const struct route *routes, size_t count, struct request *rq,
                struct reply *re)
{
    return check_framing(h, rq, re) && check_route(h, routes, count, rq, re) &&
           check_body(h, rq, re);
}
