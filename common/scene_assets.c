/* A document with its mesh files named by content, everything else byte for byte as written.
 *
 * Works on the text, since the JSON library would print every number anew. The text has passed
 * scene_parse, so this walk meets only well-formed JSON whose depth is bounded.
 * SPDX-License-Identifier: MIT */
#include "common/scene.h"

#include <assert.h>
#include <string.h>

#include "common/buf.h"
#include "common/mesh.h"

struct walk { /* borrowed text; `at` is the next byte to look at */
    const char *at, *end;
};

struct piece { /* a token or a value of the text */
    const char *begin, *end;
};

static char look(struct walk *w) /* at the next token's first byte; 0 at the end */
{
    while (w->at < w->end && strchr(" \t\r\n", *w->at))
        w->at++;
    return (char)(w->at < w->end ? *w->at : 0);
}

static struct piece string_next(struct walk *w)
{
    look(w);
    struct piece p = {.begin = w->at++};
    while (w->at < w->end && *w->at != '"')
        w->at += *w->at == '\\' ? 2 : 1;
    p.end = ++w->at;
    return p;
}

static struct piece value_next(struct walk *w)
{
    look(w);
    struct piece p = {.begin = w->at};
    size_t depth = 0;
    do {
        switch (look(w)) {
        case '"':
            string_next(w);
            break;
        case '[':
        case '{':
            depth++;
            w->at++;
            break;
        case ']':
        case '}':
            depth--;
            w->at++;
            break;
        case ',':
        case ':':
            w->at++;
            break;
        default: /* a number or a word */
            while (w->at < w->end && !strchr(",:]} \t\r\n", *w->at))
                w->at++;
        }
    } while (depth > 0 && w->at < w->end);
    p.end = w->at;
    return p;
}

/* Steps into an object or array, and from there to its members. */
static void enter(struct walk *w)
{
    look(w);
    w->at++;
}

static bool member_next(struct walk *w, struct piece *key, struct piece *value)
{
    if (look(w) == ',')
        w->at++;
    if (look(w) != '"')
        return false;
    *key = string_next(w);
    look(w);
    w->at++; /* the colon */
    *value = value_next(w);
    return true;
}

static bool item_next(struct walk *w, struct piece *value)
{
    if (look(w) == ',')
        w->at++;
    if (look(w) == ']' || w->at == w->end)
        return false;
    *value = value_next(w);
    return true;
}

static int hex_digit(char c)
{
    return c <= '9' ? c - '0' : (c | 0x20) - 'a' + 10;
}

/* A string token's text without escapes, as far as it is ASCII; anything else becomes '?'. Names of
 * keys and endings of file names are all that is asked of it. */
static const char *ascii_of(struct piece s, struct arena *arena)
{
    char *out = arena_new(arena, char, (size_t)(s.end - s.begin)), *o = out;
    for (const char *p = s.begin + 1; p < s.end - 1; p++) {
        int c = (unsigned char)*p;
        if (c == '\\' && *++p == 'u') {
            c = 0;
            for (int digit = 0; digit < 4; digit++)
                c = c * 16 + hex_digit(*++p);
        } else if (c == '\\') {
            c = strchr("\"\\/", *p) ? *p : '?';
        }
        *o++ = (char)(c > 0 && c < 0x80 ? c : '?');
    }
    return out;
}

struct shape_pieces {
    bool is_mesh;
    struct piece file_key, file; /* begin NULL: no file */
};

static struct shape_pieces shape_scan(struct piece object, struct arena *arena)
{
    struct shape_pieces s = {0};
    struct walk w = {object.begin, object.end};
    struct piece key, value;
    enter(&w);
    while (member_next(&w, &key, &value)) {
        const char *name = ascii_of(key, arena);
        if (!strcmp(name, "type"))
            s.is_mesh = !strcmp(ascii_of(value, arena), "mesh");
        if (!strcmp(name, "file")) {
            s.file_key = key;
            s.file = value;
        }
    }
    return s;
}

/* The shapes of a document; false when it has none. */
static bool shapes_find(struct walk whole, struct walk *shapes, struct arena *arena)
{
    struct piece key, value;
    enter(&whole);
    while (member_next(&whole, &key, &value))
        if (!strcmp(ascii_of(key, arena), "shapes")) {
            *shapes = (struct walk){value.begin, value.end};
            return true;
        }
    return false;
}

static void name_append(struct buf *out, struct piece file, const char *hex, struct arena *arena)
{
    enum mesh_format format = MESH_INLINE;
    const bool known = mesh_format_of(ascii_of(file, arena), &format);
    assert(known);
    const char *text = arena_printf(arena, "\"asset\": \"%s\", \"format\": \"%s\"", hex,
                                    known && format == MESH_OBJ ? "obj" : "ply");
    buf_append(out, text, strlen(text));
}

const char *scene_name_assets(const char *json, size_t bytes, const char (*asset_hex)[HASH_HEX],
                              struct arena *arena)
{
    struct walk shapes;
    struct buf out = {0};
    const char *copied = json;
    if (shapes_find((struct walk){json, json + bytes}, &shapes, arena)) {
        struct piece item;
        enter(&shapes);
        for (size_t shape = 0; item_next(&shapes, &item); shape++) {
            const struct shape_pieces s = shape_scan(item, arena);
            if (s.is_mesh && s.file.begin) {
                buf_append(&out, copied, (size_t)(s.file_key.begin - copied));
                name_append(&out, s.file, asset_hex[shape], arena);
                copied = s.file.end;
            }
        }
    }
    buf_append(&out, copied, (size_t)(json + bytes - copied));
    buf_append(&out, "", 1);
    const char *text = arena_strdup(arena, (const char *)out.data);
    buf_release(&out);
    return text;
}
