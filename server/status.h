/* status.h - a job as people and programs see it (docs/http.md, "The job").
 * SPDX-License-Identifier: MIT */
#ifndef SERVER_STATUS_H
#define SERVER_STATUS_H

#include "server/server.h"

struct json_t;

/* The caller owns what is returned. */
struct json_t *status_job(const struct server *, const struct job *);
struct json_t *status_curve(const struct server *, const struct job *, const struct convergence *);

#endif
