/* agent.h - the worker's main loop: what to lease, renew, deliver and hand back, and when.
 *
 * It holds up to `threads` passes being rendered and as many ahead, so a thread that finishes one
 * finds the next in its queue; every delivery asks for what is then missing. What is finished
 * is kept until it has been delivered, however long the coordinator is away; meanwhile nothing
 * new can be leased, so that is bounded too.
 * SPDX-License-Identifier: MIT */
#ifndef WORKER_AGENT_H
#define WORKER_AGENT_H

#include "worker/args.h"
#include "worker/cache.h"

/* Until a signal arrives at signal_fd (a signalfd), or the coordinator drains this worker. The
 * program's exit status. */
int agent_run(const struct args *, const struct cache *, int signal_fd);

#endif
