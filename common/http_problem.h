/* http_problem.h - what an error answer says (RFC 9457), as a line for people.
 * SPDX-License-Identifier: MIT */
#ifndef COMMON_HTTP_PROBLEM_H
#define COMMON_HTTP_PROBLEM_H

#include "common/buf.h"

/* "422: 2 errors in the scene document". Any body will do, also none. */
void http_problem_text(int status, const struct buf *body, char *out, size_t out_bytes);

/* Entry `index` of the answer's "errors", its strings cut to fit; false: there are no more. */
bool http_problem_entry(const struct buf *body, size_t index, char *pointer, size_t pointer_bytes,
                        char *detail, size_t detail_bytes);

#endif
