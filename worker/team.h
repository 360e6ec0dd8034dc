/* team.h - threads that share a computation of the core: the crew of crew.h.
 *
 * They are started for each piece of work and have ended when it is done; the caller's thread is
 * one of them. A piece that takes longer says how far it is, every few seconds, in the log. One run
 * at a time per struct. SPDX-License-Identifier: MIT */
#ifndef WORKER_TEAM_H
#define WORKER_TEAM_H

#include "common/hash.h"
#include "common/trace/crew.h"

struct team {
    uint32_t threads;    /* at least 1 */
    char what[HASH_HEX]; /* for the log: the document's hash */
    uint32_t pieces;     /* run so far */
};

/* Borrows the team, which outlives it. */
struct crew team_crew(struct team *);

#endif
