/* asset.h - immutable files named by the SHA-256 of their bytes, under STATE/assets/.
 *
 * A spool takes an upload chunk by chunk into a temporary file while hashing it; asset_adopt
 * gives it its name once that is known to be right. Spooling and flushing belong to any one
 * thread at a time, adopting to the owner.
 * SPDX-License-Identifier: MIT */
#ifndef SERVER_ASSET_H
#define SERVER_ASSET_H

#include "common/err.h"
#include "common/hash.h"
#include "server/disk.h"

struct asset_spool {
    struct disk_file file;
    struct hash *hash;   /* NULL once finished */
    char hex[HASH_HEX];  /* of all bytes; valid once finished */
    uint64_t bytes;      /* so far */
};

bool asset_open_store(const char *state_dir, struct err *) MUST_CHECK; /* once, before the rest */

struct asset_spool *asset_spool_new(struct err *); /* NULL: the system failed */
bool asset_spool_add(struct asset_spool *, const void *data, size_t bytes, struct err *) MUST_CHECK;
bool asset_spool_finish(struct asset_spool *, struct err *) MUST_CHECK; /* hashed, on disk */
void asset_spool_free(struct asset_spool *); /* drops the file unless adopted */

bool asset_exists(const char hex[HASH_HEX]);
bool asset_adopt(struct asset_spool *, struct err *) MUST_CHECK; /* durable when it returns */
bool asset_put(const void *data, size_t bytes, char hex[HASH_HEX], struct err *) MUST_CHECK;
int asset_fd(const char hex[HASH_HEX], uint64_t *bytes); /* -1: not here */

#endif
