/* output.h - what is handed to the writer when, and what follows from its answers.
 *
 * A job has one task at the writer at a time. Images and checkpoints have least intervals
 * and are spaced so that they cost less than a fiftieth of the time. A job becomes `done` when
 * its final image and film are on disk and its row says so, in this order.
 * Owner thread only.
 * SPDX-License-Identifier: MIT */
#ifndef SERVER_OUTPUT_H
#define SERVER_OUTPUT_H

#include "server/server.h"

void output_turn(struct server *);                          /* hands over what is due */
void output_written(struct server *, struct writer_task *); /* one came back: frees it */

/* A job that was cancelled or has failed: one last image of what it has. Closes the job. */
void output_last(struct server *, struct job *);

bool output_is_settled(const struct server *); /* stopping: nothing is left to write */

#endif
