/* problem.h - RFC 9457 problem documents.
 * SPDX-License-Identifier: MIT */
#ifndef SERVER_PROBLEM_H
#define SERVER_PROBLEM_H

#include "server/route.h"

void problem_reply(const struct request *, struct reply *, int status, const char *fmt, ...)
    PRINTF(4, 5);
void problem_from_err(const struct request *, struct reply *, const struct err *);

/* 400 for text that is not JSON, 422 with a list of pointers for a document that is wrong. */
void problem_scene(const struct request *, struct reply *, const struct scene_errors *);

/* 409 with the hashes of the assets that are not here. */
void problem_missing(const struct request *, struct reply *, const char *const *hex, size_t count);

#endif
