/* lease.h - who holds which pass until when: grant, renew, expire.
 *
 * A heap ordered by deadline finds what has lapsed, a hash finds a lease by its id; both are told
 * of every move, so a renewal is O(log n). Leases are not durable: after a restart there are none, and
 * ids begin with another nonce, so an old id cannot name a new lease. Pure; time is an argument.
 * SPDX-License-Identifier: MIT */
#ifndef SERVER_LEASE_H
#define SERVER_LEASE_H

#include "common/base.h"

struct job;
struct worker;

struct lease {
    uint64_t id; /* never 0 */
    struct job *job;
    struct worker *worker;
    uint32_t tile, pass;
    int64_t deadline_ms; /* lapses when now >= deadline */
    size_t at;           /* its place in the heap; private */
};

struct lease_table; /* opaque */

struct lease_table *lease_table_new(uint32_t nonce);
void lease_table_free(struct lease_table *);
size_t lease_count(const struct lease_table *);

/* The lease stays valid until it is dropped. */
struct lease *lease_grant(struct lease_table *, struct job *, uint32_t tile, uint32_t pass,
                          struct worker *, int64_t deadline_ms);
struct lease *lease_find(const struct lease_table *, uint64_t id); /* NULL: not held */
void lease_renew(struct lease_table *, struct lease *, int64_t deadline_ms);
void lease_drop(struct lease_table *, struct lease *); /* frees it */

struct lease *lease_first_due(const struct lease_table *, int64_t now_ms); /* NULL: none lapsed */
int64_t lease_next_deadline(const struct lease_table *);                   /* INT64_MAX: none */

/* All leases, in no order: at = 0 .. lease_count - 1. Dropping one disturbs the numbering. */
struct lease *lease_at(const struct lease_table *, size_t at);

#endif
