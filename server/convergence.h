/* convergence.h - the convergence of a job: its error against its samples, as it went.
 *
 * A point is taken whenever the writer has estimated the error and there are a twentieth more
 * samples than at the last one; that makes some hundred of a long job. Points are kept in the
 * store, so they outlast the coordinator and the film. Owner thread only.
 * SPDX-License-Identifier: MIT */
#ifndef SERVER_CONVERGENCE_H
#define SERVER_CONVERGENCE_H

#include "common/forecast.h"
#include "server/store.h"

struct convergence {
    struct store_point *points; /* by samples, ascending; heap */
    size_t count, capacity;
};

void convergence_release(struct convergence *);

bool convergence_load(struct convergence *, struct store *, uint64_t number,
                      struct err *) MUST_CHECK;

/* The row as it was when its error was estimated, row->error. Keeps the point if it is one, and
 * stores it. ERR_IO: it is kept in memory alone. */
bool convergence_note(struct convergence *, struct store *, const struct store_job *row,
                      struct err *) MUST_CHECK;

/* False without a point to start from. */
bool convergence_forecast(const struct convergence *, double target, struct forecast *);

#endif
