/* sched.h - which pass to hand out next, across jobs.
 *
 * Jobs go by priority, then age. A job that wants a plan has no passes before it has one. Inside a
 * job breadth first: pass p of all tiles before pass p + 1, up to JOB_LOOKAHEAD rounds beyond the
 * last complete one (one beyond it for a job with an error target, since that round may be thrown
 * away). A job with a seconds target decides before each new round whether it still fits. Pure;
 * time is an argument. SPDX-License-Identifier: MIT */
#ifndef SERVER_SCHED_H
#define SERVER_SCHED_H

#include "server/job.h"

struct sched {
    struct job **jobs; /* not over; by priority, then number */
    size_t count, capacity;
    uint64_t
        held_limit_bytes; /* of early payloads per job: beyond it only the next pass is leased */
};

void sched_release(struct sched *);
void sched_add(struct sched *, struct job *);
void sched_remove(struct sched *, struct job *);
void sched_reorder(struct sched *, struct job *); /* its priority has changed */

enum sched_result {
    SCHED_NOTHING,
    SCHED_PASS,   /* pick is READY or free to be tried again: lease it */
    SCHED_PLAN,   /* pick->job wants a plan: lease that */
    SCHED_OPEN,   /* pick->job must be opened (or marked starved) first: ask again then */
    SCHED_SETTLE, /* pick->job has settled on its spp: save its row, ask again then */
};

struct sched_pick {
    struct job *job;
    uint32_t tile, pass;
};

enum sched_result sched_next(struct sched *, uint32_t worker, int64_t now_ms, struct sched_pick *);

/* A seconds target that runs out while nobody asks for work: true when it has settled on the rounds
 * that are complete; save its row. */
bool sched_time_is_up(struct job *, int64_t now_ms);

/* Marks the pass as leased. */
void sched_grant(struct job *, uint32_t tile, uint32_t pass, uint64_t lease);

#endif
