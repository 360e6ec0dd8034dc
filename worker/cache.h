/* cache.h - assets on disk, named by the SHA-256 of their bytes.
 *
 * Verified when read, so whatever a crash or another process did to a file costs a download, never
 * a wrong pixel. Several workers may share a directory. Writing is best effort: a full or read-only
 * disk is logged and the worker goes on.
 * One thread at a time per struct.
 * SPDX-License-Identifier: MIT */
#ifndef WORKER_CACHE_H
#define WORKER_CACHE_H

#include "common/buf.h"
#include "common/hash.h"

struct cache {
    char dir[512];
    uint64_t most_bytes; /* of all files together; the longest unused are deleted first */
    bool usable;         /* false: the directory cannot be made or is another user's */
};

void cache_init(struct cache *, const char *dir, uint64_t most_bytes);

/* Appends the asset's bytes to `out`; false: not here. */
bool cache_get(const struct cache *, const char hex[HASH_HEX], size_t max_bytes, struct buf *out);
void cache_put(const struct cache *, const char hex[HASH_HEX], const void *data, size_t bytes);

#endif
