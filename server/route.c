/* SPDX-License-Identifier: MIT */
#include "server/route.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

static const char *const method_names[] = {
    [ROUTE_GET] = "GET",     [ROUTE_POST] = "POST",     [ROUTE_PUT] = "PUT",
    [ROUTE_PATCH] = "PATCH", [ROUTE_DELETE] = "DELETE",
};
_Static_assert(countof(method_names) == ROUTE_OTHER, "one name per method");

enum route_method route_method_of(const char *name)
{
    if (!strcmp(name, "HEAD"))
        return ROUTE_GET;
    for (size_t i = 0; i < countof(method_names); i++)
        if (!strcmp(name, method_names[i]))
            return (enum route_method)i;
    return ROUTE_OTHER;
}

/* Both walk segment by segment; a star takes one segment that is not empty. */
static bool matches(const char *pattern, const char *path, struct arena *arena, const char **part)
{
    size_t stars = 0;
    while (*pattern && *path) {
        if (*pattern != '*') {
            if (*pattern++ != *path++)
                return false;
            continue;
        }
        const size_t n = strcspn(path, "/");
        if (!n)
            return false;
        part[stars++] = arena_printf(arena, "%.*s", (int)n, path);
        pattern++;
        path += n;
    }
    return !*pattern && !*path;
}

enum route_match route_find(const struct route *routes, size_t count, enum route_method method,
                            struct request *rq, struct reply *reply)
{
    const char *allow = NULL;
    for (size_t i = 0; i < count; i++) {
        const char *part[2] = {NULL, NULL};
        if (!matches(routes[i].pattern, rq->path, rq->arena, part))
            continue;
        if (routes[i].method == method) {
            rq->route = &routes[i];
            memcpy(rq->part, part, sizeof part);
            return ROUTE_FOUND;
        }
        const char *name = routes[i].method == ROUTE_GET ? "GET, HEAD"
                                                         : method_names[routes[i].method];
        allow = allow ? arena_printf(rq->arena, "%s, %s", allow, name) : name;
    }
    reply->allow = allow;
    return allow ? ROUTE_WRONG_METHOD : ROUTE_NONE;
}

const char *route_query(const struct request *rq, const char *name)
{
    for (size_t i = 0; i < rq->query_count; i++)
        if (!strcmp(rq->query[i].name, name))
            return rq->query[i].value;
    return NULL;
}

bool route_query_int(const struct request *rq, const char *name, int64_t least, int64_t most,
                     int64_t otherwise, int64_t *out, struct err *err)
{
    const char *text = route_query(rq, name);
    *out = otherwise;
    if (!text)
        return true;
    const char *digits = text + (*text == '-');
    const size_t n = strlen(digits);
    const long long v = n && n <= 18 && strspn(digits, "0123456789") == n ? atoll(text) : least - 1;
    if (v < least || v > most)
        return err_set(err, ERR_INPUT, "%s: expected a whole number from %lld to %lld, got '%s'", name,
                       (long long)least, (long long)most, text);
    *out = v;
    return true;
}

bool route_media_is(const char *type, const char *media)
{
    const size_t n = strlen(media);
    if (!type || strncasecmp(type, media, n) != 0)
        return false;
    const char *rest = type + n + strspn(type + n, " \t");
    return *rest == '\0' || *rest == ';';
}

static bool port_is_sane(const char *text)
{
    if (*text == '\0')
        return true;
    const size_t n = strspn(text + 1, "0123456789");
    return *text == ':' && n <= 5 && text[1 + n] == '\0';
}

bool route_host_is_loopback(const char *host)
{
    if (!strncasecmp(host, "localhost", 9))
        return port_is_sane(host + 9);
    if (!strncmp(host, "[::1]", 5))
        return port_is_sane(host + 5);
    unsigned a, b, c;
    int used = 0;
    if (sscanf(host, "127.%3u.%3u.%3u%n", &a, &b, &c, &used) != 3 || a > 255 || b > 255 || c > 255)
        return false;
    return port_is_sane(host + used) && strspn(host, "0123456789.:") == strlen(host);
}

bool route_target_is_sane(const char *raw)
{
    if (*raw != '/')
        return false;
    for (const char *at = raw; *at; at++) {
        if (*at <= ' ' || *at >= 0x7f)
            return false; /* controls, and, char being signed here, bytes above 127 */
        if (*at != '%')
            continue;
        const size_t hex = strspn(at + 1, "0123456789abcdefABCDEF");
        if (hex < 2 || (at[1] == '0' && at[2] == '0'))
            return false;
    }
    return true;
}

bool route_etag_matches(const char *header, const char *etag)
{
    if (!header || !etag)
        return false;
    if (!strcmp(header, "*"))
        return true;
    const char *at = strstr(header, etag); /* etag carries its quotes: no partial match */
    return at != NULL;
}
