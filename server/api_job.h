/* api_job.h - what handlers of jobs share. SPDX-License-Identifier: MIT */
#ifndef SERVER_API_JOB_H
#define SERVER_API_JOB_H

#include "server/route.h"
#include "server/server.h"

/* By the id in a path; NULL: there is none, and the reply says so. */
struct job *api_job_of(const struct server *, const struct request *, struct reply *,
                       const char *text);
/* The job as it is; 304 when the reader knows it. */
void api_job_reply(const struct server *, const struct request *, struct reply *, int status,
                   const struct job *);

#endif
