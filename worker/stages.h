/* stages.h - prepared scenes in memory, by document and method: those in use, and the last used as
 * far as there is room. One that is mapped counts as one of our own: it may be, if nobody else has
 * it.
 *
 * A scene that is not there is given to the loader once, whoever asks meanwhile. One that could not
 * be prepared is forgotten when its last holder lets go, so a later lease tries again.
 * Main thread only.
 * SPDX-License-Identifier: MIT */
#ifndef WORKER_STAGES_H
#define WORKER_STAGES_H

#include "worker/loader.h"

/* However small they are: each may take a descriptor and a mapping. */
enum { STAGES_MOST = 256 };

struct stages_entry {
    struct load *load; /* the loader's while `loading`, then the entry's */
    bool loading;
    uint32_t holders;
    uint64_t used; /* number of the last hold: the smallest goes first */
    struct stages_entry *next;
};

struct stages {
    struct loader *loader; /* borrowed */
    struct stages_entry *entries;
    uint64_t most_bytes, holds;
};

void stages_release(struct stages *); /* nothing is loading or held */

/* method: PLAN_REAL for the document's own */
struct stages_entry *stages_hold(struct stages *, const char document[HASH_HEX],
                                 enum plan_candidate_kind method);
void stages_drop(struct stages *, struct stages_entry *);
void stages_loaded(struct stages *, struct load *); /* what the loader gave back */

#endif
