/* Every NAME.json of tests/invalid gives exactly the messages of NAME.err, one a line:
 *
 *     input /film/width: expected a whole number in [1, 16384], got 0
 *
 * the code, the place ("(document)" for the whole), what was found and is allowed. Documents
 * whose name begins with "net-" are read as sent to a coordinator. With --print, the program writes
 * the messages of one document instead: a new pair of files begins there.
 * SPDX-License-Identifier: MIT */
#include <dirent.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/buf.h"
#include "common/scene.h"
#include "tests/tap.h"

static const char folder[] = "tests/invalid";

static void text_append(struct buf *out, const char *text)
{
    buf_append(out, text, strlen(text));
}

static struct buf messages_of(const char *path, bool from_net)
{
    struct buf json = {0}, out = {0};
    struct arena arena = {0};
    struct err err;
    struct scene scene;
    struct scene_errors errors = {0};
    if (!buf_read_file(&json, path, SCENE_MAX_BYTES, &err)) {
        text_append(&out, err.text);
    } else if (scene_parse(&scene, (const char *)json.data, json.size,
                           from_net ? SCENE_FROM_NET : SCENE_FROM_DISK, &arena, &errors)) {
        text_append(&out, "valid\n");
    }
    for (size_t i = 0; i < errors.count; i++) {
        const struct scene_error *e = &errors.list[i];
        text_append(&out, e->code == ERR_LIMIT ? "limit " : "input ");
        text_append(&out, *e->where ? e->where : "(document)");
        text_append(&out, ": ");
        text_append(&out, e->what);
        text_append(&out, "\n");
    }
    buf_append(&out, "", 1);
    arena_release(&arena);
    buf_release(&json);
    return out;
}

static void check_document(const char *name)
{
    char path[512];
    snprintf(path, sizeof path, "%s/%s.json", folder, name);
    struct buf got = messages_of(path, !strncmp(name, "net-", 4));
    struct buf want = {0};
    struct err err;
    snprintf(path, sizeof path, "%s/%s.err", folder, name);
    if (!buf_read_file(&want, path, 1 << 20, &err))
        diag("%s", err.text);
    buf_append(&want, "", 1);
    if (!ok(!strcmp((const char *)got.data, (const char *)want.data),
            "%s is refused in so many "
            "words",
            name))
        diag("got:\n%s# want:\n%s", (const char *)got.data, (const char *)want.data);
    buf_release(&got);
    buf_release(&want);
}

static int is_document(const struct dirent *entry)
{
    const char *dot = strrchr(entry->d_name, '.');
    return dot && !strcmp(dot, ".json");
}

int main(int argc, char **argv)
{
    if (argc == 3 && !strcmp(argv[1], "--print")) {
        const char *slash = strrchr(argv[2], '/');
        struct buf got = messages_of(argv[2], !strncmp(slash ? slash + 1 : argv[2], "net-", 4));
        fputs((const char *)got.data, stdout);
        buf_release(&got);
        return 0;
    }
    struct dirent **list;
    const int count = scandir(folder, &list, is_document, alphasort);
    ok(count >= 60, "%s holds at least 60 documents (%d)", folder, count);
    for (int i = 0; i < count; i++) {
        *strrchr(list[i]->d_name, '.') = '\0';
        check_document(list[i]->d_name);
        free(list[i]);
    }
    if (count >= 0)
        free(list);
    return tap_done();
}
