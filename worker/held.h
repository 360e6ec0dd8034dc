/* held.h - the passes this worker holds, and what may happen to one (pass.h has the states).
 * Main thread only.
 * SPDX-License-Identifier: MIT */
#ifndef WORKER_HELD_H
#define WORKER_HELD_H

#include "worker/pool.h"
#include "worker/stages.h"

struct held {
    struct pass *first; /* oldest first */
    struct stages stages;
    struct pool *pool;
    uint64_t cpu_us; /* of all passes that came back from the pool */
};

struct pass *held_find(const struct held *, const char *id);
uint32_t held_count(const struct held *, enum pass_state from, enum pass_state to);

/* A fresh lease: WAITING, or POOLED when its scene is ready. */
void held_accept(struct held *, const struct link_lease *, int64_t now_ms);
/* A lease that is not wanted: RETURN. */
void held_decline(struct held *, const struct link_lease *);

void held_loaded(struct held *, struct load *);   /* the loader gave it back: passes may go on */
void held_rendered(struct held *, struct pass *); /* the pool gave it back */

/* kind, reason: as link_return's. */
void held_return(struct pass *, const char *kind, const char *reason);
/* Its lease has lapsed: drop it, as soon as the pool lets go of it. WAITING or POOLED only. */
void held_forget(struct held *, struct pass *);
/* Hand it back, as soon as the pool lets go of it, unless it is finished. */
void held_abandon(struct pass *);
/* Hands back all that no thread has begun. */
void held_abandon_unbegun(struct held *);

void held_remove(struct held *, struct pass *);

#endif
