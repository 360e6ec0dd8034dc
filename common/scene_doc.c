/* Faults: where they are, in document order, and how values read in messages.
 * SPDX-License-Identifier: MIT */
#include "common/scene_doc.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { SHOWN_BYTES = 48, KEY_BYTES = 200 }; /* of a string, of a key, in a message */

struct text { /* appends what fits */
    char *at, *end;
};

static void put(struct text *t, const char *bytes, size_t n)
{
    const size_t room = (size_t)(t->end - t->at) - 1;
    n = min_size(n, room);
    memcpy(t->at, bytes, n);
    t->at += n;
    *t->at = '\0';
}

/* Bytes of the UTF-8 sequence that begins with c; the library has checked the document's. */
static size_t utf8_length(unsigned char c)
{
    return c < 0x80 ? 1 : c < 0xe0 ? 2 : c < 0xf0 ? 3 : 4;
}

/* Appends at most max_bytes of a string from the document, harmless on a terminal and in a log.
 * In a pointer `~` and `/` are escaped (RFC 6901, section 3), else `"` and `\`. */
static void put_quoted(struct text *t, const char *s, size_t max_bytes, bool pointer)
{
    size_t i = 0;
    while (s[i]) {
        const unsigned char c = (unsigned char)s[i];
        const size_t n = utf8_length(c);
        if (i + n > max_bytes) {
            put(t, "...", 3);
            return;
        }
        char esc[8];
        if (c < 0x20 || c == 0x7f)
            put(t, esc, (size_t)snprintf(esc, sizeof esc, "\\u%04x", c));
        else if (pointer && (c == '~' || c == '/'))
            put(t, c == '~' ? "~0" : "~1", 2);
        else if (!pointer && (c == '"' || c == '\\'))
            put(t, esc, (size_t)snprintf(esc, sizeof esc, "\\%c", c));
        else
            put(t, s + i, n);
        i += n;
    }
}

/* Whole numbers in full, others in the first of 6, 15, 17 digits that reads back the same. */
static size_t number_print(char *out, size_t size, double v)
{
    if (v == floor(v) && fabs(v) < 1e15)
        return (size_t)snprintf(out, size, "%.0f", v);
    for (int digits = 6;; digits += digits < 15 ? 9 : 2) {
        const int n = snprintf(out, size, "%.*g", digits, v);
        if (digits >= 17 || strtod(out, NULL) == v)
            return (size_t)n;
    }
}

void scene_doc_quote(const char *s, char out[SCENE_QUOTE_BYTES])
{
    struct text t = {out, out + SCENE_QUOTE_BYTES};
    put(&t, "\"", 1);
    put_quoted(&t, s, SHOWN_BYTES, false);
    put(&t, "\"", 1);
}

static void put_value(struct text *t, const struct scene_at *at)
{
    char s[64], quoted[SCENE_QUOTE_BYTES];
    switch (scene_at_type(at)) {
    case SCENE_NULL:
        put(t, "null", 4);
        return;
    case SCENE_BOOLEAN:
        put(t, scene_at_boolean(at) ? "true" : "false", scene_at_boolean(at) ? 4 : 5);
        return;
    case SCENE_NUMBER:
        put(t, s, number_print(s, sizeof s, scene_at_number(at)));
        return;
    case SCENE_STRING:
        scene_doc_quote(scene_at_string(at), quoted);
        put(t, quoted, strlen(quoted));
        return;
    case SCENE_ARRAY:
        put(t, s, (size_t)snprintf(s, sizeof s, "an array of %zu", scene_at_count(at)));
        return;
    case SCENE_OBJECT:
        put(t, "an object", 9);
        return;
    }
}

static uint32_t chain(const struct scene_at *at, const struct scene_at *from_root[])
{
    uint32_t depth = 0;
    for (const struct scene_at *p = at; p->up; p = p->up)
        depth++;
    for (uint32_t i = depth; i-- > 0; at = at->up)
        from_root[i] = at;
    return depth;
}

static const char *pointer_print(const struct scene_at *at, struct arena *arena)
{
    const struct scene_at *from_root[SCENE_MAX_DEPTH + 1];
    const uint32_t depth = chain(at, from_root);
    char out[4096];
    struct text t = {out, out + sizeof out};
    *out = '\0';
    for (uint32_t i = 0; i < depth; i++) {
        char number[24];
        put(&t, "/", 1);
        if (from_root[i]->key)
            put_quoted(&t, from_root[i]->key, KEY_BYTES, true);
        else
            put(&t, number, (size_t)snprintf(number, sizeof number, "%zu", from_root[i]->index));
    }
    return arena_strdup(arena, out);
}

static int order_compare(const struct scene_fault *a, const struct scene_fault *b)
{
    for (uint32_t i = 0; i < a->depth && i < b->depth; i++)
        if (a->order[i] != b->order[i])
            return a->order[i] < b->order[i] ? -1 : 1;
    return a->depth < b->depth ? -1 : a->depth > b->depth;
}

/* Makes room for the fault at its place in the order; NULL when a hundred come before it. */
static struct scene_fault *fault_insert(struct scene_doc *doc, const struct scene_fault *fault)
{
    size_t at = doc->kept;
    while (at > 0 && order_compare(fault, &doc->faults[at - 1]) < 0)
        at--;
    doc->total++;
    if (at == SCENE_MAX_FAULTS)
        return NULL;
    if (doc->kept < SCENE_MAX_FAULTS)
        doc->kept++;
    memmove(&doc->faults[at + 1], &doc->faults[at], (doc->kept - 1 - at) * sizeof *fault);
    doc->faults[at] = *fault;
    return &doc->faults[at];
}

static struct scene_fault fault_at(const struct scene_at *at)
{
    const struct scene_at *from_root[SCENE_MAX_DEPTH + 1];
    struct scene_fault f = {.depth = chain(at, from_root)};
    for (uint32_t i = 0; i < f.depth; i++)
        f.order[i] = (uint32_t)from_root[i]->index;
    return f;
}

bool scene_doc_listed(const struct scene_doc *doc, const struct scene_at *at)
{
    const struct scene_fault f = fault_at(at);
    return doc->kept < SCENE_MAX_FAULTS || order_compare(&f, &doc->faults[doc->kept - 1]) < 0;
}

bool scene_doc_fault(struct scene_doc *doc, const struct scene_at *at, enum err_code code,
                     const char *fmt, ...)
{
    const struct scene_fault here = fault_at(at);
    struct scene_fault *f = fault_insert(doc, &here);
    if (!f)
        return false;
    char what[4096];
    va_list ap;
    va_start(ap, fmt);
    vsnprintf(what, sizeof what, fmt, ap);
    va_end(ap);
    f->error.code = code;
    f->error.where = pointer_print(at, doc->arena);
    f->error.what = arena_strdup(doc->arena, what);
    return false;
}

bool scene_doc_expected(struct scene_doc *doc, const struct scene_at *at, enum err_code code,
                        const char *expected)
{
    char got[SCENE_QUOTE_BYTES];
    struct text t = {got, got + sizeof got};
    put_value(&t, at);
    return scene_doc_fault(doc, at, code, "expected %s, got %s", expected, got);
}

const char *scene_doc_pointer(struct scene_doc *doc, const struct scene_at *at)
{
    return pointer_print(at, doc->arena);
}

void scene_doc_report(const struct scene_doc *doc, struct scene_errors *errors)
{
    errors->count = doc->kept;
    errors->list = arena_new(doc->arena, struct scene_error, doc->kept);
    for (size_t i = 0; i < doc->kept; i++)
        errors->list[i] = doc->faults[i].error;
    if (doc->total > doc->kept)
        errors->list[doc->kept - 1] = (struct scene_error){
            .code = ERR_INPUT,
            .where = "",
            .what = arena_printf(doc->arena, "and %zu more errors", doc->total - doc->kept + 1),
        };
}
