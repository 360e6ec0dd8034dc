/* pool.h - threads that render passes.
 *
 * A thread owns its scratch arena and shares nothing but the stage, which it only reads. A pass
 * that is submitted comes back through the mailbox given to pool_new, either finished with its
 * payload encoded or, when it was abandoned, unfinished.
 * SPDX-License-Identifier: MIT */
#ifndef WORKER_POOL_H
#define WORKER_POOL_H

#include "worker/mailbox.h"
#include "worker/pass.h"

struct pool; /* opaque, heap */

/* Starts the threads. room: passes the pool and `done` must be able to hold. */
struct pool *pool_new(uint32_t threads, size_t room, struct mailbox *done);
void pool_free(struct pool *); /* every pass must have come back */

void pool_submit(struct pool *, struct pass *);
struct pass *pool_take_back(struct pool *); /* one that no thread has begun; NULL: none */

int64_t pool_idle_ms(const struct pool *); /* of all threads, waiting for a pass */

#endif
