/* err.h - the one error value.
 *
 * A function that can fail for reasons outside the program returns bool, takes
 * `struct err *` last (never NULL), and fills it exactly when it returns false.
 * Our own bugs are asserts; lack of memory aborts (arena.c). The caller acts on
 * the code; people read the text. No allocation, no globals, any thread.
 * SPDX-License-Identifier: MIT */
#ifndef COMMON_ERR_H
#define COMMON_ERR_H

#include "common/base.h"

enum err_code {
    ERR_INPUT,     /* the caller's data is wrong: tell them, never retry */
    ERR_LIMIT,     /* well formed, but larger than we agree to render */
    ERR_NOT_FOUND, /* no such job, asset, file */
    ERR_CONFLICT,  /* stale lease, job already finished */
    ERR_PROTOCOL,  /* the peer broke the wire rules: drop the message */
    ERR_IO,        /* the system failed: may be retried */
};

struct err {
    enum err_code code;
    char text[512]; /* UTF-8, NUL-terminated, no newline at the end */
};

/* Both always return false, so that a failure is one statement. */
bool err_set(struct err *, enum err_code, const char *fmt, ...) PRINTF(3, 4);
bool err_at(struct err *, const char *fmt, ...) PRINTF(2, 3); /* prefixes "where: " */

#endif
