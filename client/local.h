/* local.h - a coordinator and workers of our own, for one render: processes on this machine with a
 * state directory under $TMPDIR that is removed at the end.
 *
 * The processes die with us, however we die (PR_SET_PDEATHSIG). They are no terminal's business:
 * Ctrl-C reaches us alone. What they log is kept until the end and shown when something went wrong.
 * SPDX-License-Identifier: MIT */
#ifndef CLIENT_LOCAL_H
#define CLIENT_LOCAL_H

#include <stdio.h>
#include <sys/types.h>

#include "common/err.h"

enum { LOCAL_MAX_WORKERS = 256 };

struct local_plan {
    uint32_t workers, threads; /* processes, and threads of each; both at least 1 */
    uint32_t tile_px;          /* 0: the coordinator's default */
    const char *cache;         /* of the workers, kept; NULL: one that goes with the state */
};

struct local {
    char dir[256];                    /* "" when there is none */
    char url[128];                    /* the coordinator's */
    pid_t coordinator;                /* 0: not running */
    pid_t workers[LOCAL_MAX_WORKERS]; /* 0: not running */
    uint32_t worker_count;
};

/* Starts everything and waits until the coordinator listens. After a failure, too, local_stop. */
bool local_start(struct local *, const struct local_plan *, struct err *) MUST_CHECK;

/* False: the coordinator or all workers have died. */
bool local_check(struct local *, struct err *) MUST_CHECK;

void local_show_logs(const struct local *, FILE *out); /* the last lines of each */
void local_stop(struct local *);

uint32_t local_cores(void); /* that this process may use */

#endif
