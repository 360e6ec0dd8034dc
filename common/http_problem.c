/* jansson: every tree is owned here and released before the function returns; members are borrowed.
 * SPDX-License-Identifier: MIT */
#include "common/http_problem.h"

#include <jansson.h>
#include <stdio.h>
#include <string.h>

static json_t *parse(const struct buf *body)
{
    return body->size ? json_loadb((const char *)body->data, body->size, 0, NULL) : NULL;
}

static const char *member(const json_t *object, const char *key)
{
    const char *text = json_string_value(json_object_get(object, key));
    return text ? text : "";
}

void http_problem_text(int status, const struct buf *body, char *out, size_t out_bytes)
{
    json_t *root = parse(body);
    const char *detail = member(root, "detail");
    if (!*detail)
        detail = member(root, "title");
    snprintf(out, out_bytes, "%d%s%s", status, *detail ? ": " : "", detail);
    json_decref(root);
}

bool http_problem_entry(const struct buf *body, size_t index, char *pointer, size_t pointer_bytes,
                        char *detail, size_t detail_bytes)
{
    json_t *root = parse(body);
    const json_t *entry = json_array_get(json_object_get(root, "errors"), index);
    snprintf(pointer, pointer_bytes, "%s", member(entry, "pointer"));
    snprintf(detail, detail_bytes, "%s", member(entry, "detail"));
    const bool found = entry != NULL;
    json_decref(root);
    return found;
}
