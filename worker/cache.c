/* SPDX-License-Identifier: MIT */
#include "worker/cache.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include "common/arena.h"
#include "common/clock.h"
#include "common/log.h"

enum { UNUSED_MOST_SECONDS = 30 * 24 * 3600 };

static const char temp_prefix[] = ".tmp-", made_suffix[] = ".stage";

/* ------------------------------------------------------------------ names */

static void path_of(const struct cache *c, const char *prefix, const char *name,
                    char path[CACHE_PATH])
{
    snprintf(path, CACHE_PATH, "%s/%s%.*s", c->dir, prefix, CACHE_NAME - 1, name);
}

void cache_name(char name[CACHE_NAME], const char hex[HASH_HEX], const char *key)
{
    snprintf(name, CACHE_NAME, "%s-%.16s%s", hex, key, made_suffix);
}

/* An asset, or what is made from one. */
static bool is_ours(const char *name)
{
    char hex[HASH_HEX];
    const size_t length = strlen(name), suffix = sizeof made_suffix - 1;
    if (length < HASH_HEX - 1 || length >= CACHE_NAME)
        return false;
    memcpy(hex, name, HASH_HEX - 1);
    hex[HASH_HEX - 1] = 0;
    const char *rest = name + HASH_HEX - 1;
    return hash_is_hex(hex) && (!*rest || (*rest == '-' && strlen(rest) > suffix &&
                                           !strcmp(name + length - suffix, made_suffix)));
}

static bool is_temp(const char *name)
{
    const size_t prefix = sizeof temp_prefix - 1;
    return !strncmp(name, temp_prefix, prefix) && is_ours(name + prefix);
}

/* ------------------------------------------------------------------ files */

/* What another user can write is not taken for what we have written. */
static bool is_private(int fd, struct stat *st)
{
    return !fstat(fd, st) && S_ISREG(st->st_mode) && st->st_uid == geteuid() &&
           !(st->st_mode & (S_IWGRP | S_IWOTH));
}

/* Whether that name still means the file behind fd. */
static bool is_at(int fd, int dir, const char *name)
{
    struct stat a, b;
    return !fstat(fd, &a) && !fstatat(dir, name, &b, AT_SYMLINK_NOFOLLOW) && a.st_dev == b.st_dev &&
           a.st_ino == b.st_ino;
}

static int open_alone(int dir, const char *name)
{
    return openat(dir, name, O_RDWR | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC);
}

/* Of a worker that died while writing, unless one alive holds its lock. Who holds that may rename
 * the file, nobody else: what was at the name before the lock is there until it is given back. */
static void remove_orphan(int dir, const char *name)
{
    const int fd = open_alone(dir, name);
    if (fd < 0)
        return;
    if (!flock(fd, LOCK_EX | LOCK_NB) && is_at(fd, dir, name))
        unlinkat(dir, name, 0);
    close(fd);
}

/* Whether some process has it open and kept. */
static bool is_kept(const struct cache *c, const char *name)
{
    char path[CACHE_PATH];
    path_of(c, "", name, path);
    const int fd = open_alone(AT_FDCWD, path);
    if (fd < 0)
        return false;
    const bool kept = flock(fd, LOCK_EX | LOCK_NB) && errno == EWOULDBLOCK;
    close(fd);
    return kept;
}

/* --------------------------------------------------------------- eviction */

struct entry {
    char name[CACHE_NAME];
    uint64_t bytes;
    struct timespec used;
    bool gone;
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
    *e = (struct entry){.bytes = (uint64_t)st->st_size, .used = st->st_mtim};
    memcpy(e->name, name, strlen(name) + 1); /* is_ours: it fits */
    l->bytes += e->bytes;
}

/* Our files only: the directory may be one the user has other things in. */
static struct listing list_files(const struct cache *c)
{
    struct listing l = {0};
    DIR *dir = opendir(c->dir);
    for (struct dirent *d; dir && (d = readdir(dir));) {
        struct stat st;
        if (is_temp(d->d_name))
            remove_orphan(dirfd(dir), d->d_name);
        else if (is_ours(d->d_name) && !fstatat(dirfd(dir), d->d_name, &st, AT_SYMLINK_NOFOLLOW) &&
                 S_ISREG(st.st_mode))
            list_file(&l, d->d_name, &st);
    }
    if (dir)
        closedir(dir);
    if (l.count)
        qsort(l.entries, l.count, sizeof *l.entries, by_age);
    return l;
}

static void evict_entry(const struct cache *c, struct listing *l, struct entry *e)
{
    char path[CACHE_PATH];
    path_of(c, "", e->name, path);
    if (!unlink(path))
        log_debug("cache_evict file=%s bytes=%llu", path, (unsigned long long)e->bytes);
    e->gone = true;
    l->bytes -= e->bytes;
}

/* Makes room for a file of so many bytes: the longest unused go first, those in use last. */
static void evict(const struct cache *c, uint64_t bytes)
{
    struct listing l = list_files(c);
    const int64_t old_s = clock_unix_ms() / 1000 - UNUSED_MOST_SECONDS;
    for (size_t i = 0; i < l.count; i++)
        if ((l.bytes + bytes > c->most_bytes || l.entries[i].used.tv_sec < old_s) &&
            !is_kept(c, l.entries[i].name))
            evict_entry(c, &l, &l.entries[i]);
    for (size_t i = 0; i < l.count && l.bytes + bytes > c->most_bytes; i++)
        if (!l.entries[i].gone)
            evict_entry(c, &l, &l.entries[i]);
    free(l.entries);
}

/* -------------------------------------------------------------- directory */

/* mkdir -p, private to the user. */
static bool make_dirs(const char *dir)
{
    char path[CACHE_PATH];
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
    if (!most_bytes)
        return;
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

/* ---------------------------------------------------------------- reading */

bool cache_get(const struct cache *c, const char hex[HASH_HEX], size_t max_bytes, struct buf *out)
{
    char path[CACHE_PATH], found[HASH_HEX];
    struct err err;
    if (!c->usable)
        return false;
    path_of(c, "", hex, path);
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

int cache_open(const struct cache *c, const char *name)
{
    char path[CACHE_PATH];
    struct stat st;
    if (!c->usable)
        return -1;
    path_of(c, "", name, path);
    const int fd = open(path, O_RDONLY | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC);
    if (fd >= 0 && !is_private(fd, &st)) {
        close(fd);
        return -1;
    }
    if (fd >= 0)
        futimens(fd, NULL);
    return fd;
}

void cache_keep(int fd)
{
    /* Without it (a file system has no locks, or the file is just being deleted) all is as well,
     * but for the order in which files are deleted. */
    (void)flock(fd, LOCK_SH | LOCK_NB);
}

/* ---------------------------------------------------------------- writing */

/* The lock is worth something only on the file that has the temporary name: another process may
 * have renamed or removed it since we opened it. */
static enum cache_begun lock_draft(const struct cache_draft *d)
{
    struct stat st;
    if (flock(d->fd, LOCK_EX | LOCK_NB))
        return errno == EWOULDBLOCK ? CACHE_BUSY : CACHE_OFF;
    if (!is_at(d->fd, AT_FDCWD, d->temp))
        return CACHE_BUSY;
    if (!is_private(d->fd, &st)) {
        errno = EPERM;
        return CACHE_OFF;
    }
    return ftruncate(d->fd, 0) ? CACHE_OFF : CACHE_BEGUN;
}

enum cache_begun cache_begin(const struct cache *c, const char *name, struct cache_draft *d)
{
    d->fd = -1;
    if (!c->usable)
        return CACHE_OFF;
    path_of(c, temp_prefix, name, d->temp);
    path_of(c, "", name, d->path);
    d->fd = open(d->temp, O_RDWR | O_CREAT | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC, 0600);
    const enum cache_begun begun = d->fd < 0 ? CACHE_OFF : lock_draft(d);
    if (begun == CACHE_OFF)
        log_warn("cache_write_failed file=%s reason=\"%s\"", d->temp, strerror(errno));
    if (begun != CACHE_BEGUN && d->fd >= 0)
        close(d->fd);
    return begun;
}

bool cache_reserve(const struct cache *c, const struct cache_draft *d, uint64_t bytes,
                   struct err *err)
{
    if (bytes > c->most_bytes || bytes > INT64_MAX)
        return err_set(err, ERR_LIMIT, "%llu bytes are more than the cache may have, %llu",
                       (unsigned long long)bytes, (unsigned long long)c->most_bytes);
    evict(c, bytes);
    const int no = posix_fallocate(d->fd, 0, (off_t)bytes);
    if (no && no != EOPNOTSUPP && no != EINVAL) /* those: this file system cannot tell */
        return err_set(err, ERR_IO, "%s: %s", d->temp, strerror(no));
    return true;
}

bool cache_write(const struct cache_draft *d, const void *data, size_t bytes, struct err *err)
{
    const unsigned char *at = data;
    while (bytes) {
        const ssize_t n = write(d->fd, at, bytes);
        if (n < 0 && errno == EINTR)
            continue;
        if (n <= 0)
            return err_set(err, ERR_IO, "%s: %s", d->temp, n ? strerror(errno) : "nothing written");
        at += n;
        bytes -= (size_t)n;
    }
    return true;
}

/* Some file systems say only when a file is closed that the disk is full; the lock stays with
 * d->fd. */
static bool flush(const struct cache_draft *d)
{
    const int twin = fcntl(d->fd, F_DUPFD_CLOEXEC, 0);
    return twin >= 0 && !close(twin);
}

/* Renamed first and closed then, which gives the lock back. No fsync: what a power cut leaves of a
 * file is found out when it is read. */
bool cache_finish(struct cache_draft *d, struct err *err)
{
    if (!flush(d) || rename(d->temp, d->path)) {
        err_set(err, ERR_IO, "%s: %s", d->path, strerror(errno));
        cache_drop(d);
        return false;
    }
    close(d->fd);
    d->fd = -1;
    return true;
}

void cache_drop(struct cache_draft *d)
{
    unlink(d->temp);
    close(d->fd);
    d->fd = -1;
}

void cache_put(const struct cache *c, const char hex[HASH_HEX], const void *data, size_t bytes)
{
    struct cache_draft d;
    struct err err = {0};
    if (bytes > c->most_bytes || cache_begin(c, hex, &d) != CACHE_BEGUN)
        return; /* somebody else is writing the same bytes */
    bool good = cache_reserve(c, &d, bytes, &err) && cache_write(&d, data, bytes, &err);
    if (good)
        good = cache_finish(&d, &err);
    else
        cache_drop(&d);
    if (!good)
        log_warn("cache_write_failed file=%s reason=\"%s\"", d.path, err.text);
}
