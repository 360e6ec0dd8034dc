/* save.h - a file that is whole or not there: written beside, made durable, renamed.
 * SPDX-License-Identifier: MIT */
#ifndef CLIENT_SAVE_H
#define CLIENT_SAVE_H

#include "common/buf.h"
#include "common/err.h"

bool save_file(const char *path, const struct buf *bytes, struct err *) MUST_CHECK;

/* Whether save_file could write there: before an hour of rendering, not after. */
bool save_possible(const char *path, struct err *) MUST_CHECK;

#endif
