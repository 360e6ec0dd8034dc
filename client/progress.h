/* progress.h - how a job goes, as one line that moves on a terminal and as plain lines elsewhere.
 * SPDX-License-Identifier: MIT */
#ifndef CLIENT_PROGRESS_H
#define CLIENT_PROGRESS_H

#include <stdio.h>

#include "client/remote.h"

enum progress_style { PROGRESS_QUIET, PROGRESS_PLAIN, PROGRESS_MOVING };

struct progress {
    FILE *out;
    enum progress_style style;
    enum remote_state last_state;
    int64_t last_ms;       /* of the last plain line */
    bool started, on_line; /* on_line: the cursor stands behind a moving line */
    const char *above;     /* lines to show above a moving line, or NULL; the caller's */
    int lines;             /* of `above` that were shown */
};

/* MOVING when out is a terminal. */
struct progress progress_make(FILE *out, bool quiet);
void progress_show(struct progress *, const struct remote_job *, int64_t now_ms);
void progress_end(struct progress *); /* leaves the cursor on a fresh line */

/* " 43 %  110 spp  error 0.041  1.20 Msamples/s  2 workers  0:41 left". What is not known is left
 * out. */
void progress_text(const struct remote_job *, char *out, size_t bytes);

/* "110 spp"; of a job that is over and whose pixels have different numbers "32 to 512 spp". */
void progress_samples(const struct remote_job *, char *out, size_t bytes);

#endif
