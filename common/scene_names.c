/* SPDX-License-Identifier: MIT */
#include "common/scene_names.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

bool scene_names_open(struct scene_doc *doc, const struct scene_at *at, size_t most,
                      struct scene_names *names)
{
    if (scene_at_type(at) != SCENE_OBJECT) {
        char expected[64];
        snprintf(expected, sizeof expected, "an object of %ss by name", names->one);
        return scene_doc_expected(doc, at, ERR_INPUT, expected);
    }
    const size_t count = scene_at_count(at);
    if (count > most)
        return scene_doc_fault(doc, at, ERR_LIMIT, "expected at most %zu %ss, got %zu", most,
                               names->one, count);
    names->sorted = arena_new(doc->arena, struct scene_name, count);
    names->count = (uint32_t)count;
    names->known = true;
    return true;
}

const char *scene_names_take(struct scene_doc *doc, const struct scene_at *member,
                             struct scene_names *names, uint32_t i)
{
    const char *name = arena_strdup(doc->arena, member->key);
    const size_t length = strlen(name);
    if (length < 1 || length > SCENE_MAX_NAME)
        scene_doc_fault(doc, member, length ? ERR_LIMIT : ERR_INPUT,
                        "expected a %s name of 1 to %d bytes, got %zu", names->one, SCENE_MAX_NAME,
                        length);
    for (const char *c = name; *c; c++)
        if ((unsigned char)*c < 0x20 || *c == 0x7f) {
            scene_doc_fault(doc, member, ERR_INPUT, "expected a %s name without control characters",
                            names->one);
            break;
        }
    names->sorted[i] = (struct scene_name){name, i};
    return name;
}

static int name_compare(const void *a, const void *b)
{
    return strcmp(((const struct scene_name *)a)->name, ((const struct scene_name *)b)->name);
}

void scene_names_close(struct scene_names *names)
{
    qsort(names->sorted, names->count, sizeof *names->sorted, name_compare);
}

static bool unknown(struct scene_doc *doc, const struct scene_at *at,
                    const struct scene_names *names)
{
    enum { SCANNED = 200, LISTED = 8 }; /* to scan all for all could cost minutes */
    if (!scene_doc_listed(doc, at))
        return scene_doc_fault(doc, at, ERR_INPUT, "no such %s", names->one);
    const char *some[SCANNED];
    const size_t count = names->count < SCANNED ? names->count : SCANNED;
    for (size_t i = 0; i < count; i++)
        some[i] = names->sorted[i].name;
    char got[SCENE_QUOTE_BYTES], known[SCENE_QUOTE_BYTES];
    const char *meant = scene_suggest(scene_at_string(at), some, count);
    scene_doc_quote(scene_at_string(at), got);
    if (meant) {
        scene_doc_quote(meant, known);
        return scene_doc_fault(doc, at, ERR_INPUT, "no %s is named %s, did you mean %s?",
                               names->one, got, known);
    }
    char list[LISTED * SCENE_QUOTE_BYTES] = "";
    size_t n = 0;
    for (size_t i = 0; i < count && i < LISTED; i++) {
        scene_doc_quote(some[i], known);
        n += (size_t)snprintf(list + n, sizeof list - n, "%s%s", i ? ", " : "", known);
    }
    return scene_doc_fault(doc, at, ERR_INPUT, "no %s is named %s, the document has %s%s",
                           names->one, got, count ? list : "none",
                           names->count > LISTED ? " ..." : "");
}

bool scene_names_find(struct scene_doc *doc, const struct scene_at *at,
                      const struct scene_names *names, uint32_t *index)
{
    if (scene_at_type(at) != SCENE_STRING) {
        char expected[64];
        snprintf(expected, sizeof expected, "the name of a %s", names->one);
        return scene_doc_expected(doc, at, ERR_INPUT, expected);
    }
    const char *name = scene_at_string(at);
    size_t begin = 0, end = names->count;
    while (begin < end) {
        const size_t middle = begin + (end - begin) / 2;
        const int order = strcmp(name, names->sorted[middle].name);
        if (order == 0) {
            *index = names->sorted[middle].index;
            return true;
        }
        if (order < 0)
            end = middle;
        else
            begin = middle + 1;
    }
    return names->known && unknown(doc, at, names);
}
