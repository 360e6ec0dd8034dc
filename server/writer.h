/* writer.h - the one thread that does slow output: checkpoints, images, error estimates.
 *
 * A task carries a snapshot of everything it needs and is handed over through a queue; once
 * carried out it comes back to the owner's inbox as MESSAGE_WRITTEN. It shares nothing with
 * the job meanwhile; `job` is carried along and never followed here.
 * SPDX-License-Identifier: MIT */
#ifndef SERVER_WRITER_H
#define SERVER_WRITER_H

#include "server/checkpoint.h"
#include "server/disk.h"
#include "server/queue.h"

enum writer_part {
    WRITER_FILM = 1,  /* the checkpoint */
    WRITER_ERROR = 2, /* estimate_error, and the rest of the report */
    WRITER_IMAGE = 4, /* progressive EXR and PNG */
    WRITER_FINAL = 8, /* the image is the last one: compressed */
};

struct job;

struct writer_task {
    unsigned parts; /* of enum writer_part */
    struct job *job;
    struct checkpoint snapshot;     /* owned */
    uint32_t judge_spp;             /* of the round to be judged; 0: none is */
    char directory[DISK_PATH - 32]; /* STATE/jobs/ID */
    /* Filled by the writer. */
    bool ok; /* everything asked for is on disk */
    struct err err;
    struct adaptive_look look; /* of a judged round; memory of the arena */
    struct arena arena;
    double error; /* WRITER_ERROR and WRITER_IMAGE; < 0: unknown. With snapshot.row.report */
    char digest[HASH_HEX]; /* WRITER_IMAGE */
    int64_t took_ms;
};

struct writer; /* opaque */

struct writer *writer_start(struct queue *inbox);
void writer_push(struct writer *, struct writer_task *);
void writer_stop(struct writer *); /* after every task has come back */

void writer_task_free(struct writer_task *);
void writer_run(struct writer_task *); /* what the thread does with one */

#endif
