/* stagefile.h - prepared scenes in the cache, mapped read-only by every worker of the machine.
 *
 * A scene is prepared once, by the first worker that wants it; the others wait, then map the same
 * pages. So does the next process, after a restart.
 *
 * The file (docs/design.md, "One copy of a scene"):
 *
 *      0  "SMSCENE\0"            magic
 *      8  u32 version            STAGEFILE_VERSION
 *     12  u32 head bytes         4096
 *     16  u64 block bytes
 *     24  u64 XXH3 of the block
 *     32  name                   128 bytes: of the file, zero-filled
 *    160  zeros
 *   4088  u64 XXH3 of the 4088 bytes before
 *   4096  the block              struct stage and its arrays, as it is in memory
 *
 * The name says all that the block depends on: the document's hash (which names the assets by
 * theirs), and a key of the two versions, struct stage's size and the sources that prepare. A block
 * of another build is a file of another name, which nobody asks for and which ages away.
 * All of it is checked when it is opened. The checksum finds damage, not malice: the file is in a
 * directory of our user, is our user's, and nobody else can write it (cache.h). The directory
 * should be on a local disk: the pages of a mapped file are read when they are needed.
 * One thread at a time per struct.
 * SPDX-License-Identifier: MIT */
#ifndef WORKER_STAGEFILE_H
#define WORKER_STAGEFILE_H

#include <pthread.h>
#include <stdatomic.h>

#include "common/plan.h"
#include "common/trace/stage.h"
#include "worker/cache.h"

enum { STAGEFILE_VERSION = 1, STAGEFILE_HEAD = 4096 };

/* A mapped scene; all zero: none. */
struct stagefile {
    const struct stage *stage; /* inside the mapping */
    void *map;
    size_t map_bytes;
    int fd; /* its lock says that the file is in use */
};

void stagefile_close(struct stagefile *); /* of none: nothing */

/* Makes it a stage of another method (study.h), for this process alone: one page is no longer
 * shared. The stage is of a document with "auto", and not traced yet. */
bool stagefile_set_method(struct stagefile *, struct plan_method, struct err *) MUST_CHECK;

struct stagefile_ask {
    const struct cache *cache;
    const char *document;       /* its hash in hex */
    const atomic_bool *stopped; /* breaks the waiting off */
    int64_t patience_ms;        /* with a process that prepares and shows no life */
};

/* The right, and the duty, to prepare a scene for all. While it is held a thread of its own shows
 * that we are alive; it is not to be moved. */
struct stagefile_claim {
    const struct cache *cache;
    struct cache_draft draft;
    char name[CACHE_NAME];
    pthread_t pulse;
    int stop_fd;
};

enum stagefile_answer {
    STAGEFILE_MAPPED,  /* it was there, or came */
    STAGEFILE_CLAIMED, /* prepare it, then stagefile_publish or stagefile_unclaim */
    STAGEFILE_ALONE, /* no sharing: there is no cache, or no end of waiting. Prepare it and keep it
                      */
};

enum stagefile_answer stagefile_get(const struct stagefile_ask *, struct stagefile *,
                                    struct stagefile_claim *);

/* Writes the block and maps it; either way the claim has ended. False: no room on the disk, or the
 * like; the block is needed further. */
bool stagefile_publish(struct stagefile_claim *, const struct stage *, struct stagefile *,
                       struct err *) MUST_CHECK;
void stagefile_unclaim(struct stagefile_claim *); /* it cannot be prepared */

/* ------------------------------------------------ the format, without files */

void stagefile_name(char name[CACHE_NAME], const char document[HASH_HEX]);
void stagefile_head(struct buf *out, const char *name, const struct stage *block); /* appends it */

/* The bytes of a file, 64-aligned. */
bool stagefile_check(const void *file, size_t bytes, const char *name, const struct stage **,
                     struct err *) MUST_CHECK;

#endif
