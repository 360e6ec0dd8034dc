/* status.h - a job as people and programs see it (docs/http.md, "The job").
 * SPDX-License-Identifier: MIT */
#ifndef SERVER_STATUS_H
#define SERVER_STATUS_H

#include "server/server.h"

struct json_t;

struct json_t *status_job(const struct server *, const struct job *); /* the caller owns it */

#endif
