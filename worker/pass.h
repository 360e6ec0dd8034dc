/* pass.h - a leased pass on its way through the worker.
 *
 *     WAITING --stage ready--> POOLED --finished--> DONE --> DELIVERING --2xx--> gone
 *        |                       |                    ^---- no answer ----'
 *        |                       '--unfinished--.
 *        '--stage failed, drained---------------+--> RETURN --> RETURNING --any answer--> gone
 *
 * The main thread owns passes. While one is POOLED it belongs to the pool, but for the fields
 * that say otherwise.
 * SPDX-License-Identifier: MIT */
#ifndef WORKER_PASS_H
#define WORKER_PASS_H

#include <stdatomic.h>

#include "common/buf.h"
#include "common/trace/stage.h"
#include "worker/link.h"

enum pass_state {
    PASS_WAITING,    /* its scene is being prepared */
    PASS_POOLED,     /* queued or being rendered */
    PASS_DONE,       /* its payload waits to be sent */
    PASS_DELIVERING, /* being sent */
    PASS_RETURN,     /* is to be handed back */
    PASS_RETURNING,  /* being handed back */
};

struct pass {
    struct link_lease lease;   /* never changes */
    const struct stage *stage; /* set before it is POOLED */
    atomic_bool abandon;       /* main sets it, the pool looks between rows */

    /* Main thread only, in every state. */
    enum pass_state state;
    struct stages_entry *held; /* keeps the stage; dropped with the pass */
    int64_t renew_ms;          /* when the lease is to be renewed next */
    bool renewing;             /* a renewal is under way */
    bool forget;               /* nobody wants it any more: drop it instead of handing it back */
    const char *fault_kind;    /* RETURN: as link_return; fault says why */
    char fault[512];
    struct pass *next;

    /* The pool writes them while POOLED. */
    bool finished;
    struct buf payload; /* owned */
    uint64_t cpu_us, invalid_count;
};

#endif
