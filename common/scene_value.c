/* Single values of a document: numbers in a range, colours, names, objects with known keys.
 * SPDX-License-Identifier: MIT */
#include "common/scene_doc.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

static bool known(const char *name, const struct scene_key *keys, size_t count)
{
    for (size_t i = 0; i < count; i++)
        if (!strcmp(name, keys[i].name))
            return true;
    return false;
}

enum { MAX_KEYS = 16, LIST_BYTES = 512 };

/* "a, b or c", each in quotes. */
static void names_print(char out[LIST_BYTES], const char *const *names, size_t count)
{
    size_t n = 0;
    *out = '\0';
    for (size_t i = 0; i < count && n < LIST_BYTES; i++) {
        const char *join = i == 0 ? "" : i + 1 < count ? ", " : " or ";
        n += (size_t)snprintf(out + n, LIST_BYTES - n, "%s\"%s\"", join, names[i]);
    }
}

static bool unknown_key(struct scene_doc *doc, const struct scene_at *at, const char *what,
                        const struct scene_key *keys, size_t count)
{
    if (!scene_doc_listed(doc, at))
        return scene_doc_fault(doc, at, ERR_INPUT, "unknown key in %s", what);
    const char *names[MAX_KEYS];
    for (size_t i = 0; i < count; i++)
        names[i] = keys[i].name;
    const char *meant = scene_suggest(at->key, names, count);
    if (meant)
        return scene_doc_fault(doc, at, ERR_INPUT, "unknown key in %s, did you mean \"%s\"?", what,
                               meant);
    char list[LIST_BYTES];
    names_print(list, names, count);
    return scene_doc_fault(doc, at, ERR_INPUT, "unknown key in %s, allowed: %s", what, list);
}

bool scene_doc_object(struct scene_doc *doc, const struct scene_at *at, const char *what,
                      const struct scene_key *keys, size_t count)
{
    if (scene_at_type(at) != SCENE_OBJECT) {
        char expected[64];
        snprintf(expected, sizeof expected, "an object (%s)", what);
        return scene_doc_expected(doc, at, ERR_INPUT, expected);
    }
    bool good = true;
    struct scene_at member = {0};
    while (scene_at_next(at, &member))
        if (!known(member.key, keys, count))
            good = unknown_key(doc, &member, what, keys, count);
    for (size_t i = 0; i < count; i++)
        if (keys[i].required && !scene_at_member(at, keys[i].name, &member))
            good =
                scene_doc_fault(doc, at, ERR_INPUT, "%s needs the key \"%s\"", what, keys[i].name);
    return good;
}

static bool out_of_range(struct scene_doc *doc, const struct scene_at *at, const char *kind,
                         struct scene_range range)
{
    const bool too_large = scene_at_type(at) == SCENE_NUMBER && scene_at_number(at) > range.hi;
    char expected[96];
    snprintf(expected, sizeof expected, "%s in [%.16g, %.16g]", kind, range.lo, range.hi);
    return scene_doc_expected(doc, at, range.limit && too_large ? ERR_LIMIT : ERR_INPUT, expected);
}

/* False for a NaN. */
static bool inside(double v, struct scene_range range)
{
    return v >= range.lo && v <= range.hi;
}

bool scene_doc_number(struct scene_doc *doc, const struct scene_at *at, struct scene_range range,
                      double *out)
{
    if (scene_at_type(at) != SCENE_NUMBER || !inside(scene_at_number(at), range))
        return out_of_range(doc, at, "a number", range);
    *out = scene_at_number(at);
    return true;
}

bool scene_doc_integer(struct scene_doc *doc, const struct scene_at *at, struct scene_range range,
                       uint64_t *out)
{
    if (scene_at_type(at) != SCENE_NUMBER || !inside(scene_at_number(at), range) ||
        scene_at_number(at) != floor(scene_at_number(at)))
        return out_of_range(doc, at, "a whole number", range);
    *out = (uint64_t)scene_at_number(at);
    return true;
}

bool scene_doc_numbers(struct scene_doc *doc, const struct scene_at *at, struct scene_range range,
                       double *out, size_t count)
{
    if (scene_at_type(at) != SCENE_ARRAY || scene_at_count(at) != count) {
        char expected[64];
        snprintf(expected, sizeof expected, "an array of %zu numbers", count);
        return scene_doc_expected(doc, at, ERR_INPUT, expected);
    }
    bool good = true;
    for (size_t i = 0; i < count; i++) {
        const struct scene_at item = scene_at_item(at, i);
        good &= scene_doc_number(doc, &item, range, &out[i]);
    }
    return good;
}

bool scene_doc_rgb(struct scene_doc *doc, const struct scene_at *at, struct scene_range range,
                   rgb *out)
{
    double c[3];
    if (scene_at_type(at) == SCENE_NUMBER) {
        if (!scene_doc_number(doc, at, range, &c[0]))
            return false;
        c[1] = c[2] = c[0];
    } else if (scene_at_type(at) != SCENE_ARRAY || scene_at_count(at) != 3) {
        return scene_doc_expected(doc, at, ERR_INPUT, "a color (three numbers, or one for gray)");
    } else if (!scene_doc_numbers(doc, at, range, c, 3)) {
        return false;
    }
    *out = vec3_make((float)c[0], (float)c[1], (float)c[2]);
    return true;
}

bool scene_doc_array(struct scene_doc *doc, const struct scene_at *at, const char *of,
                     size_t min_count, size_t max_count)
{
    char expected[96];
    if (scene_at_type(at) != SCENE_ARRAY) {
        snprintf(expected, sizeof expected, "an array of %s", of);
        return scene_doc_expected(doc, at, ERR_INPUT, expected);
    }
    if (scene_at_count(at) < min_count) {
        snprintf(expected, sizeof expected, "an array of %zu or more %s", min_count, of);
        return scene_doc_expected(doc, at, ERR_INPUT, expected);
    }
    if (scene_at_count(at) <= max_count)
        return true;
    snprintf(expected, sizeof expected, "an array of at most %zu %s", max_count, of);
    return scene_doc_expected(doc, at, ERR_LIMIT, expected);
}

static bool has_control(const char *s)
{
    for (; *s; s++)
        if ((unsigned char)*s < 0x20 || *s == 0x7f)
            return true;
    return false;
}

bool scene_doc_text(struct scene_doc *doc, const struct scene_at *at, size_t min_bytes,
                    size_t max_bytes, const char **out)
{
    const bool is_text = scene_at_type(at) == SCENE_STRING;
    const char *s = is_text ? scene_at_string(at) : "";
    const size_t n = strlen(s);
    if (!is_text || n < min_bytes || n > max_bytes || has_control(s)) {
        char expected[96];
        snprintf(expected, sizeof expected, "a string of %zu to %zu bytes%s", min_bytes, max_bytes,
                 has_control(s) ? " without control characters" : "");
        return scene_doc_expected(doc, at, n > max_bytes ? ERR_LIMIT : ERR_INPUT, expected);
    }
    *out = arena_strdup(doc->arena, s);
    return true;
}

bool scene_doc_choice(struct scene_doc *doc, const struct scene_at *at, const char *const *names,
                      size_t count, size_t *chosen)
{
    if (scene_at_type(at) == SCENE_STRING)
        for (size_t i = 0; i < count; i++)
            if (!strcmp(scene_at_string(at), names[i])) {
                *chosen = i;
                return true;
            }
    char list[LIST_BYTES];
    names_print(list, names, count);
    return scene_doc_expected(doc, at, ERR_INPUT, list);
}

bool scene_doc_kind(struct scene_doc *doc, const struct scene_at *at, const char *what,
                    const char *const *names, size_t count, size_t *kind)
{
    struct scene_at type;
    if (scene_at_type(at) != SCENE_OBJECT)
        return scene_doc_object(doc, at, what, NULL, 0);
    if (!scene_at_member(at, "type", &type))
        return scene_doc_fault(doc, at, ERR_INPUT, "%s needs the key \"type\"", what);
    return scene_doc_choice(doc, &type, names, count, kind);
}

bool scene_key_number(struct scene_doc *doc, const struct scene_at *object, const char *key,
                      struct scene_range range, double *out)
{
    struct scene_at at;
    return !scene_at_member(object, key, &at) || scene_doc_number(doc, &at, range, out);
}

bool scene_key_integer(struct scene_doc *doc, const struct scene_at *object, const char *key,
                       struct scene_range range, uint64_t *out)
{
    struct scene_at at;
    return !scene_at_member(object, key, &at) || scene_doc_integer(doc, &at, range, out);
}

bool scene_key_numbers(struct scene_doc *doc, const struct scene_at *object, const char *key,
                       struct scene_range range, double *out, size_t count)
{
    struct scene_at at;
    return !scene_at_member(object, key, &at) || scene_doc_numbers(doc, &at, range, out, count);
}

bool scene_key_rgb(struct scene_doc *doc, const struct scene_at *object, const char *key,
                   struct scene_range range, rgb *out)
{
    struct scene_at at;
    return !scene_at_member(object, key, &at) || scene_doc_rgb(doc, &at, range, out);
}
