/* SPDX-License-Identifier: MIT */
#include "tests/shelf.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

void shelf_init(struct shelf *s)
{
    strcpy(s->dir, "/tmp/smalti-shelf-XXXXXX");
    if (!mkdtemp(s->dir))
        exit(1);
    scenes_init(&s->scenes, 16, 16);
    const uint32_t grey = scenes_diffuse(&s->scenes, vec3_make(.5f, .5f, .5f));
    scenes_box(&s->scenes, grey, vec3_make(-1, -1, -1), vec3_make(1, 1, 1), true);
    scenes_sphere(&s->scenes, grey, vec3_make(0, 0, 0), .25f)->emission = vec3_make(1, 1, 1);
    s->stage = scenes_stage(&s->scenes);
}

void shelf_release(struct shelf *s)
{
    char command[128];
    snprintf(command, sizeof command, "rm -rf %s", s->dir);
    if (system(command))
        exit(1);
    scenes_release(&s->scenes);
}

struct cache shelf_cache(const struct shelf *s, uint64_t most_bytes)
{
    struct cache c;
    cache_init(&c, s->dir, most_bytes);
    return c;
}

const char *shelf_document(int n)
{
    static char hex[HASH_HEX];
    hash_hex(&n, sizeof n, hex);
    return hex;
}

const char *shelf_path(const struct shelf *s, int n)
{
    static char path[256];
    char name[CACHE_NAME];
    stagefile_name(name, shelf_document(n));
    snprintf(path, sizeof path, "%s/%s", s->dir, name);
    return path;
}

bool shelf_has(const struct shelf *s, int n)
{
    return access(shelf_path(s, n), F_OK) == 0;
}

int shelf_count(const struct shelf *s, const char *pattern)
{
    char command[128], text[16] = "";
    snprintf(command, sizeof command, "ls -A %s | grep -c '%s'", s->dir, pattern);
    FILE *f = popen(command, "r");
    const bool read = f && fgets(text, sizeof text, f);
    if (f)
        pclose(f);
    return read ? atoi(text) : -1;
}

static const atomic_bool never = false;

enum stagefile_answer shelf_get(const struct cache *c, int n, int64_t patience_ms,
                                struct stagefile *f, struct stagefile_claim *claim)
{
    return stagefile_get(&(struct stagefile_ask){c, shelf_document(n), &never, patience_ms}, f,
                         claim);
}

/* As the loader does it. */
bool shelf_fill(const struct shelf *s, const struct cache *c, int n, struct stagefile *f)
{
    struct stagefile_claim claim;
    struct err err;
    const enum stagefile_answer answer = shelf_get(c, n, SHELF_LONG_MS, f, &claim);
    return answer == STAGEFILE_MAPPED ||
           (answer == STAGEFILE_CLAIMED && stagefile_publish(&claim, s->stage, f, &err));
}

bool shelf_same(const struct shelf *s, const struct stagefile *f)
{
    return f->stage && !((uintptr_t)f->stage % 64) && f->stage->bytes == s->stage->bytes &&
           !memcmp(f->stage, s->stage, s->stage->bytes);
}

struct buf shelf_file(const struct stage *block, const char *name)
{
    struct buf file = {0};
    stagefile_head(&file, name, block);
    buf_append(&file, block, block->bytes);
    return file;
}
