/* Every json_t here is owned by the function that makes it and released before it returns.
 * SPDX-License-Identifier: MIT */
#include "server/problem.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <jansson.h>

static const char *title_of(int status)
{
    static const struct {
        int status;
        const char *title;
    } titles[] = {
        {400, "Bad Request"},         {404, "Not Found"},
        {405, "Method Not Allowed"},  {409, "Conflict"},
        {413, "Content Too Large"},   {415, "Unsupported Media Type"},
        {421, "Misdirected Request"}, {422, "Unprocessable Content"},
        {503, "Service Unavailable"},
    };
    for (size_t i = 0; i < countof(titles); i++)
        if (titles[i].status == status)
            return titles[i].title;
    return "Error";
}

/* Borrows `root`. */
static void send_document(const struct request *rq, struct reply *reply, int status, json_t *root)
{
    char *text = json_dumps(root, JSON_COMPACT);
    reply->status = status;
    reply->type = "application/problem+json";
    reply->body = arena_strdup(rq->arena, text);
    reply->body_bytes = strlen(text);
    reply->retry_after_s = status == 503 ? 1 : 0;
    free(text);
}

/* `detail` may quote a peer: bytes that are not UTF-8 would make jansson refuse the string. */
static json_t *document(int status, const char *detail)
{
    json_t *text = json_string(detail);
    return json_pack("{s:s, s:s, s:i, s:o}", "type", "about:blank", "title", title_of(status),
                     "status", status, "detail", text ? text : json_string("malformed text"));
}

void problem_reply(const struct request *rq, struct reply *reply, int status, const char *fmt, ...)
{
    char detail[768];
    va_list ap;
    va_start(ap, fmt);
    vsnprintf(detail, sizeof detail, fmt, ap);
    va_end(ap);
    json_t *root = document(status, detail);
    send_document(rq, reply, status, root);
    json_decref(root);
}

static int status_of(enum err_code code)
{
    switch (code) {
    case ERR_INPUT:
    case ERR_PROTOCOL:
        return 400;
    case ERR_LIMIT:
        return 413;
    case ERR_NOT_FOUND:
        return 404;
    case ERR_CONFLICT:
        return 409;
    case ERR_IO:
        return 503;
    }
    __builtin_unreachable();
}

void problem_from_err(const struct request *rq, struct reply *reply, const struct err *err)
{
    problem_reply(rq, reply, status_of(err->code), "%s", err->text);
}

void problem_scene(const struct request *rq, struct reply *reply, const struct scene_errors *errors)
{
    const struct scene_error *first = &errors->list[0];
    if (errors->count == 1 && !strncmp(first->where, "line ", 5)) {
        problem_reply(rq, reply, 400, "%s: %s", first->where, first->what);
        return;
    }
    char detail[64];
    snprintf(detail, sizeof detail, "%zu error%s in the scene document", errors->count,
             errors->count == 1 ? "" : "s");
    json_t *root = document(422, detail), *list = json_array();
    for (size_t i = 0; i < errors->count; i++)
        json_array_append_new(list, json_pack("{s:s, s:s}", "pointer", errors->list[i].where,
                                              "detail", errors->list[i].what));
    json_object_set_new(root, "errors", list);
    send_document(rq, reply, 422, root);
    json_decref(root);
}

void problem_missing(const struct request *rq, struct reply *reply, const char *const *hex,
                     size_t count)
{
    json_t *root = document(409, "assets are missing: PUT them, then submit again");
    json_t *list = json_array();
    for (size_t i = 0; i < count; i++)
        json_array_append_new(list, json_string(hex[i]));
    json_object_set_new(root, "missing_assets", list);
    send_document(rq, reply, 409, root);
    json_decref(root);
}
