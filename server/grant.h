/* grant.h - from "some work, please" to leases in an answer, and what the end of a lease does to
 * its pass and job. Owner thread only. SPDX-License-Identifier: MIT */
#ifndef SERVER_GRANT_H
#define SERVER_GRANT_H

#include "server/server.h"

enum { GRANT_MAX_WANT = 64, GRANT_MAX_HELD = 256 /* leases of one worker */ };

struct json_t;

bool grant_possible(struct server *, const struct worker *); /* is there work for it? */

/* {"leases": [...]}, "drain": true for a worker that shall go. The caller owns it. */
struct json_t *grant_leases(struct server *, struct worker *, uint32_t want, size_t *granted);

void grant_expired(struct server *, struct lease *);
void grant_returned(struct server *, struct lease *);
void grant_failed(struct server *, struct lease *, const char *reason);   /* on this worker */
void grant_job_failed(struct server *, struct job *, const char *reason); /* on every worker */

#endif
