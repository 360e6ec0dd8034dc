/* JSON text -> values, by jansson; the only scene file that knows it. Values are borrowed from
 * the parsed tree, which scene_parse owns and releases before it returns.
 * SPDX-License-Identifier: MIT */
#include "common/scene_read.h"

#include <jansson.h>
#include <string.h>

enum scene_type scene_at_type(const struct scene_at *at)
{
    switch (json_typeof((json_t *)at->node)) {
    case JSON_NULL:
        return SCENE_NULL;
    case JSON_TRUE:
    case JSON_FALSE:
        return SCENE_BOOLEAN;
    case JSON_INTEGER:
    case JSON_REAL:
        return SCENE_NUMBER;
    case JSON_STRING:
        return SCENE_STRING;
    case JSON_ARRAY:
        return SCENE_ARRAY;
    case JSON_OBJECT:
        return SCENE_OBJECT;
    }
    __builtin_unreachable();
}

double scene_at_number(const struct scene_at *at)
{
    return json_number_value(at->node) + 0.0; /* -0 + 0 is 0: the sign of zero means nothing here */
}

bool scene_at_boolean(const struct scene_at *at)
{
    return json_is_true((json_t *)at->node);
}

const char *scene_at_string(const struct scene_at *at)
{
    return json_string_value(at->node);
}

size_t scene_at_count(const struct scene_at *at)
{
    return json_is_array((json_t *)at->node) ? json_array_size(at->node)
                                             : json_object_size(at->node);
}

struct scene_at scene_at_item(const struct scene_at *array, size_t index)
{
    return (struct scene_at){
        .up = array, .index = index, .node = json_array_get(array->node, index)};
}

bool scene_at_next(const struct scene_at *object, struct scene_at *member)
{
    void *iter = member->node
                     ? json_object_iter_next(object->node, json_object_key_to_iter(member->key))
                     : json_object_iter(object->node);
    if (!iter)
        return false;
    *member = (struct scene_at){.up = object,
                                .key = json_object_iter_key(iter),
                                .index = member->node ? member->index + 1 : 0,
                                .node = json_object_iter_value(iter)};
    return true;
}

bool scene_at_member(const struct scene_at *object, const char *key, struct scene_at *member)
{
    if (!json_object_get(object->node, key))
        return false;
    *member = (struct scene_at){0};
    while (scene_at_next(object, member) && strcmp(member->key, key))
        continue;
    return true;
}

/* One error that belongs to the text, not to a value. */
static bool text_error(struct scene_errors *errors, enum err_code code, const char *where,
                       const char *what, struct arena *arena)
{
    errors->list = arena_new(arena, struct scene_error, 1);
    errors->list[0] = (struct scene_error){.code = code, .where = where, .what = what};
    errors->count = 1;
    return false;
}

struct position { /* both from 1 */
    size_t line, column;
};

static struct position position_of(const char *text, size_t byte)
{
    struct position p = {1, 1};
    for (size_t i = 0; i < byte; i++) {
        const unsigned char c = (unsigned char)text[i];
        if (c == '\n')
            p = (struct position){p.line + 1, 1};
        else
            p.column += (c & 0xc0) != 0x80; /* characters, not bytes, of UTF-8 */
    }
    return p;
}

static const char *position_print(const char *text, size_t byte, struct arena *arena)
{
    const struct position p = position_of(text, byte);
    return arena_printf(arena, "line %zu, column %zu", p.line, p.column);
}

/* Where nesting exceeds the limit, or `bytes`. Looks at brackets outside of strings only, so it is
 * safe on any text, and the library never sees deep ones. */
static size_t too_deep_at(const char *text, size_t bytes)
{
    size_t depth = 0;
    bool in_string = false;
    for (size_t i = 0; i < bytes; i++) {
        const char c = text[i];
        if (in_string && c == '\\')
            i++;
        else if (c == '"')
            in_string = !in_string;
        else if (!in_string && (c == '[' || c == '{') && ++depth > SCENE_MAX_DEPTH)
            return i;
        else if (!in_string && (c == ']' || c == '}') && depth > 0)
            depth--;
    }
    return bytes;
}

/* The library's words, without what is not text: it quotes the input it stumbled over. */
static char *printable(char *s)
{
    for (char *c = s; *c; c++)
        if ((unsigned char)*c < 0x20 || (unsigned char)*c >= 0x7f)
            *c = '?';
    return s;
}

static const char *syntax_print(json_error_t *e, struct arena *arena)
{
    switch (json_error_code(e)) {
    case json_error_duplicate_key:
        return arena_printf(arena, "%s: each key may stand once", printable(e->text));
    case json_error_numeric_overflow:
        return arena_printf(arena, "%s: numbers are at most 1.7976931348623157e308",
                            printable(e->text));
    case json_error_null_character:
    case json_error_null_byte_in_key:
        return "\\u0000 is not allowed in strings";
    case json_error_unknown:
    case json_error_out_of_memory:
    case json_error_stack_overflow:
    case json_error_cannot_open_file:
    case json_error_invalid_argument:
    case json_error_invalid_utf8:
    case json_error_premature_end_of_input:
    case json_error_end_of_input_expected:
    case json_error_invalid_syntax:
    case json_error_invalid_format:
    case json_error_wrong_type:
    case json_error_null_value:
    case json_error_item_not_found:
    case json_error_index_out_of_range:
        break;
    }
    return arena_printf(arena, "not JSON: %s", printable(e->text));
}

bool scene_parse(struct scene *scene, const char *json, size_t bytes, enum scene_source source,
                 struct arena *arena, struct scene_errors *errors)
{
    *scene = (struct scene){0};
    *errors = (struct scene_errors){0};
    if (bytes > SCENE_MAX_BYTES)
        return text_error(errors, ERR_LIMIT, "",
                          arena_printf(arena, "expected a document of at most %d bytes, got %zu",
                                       SCENE_MAX_BYTES, bytes),
                          arena);
    const size_t deep = too_deep_at(json, bytes);
    if (deep < bytes)
        return text_error(errors, ERR_LIMIT, position_print(json, deep, arena),
                          arena_printf(arena, "nested deeper than %d levels", SCENE_MAX_DEPTH),
                          arena);

    if (bytes >= 3 && !memcmp(json, "\xef\xbb\xbf", 3))
        return text_error(errors, ERR_INPUT, "line 1, column 1",
                          "not JSON: the text begins with a byte order mark", arena);

    /* The library passes over a NUL behind a number. */
    const char *nul = bytes ? memchr(json, 0, bytes) : NULL;
    if (nul)
        return text_error(errors, ERR_INPUT, position_print(json, (size_t)(nul - json), arena),
                          "not JSON: a NUL byte", arena);

    /* Whole numbers as reals: those beyond 2^63 then get an error with their place, too. */
    json_error_t e;
    json_t *root = json_loadb(json, bytes, JSON_REJECT_DUPLICATES | JSON_DECODE_INT_AS_REAL, &e);
    if (!root) {
        const size_t last = e.position > 0 ? (size_t)e.position - 1 : 0;
        return text_error(errors, ERR_INPUT,
                          position_print(json, last < bytes ? last : bytes, arena),
                          syntax_print(&e, arena), arena);
    }
    struct scene_doc doc = {.source = source, .arena = arena};
    const struct scene_at whole = {.node = root};
    scene_read(&doc, &whole, scene);
    json_decref(root);
    scene_doc_report(&doc, errors);
    return doc.total == 0;
}
