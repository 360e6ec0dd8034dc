/* rate.h - events per second over the last ten seconds or so.
 *
 * The first event only starts the clock: what came before it (workers starting, scenes being
 * prepared) says nothing about speed. Pure; time is an argument.
 * SPDX-License-Identifier: MIT */
#ifndef SERVER_RATE_H
#define SERVER_RATE_H

#include "common/base.h"

enum { RATE_BUCKETS = 20, RATE_BUCKET_MS = 500 };

struct rate { /* zero-initialised: nothing has happened yet */
    bool started;
    int64_t since_ms;               /* the first event */
    int64_t bucket;                 /* the newest one: time / RATE_BUCKET_MS */
    double amount[RATE_BUCKETS];    /* [bucket % RATE_BUCKETS] */
    double total;                   /* since the first event, without it */
};

void rate_add(struct rate *, double amount, int64_t now_ms);
double rate_per_second(const struct rate *, int64_t now_ms); /* 0: unknown */

#endif
