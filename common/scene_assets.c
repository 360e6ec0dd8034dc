/* A document with its files named by content, everything else byte for byte as written.
 *
 * Works on the text, since the JSON library would print every number anew. The text has passed
 * scene_parse, so this walk meets only well-formed JSON whose depth is bounded.
 * SPDX-License-Identifier: MIT */
#include "common/scene.h"

#include <assert.h>
#include <string.h>

#include "common/buf.h"
#include "common/image_asset.h"
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

struct file_pieces { /* begin NULL: the object names no file */
    struct piece key, file;
};

/* Only meshes and images have that key. */
static struct file_pieces file_scan(struct piece object, struct arena *arena)
{
    struct file_pieces f = {0};
    struct walk w = {object.begin, object.end};
    struct piece key, value;
    enter(&w);
    while (member_next(&w, &key, &value))
        if (!strcmp(ascii_of(key, arena), "file"))
            f = (struct file_pieces){key, value};
    return f;
}

static const char *format_name(const char *file)
{
    enum mesh_format mesh;
    enum image_format image;
    if (mesh_format_of(file, &mesh))
        return mesh == MESH_OBJ ? "obj" : "ply";
    const bool known = image_asset_format_of(file, &image);
    assert(known);
    return known ? image_asset_formats[image] : NULL;
}

struct copy { /* what has been written of a document, and from where on the rest is */
    struct buf out;
    const char *copied;
};

static void copy_until(struct copy *c, const char *end)
{
    buf_append(&c->out, c->copied, (size_t)(end - c->copied));
    c->copied = end;
}

static void name_file(struct copy *c, const struct file_pieces *f, const char *hex,
                      struct arena *arena)
{
    const char *text = arena_printf(arena, "\"asset\": \"%s\", \"format\": \"%s\"", hex,
                                    format_name(ascii_of(f->file, arena)));
    copy_until(c, f->key.begin);
    buf_append(&c->out, text, strlen(text));
    c->copied = f->file.end;
}

/* The items of an array, or the values of an object. */
static void name_files(struct copy *c, struct piece list, const char (*hex)[HASH_HEX],
                       struct arena *arena)
{
    struct walk w = {list.begin, list.end};
    struct piece key, item;
    const bool by_name = look(&w) == '{';
    enter(&w);
    for (size_t i = 0; by_name ? member_next(&w, &key, &item) : item_next(&w, &item); i++) {
        const struct file_pieces f = file_scan(item, arena);
        if (f.file.begin)
            name_file(c, &f, hex[i], arena);
    }
}

const char *scene_name_assets(const char *json, size_t bytes, const struct scene_hashes *hashes,
                              struct arena *arena)
{
    const struct {
        const char *key;
        const char (*hex)[HASH_HEX];
    } lists[] = {
        {"textures", hashes->textures}, {"shapes", hashes->shapes}, {"lights", hashes->lights}};
    struct walk whole = {json, json + bytes};
    struct copy c = {.copied = json};
    struct piece key, value;
    enter(&whole);
    while (member_next(&whole, &key, &value))
        for (size_t i = 0; i < countof(lists); i++)
            if (!strcmp(ascii_of(key, arena), lists[i].key))
                name_files(&c, value, lists[i].hex, arena);
    copy_until(&c, json + bytes);
    buf_append(&c.out, "", 1);
    const char *text = arena_strdup(arena, (const char *)c.out.data);
    buf_release(&c.out);
    return text;
}
