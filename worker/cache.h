/* cache.h - a directory of files named by content: assets, named by the SHA-256 of their bytes,
 * and what was made from one, named by its SHA-256 and a key (stagefile.h).
 *
 * Assets are verified when read, so whatever a crash or another process did to a file costs a
 * download, never a wrong pixel. Several workers may share a directory. Writing is best effort: a
 * full or read-only disk is logged and the worker goes on.
 *
 * A file is written under a temporary name and then renamed. The temporary file is locked by who
 * writes it (flock): so one process writes, the others see that, and what a dead one left, whose
 * lock died with it, is taken over or removed. Files opened by cache_open and kept (cache_keep) are
 * the last to be deleted when room is needed; deleting one takes nothing from who has it open.
 * One thread at a time per struct and draft.
 * SPDX-License-Identifier: MIT */
#ifndef WORKER_CACHE_H
#define WORKER_CACHE_H

#include "common/buf.h"
#include "common/err.h"
#include "common/hash.h"

enum { CACHE_NAME = 128, CACHE_PATH = 680 };

struct cache {
    char dir[512];
    uint64_t most_bytes; /* of all files together; the longest unused are deleted first */
    bool usable;         /* false: no bytes, or the directory cannot be made or is another user's */
};

void cache_init(struct cache *, const char *dir, uint64_t most_bytes);

/* Appends the asset's bytes to `out`; false: not here. */
bool cache_get(const struct cache *, const char hex[HASH_HEX], size_t max_bytes, struct buf *out);
void cache_put(const struct cache *, const char hex[HASH_HEX], const void *data, size_t bytes);

/* The name of what is made from an asset. key: 16 hex digits. */
void cache_name(char name[CACHE_NAME], const char hex[HASH_HEX], const char *key);

/* A descriptor to read from, of a whole file that is ours and nobody else can write, now the
 * youngest. -1: not here. */
int cache_open(const struct cache *, const char *name);
void cache_keep(int fd); /* in use until fd is closed: spared while other files can go */

/* A file that is not there yet. */
struct cache_draft {
    int fd; /* for reading and writing, locked */
    char temp[CACHE_PATH], path[CACHE_PATH];
};

enum cache_begun {
    CACHE_BEGUN, /* the draft is ours, and empty: cache_finish or cache_drop must follow */
    CACHE_BUSY,  /* another process has begun it: its file is draft.temp */
    CACHE_OFF,   /* nothing can be written here; that has been logged, if not by cache_init */
};

enum cache_begun cache_begin(const struct cache *, const char *name, struct cache_draft *);

/* Makes room for that many bytes: in the directory's bound and on the disk, so that a full one is
 * found out here. */
bool cache_reserve(const struct cache *, const struct cache_draft *, uint64_t bytes,
                   struct err *) MUST_CHECK;
bool cache_write(const struct cache_draft *, const void *data, size_t bytes,
                 struct err *) MUST_CHECK;

/* It has its name. After a failure it is dropped. */
bool cache_finish(struct cache_draft *, struct err *) MUST_CHECK;
void cache_drop(struct cache_draft *);

#endif
