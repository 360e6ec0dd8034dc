/* pretend.h - a client and a worker of a daemon that only pretend to trace: payloads are
 * fake_job.h's. JSON that is returned is the caller's. SPDX-License-Identifier: MIT */
#ifndef TESTS_PRETEND_H
#define TESTS_PRETEND_H

#include "tests/daemon.h"

struct json_t;

struct json_t *pretend_ask(const struct daemon *, int *status, const char *method,
                           const char *target, const char *body);
const char *pretend_text(const struct json_t *, const char *key); /* "": none */

void pretend_submit(const struct daemon *, char id[17], uint32_t side, const char *target);
struct json_t *pretend_job(const struct daemon *, const char *id);
bool pretend_job_is(const struct daemon *, const char *id, const char *state);
/* A number of the job, or of a group in it. */
int64_t pretend_count(const struct daemon *, const char *id, const char *group, const char *key);

struct json_t *pretend_lease(const struct daemon *, const char *worker, int want, int wait_ms);

/* The status; of the blocks that the lease names. */
int pretend_deliver_with(const struct daemon *, const struct json_t *lease, const char *worker,
                         float noise, char result[16]);
int pretend_deliver(const struct daemon *, const struct json_t *lease, char result[16]);

/* Takes up to `most` leases in fours and delivers them, last first. How many were delivered. */
int pretend_work(const struct daemon *, int most);
bool pretend_work_until(const struct daemon *, const char *id, const char *state); /* 20 s */

#endif
