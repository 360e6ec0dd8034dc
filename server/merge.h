/* merge.h - a pass into its job's film: exactly once, in order.
 *
 * A result is taken when its pass is missing, whoever holds the lease by now. What comes before its
 * turn is held; what comes twice changes nothing. Nothing of a round is merged into a job with an
 * error target before the round below it was judged, so the film at a judgement is a function of
 * the document alone. Pure; time is an argument.
 * SPDX-License-Identifier: MIT */
#ifndef SERVER_MERGE_H
#define SERVER_MERGE_H

#include "common/wire.h"
#include "server/job.h"

enum merge_result {
    MERGE_MERGED,
    MERGE_HELD,
    MERGE_DUPLICATE,
    MERGE_UNWANTED, /* too early for us to keep: it will be leased again when its turn comes */
};

/* Compares the payload with the job's own record. ERR_PROTOCOL: it contradicts it. ERR_CONFLICT: it
 * is beyond where the job stops. */
bool merge_check(const struct job *, const struct wire_samples *, struct err *) MUST_CHECK;

/* A checked payload of an open job. A lease on its pass ends: the caller drops its record. */
enum merge_result merge_deliver(struct job *, const struct wire_samples *, int64_t now_ms);

/* The last complete round was judged not good enough: lets the next one in, and what is held of it. */
void merge_next_round(struct job *, int64_t now_ms);

bool merge_is_complete(const struct job *); /* every pass up to the spp target is in */
bool merge_wants_judge(const struct job *); /* error target: a complete round is not judged yet */

const char *merge_result_name(enum merge_result);

#endif
