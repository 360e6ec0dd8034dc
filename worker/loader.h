/* loader.h - a thread that turns a document's hash into a stage: maps what the cache has, else
 * fetches, parses, reads the meshes and images, prepares, and leaves it in the cache for all.
 *
 * One after the other, so a scene is prepared once however many passes wait for it, and renewals
 * go on meanwhile on the main thread. Assets come from the disk cache or the coordinator; while
 * the coordinator is away the loader keeps trying.
 * SPDX-License-Identifier: MIT */
#ifndef WORKER_LOADER_H
#define WORKER_LOADER_H

#include "common/plan.h"
#include "common/trace/stage.h"
#include "worker/args.h"
#include "worker/cache.h"
#include "worker/mailbox.h"
#include "worker/stagefile.h"

/* Goes in by loader_submit and comes back through the mailbox given to loader_new. */
struct load {
    char document[HASH_HEX];
    enum plan_candidate_kind method; /* that a plan has chosen; PLAN_REAL: as it is prepared */
    const struct stage *stage;       /* in one of the two: */
    struct stagefile file;           /* shared by every process that has it, or */
    struct arena arena;              /* ours alone */
    bool done;                       /* the stage is there; else: */
    const char *fault_kind; /* "input" the scene cannot be prepared anywhere, "worker" not here */
    struct err err;
};

uint64_t loader_bytes(const struct load *); /* that the stage takes, shared ones included */
void loader_release(struct load *);         /* the stage, by whoever has the load */

struct loader; /* opaque, heap */

/* args, cache, done outlive it. NULL: the server's address makes no sense. */
struct loader *loader_new(const struct args *args, const struct cache *cache, size_t room,
                          struct mailbox *done, struct err *err);
void loader_submit(struct loader *, struct load *);

/* Breaks off what waits for the network. True: the thread has ended, the loader is freed and all
 * loads have come back, some of them not done. False: it was still computing after so many ms. */
bool loader_stop(struct loader *, int64_t within_ms);

#endif
