/* SPDX-License-Identifier: MIT */
#include "server/body.h"

#include <stdlib.h>
#include <string.h>

#include <jansson.h>

#include "server/problem.h"

json_t *body_parse(const struct request *rq, struct reply *re)
{
    json_error_t e;
    const char *text = rq->body.data ? (const char *)rq->body.data : "";
    json_t *root = json_loadb(text, rq->body.size, JSON_REJECT_DUPLICATES, &e);
    if (root && json_is_object(root))
        return root;
    if (root)
        problem_reply(rq, re, 400, "expected a JSON object");
    else
        problem_reply(rq, re, 400, "line %d, column %d: %s", e.line, e.column, e.text);
    json_decref(root);
    return NULL;
}

void body_reply(const struct request *rq, struct reply *re, int status, json_t *root)
{
    char *text = json_dumps(root, JSON_COMPACT);
    json_decref(root);
    re->status = status;
    re->type = "application/json";
    re->body = arena_strdup(rq->arena, text);
    re->body_bytes = strlen(text);
    free(text);
}
