/* queue.h - a bounded queue of messages between threads: one mutex, two condition variables.
 *
 * A message hands the ownership of `data` over. queue_push waits while the queue is full; any
 * number of threads may push and pop. Time is clock_ms's.
 * SPDX-License-Identifier: MIT */
#ifndef SERVER_QUEUE_H
#define SERVER_QUEUE_H

#include "common/base.h"

enum message_kind {
    MESSAGE_REQUEST, /* data: struct exchange, decoded and checked; the owner answers it */
    MESSAGE_WRITTEN, /* data: struct writer_task, carried out */
    MESSAGE_WRITE,   /* data: struct writer_task, for the writer */
    MESSAGE_STOP,    /* data: NULL */
};

struct message {
    enum message_kind kind;
    void *data;
};

struct queue; /* opaque */

struct queue *queue_new(size_t capacity);
void queue_free(struct queue *); /* messages still inside are not freed */
void queue_push(struct queue *, struct message);
bool queue_pop(struct queue *, struct message *, int64_t until_ms); /* false: nothing came in time */

#endif
