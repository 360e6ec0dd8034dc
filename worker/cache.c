/* SPDX-License-Identifier: MIT */
#include "worker/cache.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "common/arena.h"
#include "common/clock.h"
#include "common/err.h"
#include "common/log.h"

enum { PATH_ROOM = 640, STALE_TEMP_SECONDS = 3600 };

static const char temp_prefix[] = ".tmp-";

/* mkdir -p, private to the user. */
static bool make_dirs(const char *dir)
{
    char path[PATH_ROOM];
    snprintf(path, sizeof path, "%s", dir);
    for (char *slash = path + 1; (slash = strchr(slash, '/')); slash++) {
        *slash = 0;
        if (mkdir(path, 0755) && errno != EEXIST)
            return false;
        *slash = '/';
    }
    return !mkdir(path, 0700) || errno == EEXIST;
}

void cache_init(struct cache *c, const char *dir, uint64_t most_bytes)
{
    *c = (struct cache){.most_bytes = most_bytes};
    struct stat st;
    if (strlen(dir) >= sizeof c->dir) {
        log_warn("cache_unusable reason=\"the directory's name is too long\"");
        return;
    }
    memcpy(c->dir, dir, strlen(dir) + 1);
    if (!make_dirs(dir) || stat(dir, &st) || !S_ISDIR(st.st_mode))
        log_warn("cache_unusable dir=%s reason=\"%s\"", dir, strerror(errno));
    else if (st.st_uid != geteuid())
        log_warn("cache_unusable dir=%s reason=\"it belongs to another user\"", dir);
    else
        c->usable = true;
}

static void path_of(const struct cache *c, const char *name, char path[PATH_ROOM])
{
    snprintf(path, PATH_ROOM, "%s/%s", c->dir, name);
}

bool cache_get(const struct cache *c, const char hex[HASH_HEX], size_t max_bytes, struct buf *out)
{
    char path[PATH_ROOM], found[HASH_HEX];
    struct err err;
    if (!c->usable)
        return false;
    path_of(c, hex, path);
    const size_t begin = out->size;
    if (!buf_read_file(out, path, max_bytes, &err)) {
        out->size = begin;
        return false;
    }
    hash_hex(out->data + begin, out->size - begin, found);
    if (strcmp(found, hex)) {
        log_warn("cache_damaged file=%s", path);
        unlink(path);
        out->size = begin;
        return false;
    }
    utimensat(AT_FDCWD, path, NULL, 0); /* used now: youngest */
    return true;
}

struct entry {
    char name[HASH_HEX];
    uint64_t bytes;
    struct timespec used;
};

struct listing {
    struct entry *entries;
    size_t count, capacity;
    uint64_t bytes;
};

static int by_age(const void *a, const void *b)
{
    const struct timespec x = ((const struct entry *)a)->used, y = ((const struct entry *)b)->used;
    if (x.tv_sec != y.tv_sec)
        return x.tv_sec < y.tv_sec ? -1 : 1;
    return x.tv_nsec < y.tv_nsec ? -1 : x.tv_nsec > y.tv_nsec;
}

static void list_file(struct listing *l, const char *name, const struct stat *st)
{
    if (l->count == l->capacity) {
        l->capacity = l->capacity ? 2 * l->capacity : 64;
        l->entries = arena_realloc(l->entries, l->capacity, sizeof *l->entries);
    }
    struct entry *e = &l->entries[l->count++];
    memcpy(e->name, name, HASH_HEX);
    e->bytes = (uint64_t)st->st_size;
    e->used = st->st_mtim;
    l->bytes += e->bytes;
}

/* Our files only: the directory may be one the user has other things in. */
static void list_files(const struct cache *c, struct listing *l)
{
    DIR *dir = opendir(c->dir);
    if (!dir)
        return;
    const int64_t stale_before = clock_unix_ms() / 1000 - STALE_TEMP_SECONDS;
    for (struct dirent *d; (d = readdir(dir));) {
        struct stat st;
        const bool is_temp = !strncmp(d->d_name, temp_prefix, sizeof temp_prefix - 1);
        if (!is_temp && !hash_is_hex(d->d_name))
            continue;
        if (fstatat(dirfd(dir), d->d_name, &st, AT_SYMLINK_NOFOLLOW) || !S_ISREG(st.st_mode))
            continue;
        if (!is_temp)
            list_file(l, d->d_name, &st);
        else if (st.st_mtim.tv_sec < stale_before)
            unlinkat(dirfd(dir), d->d_name, 0); /* of a worker that died while writing */
    }
    closedir(dir);
}

/* Makes room for an asset of so many bytes. */
static void evict(const struct cache *c, uint64_t bytes)
{
    struct listing l = {0};
    list_files(c, &l);
    if (l.count)
        qsort(l.entries, l.count, sizeof *l.entries, by_age);
    for (size_t i = 0; i < l.count && l.bytes + bytes > c->most_bytes; i++) {
        char path[PATH_ROOM];
        path_of(c, l.entries[i].name, path);
        if (!unlink(path))
            log_debug("cache_evict file=%s bytes=%llu", path,
                      (unsigned long long)l.entries[i].bytes);
        l.bytes -= l.entries[i].bytes;
    }
    free(l.entries);
}

static bool write_all(int fd, const void *data, size_t bytes)
{
    const unsigned char *at = data;
    while (bytes) {
        const ssize_t n = write(fd, at, bytes);
        if (n < 0 && errno == EINTR)
            continue;
        if (n <= 0)
            return false;
        at += n;
        bytes -= (size_t)n;
    }
    return true;
}

void cache_put(const struct cache *c, const char hex[HASH_HEX], const void *data, size_t bytes)
{
    if (!c->usable || bytes > c->most_bytes)
        return;
    evict(c, bytes);
    char name[64], temp[PATH_ROOM], path[PATH_ROOM];
    snprintf(name, sizeof name, "%s%ld-%.16s", temp_prefix, (long)getpid(), hex);
    path_of(c, name, temp);
    path_of(c, hex, path);
    const int fd = open(temp, O_WRONLY | O_CREAT | O_TRUNC | O_NOFOLLOW | O_CLOEXEC, 0600);
    bool good = fd >= 0 && write_all(fd, data, bytes);
    if (fd >= 0)
        good &= !close(fd);
    if (!good || rename(temp, path)) {
        log_warn("cache_write_failed file=%s reason=\"%s\"", path, strerror(errno));
        unlink(temp);
    }
}
