/* mailbox.h - a bounded queue of pointers between threads; what is in it belongs to it.
 *
 * One mutex, two condition variables. A reader that waits for other things as well gives an
 * eventfd: it becomes readable with every mailbox_push.
 * SPDX-License-Identifier: MIT */
#ifndef WORKER_MAILBOX_H
#define WORKER_MAILBOX_H

#include "common/base.h"

struct mailbox; /* opaque, heap */

struct mailbox *mailbox_new(size_t capacity, int event_fd); /* event_fd -1: none */
void mailbox_free(struct mailbox *);                        /* must be empty */

void mailbox_push(struct mailbox *, void *item); /* waits while it is full */
void *mailbox_pop(struct mailbox *);             /* waits while it is empty; NULL: closed */
void *mailbox_try_pop(struct mailbox *);         /* NULL: empty. Also after closing */
void mailbox_close(struct mailbox *);            /* mailbox_pop returns NULL from now on */

#endif
