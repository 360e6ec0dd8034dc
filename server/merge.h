/* merge.h - a pass into its job's film: exactly once, in order.
 *
 * A result is taken when its pass is missing, whoever holds the lease by now, and it is of just the
 * blocks that the pass lacks (round.h). What comes before its turn is held; what comes twice
 * changes nothing. Pure; time is an argument. SPDX-License-Identifier: MIT */
#ifndef SERVER_MERGE_H
#define SERVER_MERGE_H

#include "common/wire.h"
#include "server/job.h"

enum merge_result {
    MERGE_MERGED,
    MERGE_HELD,
    MERGE_DUPLICATE,
    MERGE_STALE, /* of blocks that have stopped meanwhile, too: it is leased again without them */
    MERGE_UNWANTED, /* too early for us to keep: it will be leased again when its turn comes */
};

/* Compares the payload with the record of an open job. ERR_PROTOCOL: it contradicts it.
 * ERR_CONFLICT: it is beyond where the job stops. */
bool merge_check(const struct job *, const struct wire_samples *, struct err *) MUST_CHECK;

/* A checked payload of an open job. A lease on its pass ends: the caller drops its record. */
enum merge_result merge_deliver(struct job *, const struct wire_samples *, int64_t now_ms);

/* The last complete round was judged not good enough: lets the next one in, and what is held of it.
 * Passes that are out and have lost blocks by that are READY again: the caller drops their leases.
 */
void merge_next_round(struct job *, int64_t now_ms);

const char *merge_result_name(enum merge_result);

#endif
