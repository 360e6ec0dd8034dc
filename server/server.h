/* server.h - the owner's state and its loop.
 *
 * One thread, the owner, runs server_loop and alone touches what is here: jobs, leases, films,
 * the store. Requests and finished output reach it through `inbox`. Time enters once per turn:
 * now_ms.
 * SPDX-License-Identifier: MIT */
#ifndef SERVER_SERVER_H
#define SERVER_SERVER_H

#include "server/config.h"
#include "server/farm.h"
#include "server/http.h"
#include "server/lease.h"
#include "server/sched.h"
#include "server/writer.h"

struct waiter; /* a worker's call that waits for work (feed.c) */

struct server {
    const struct config *config;
    struct store *store;
    struct queue *inbox;
    struct http *http;
    struct writer *writer;
    uint32_t nonce;     /* of this run: in lease ids and ETags */
    struct job **jobs;  /* all, oldest first */
    struct job **by_id; /* the same, sorted by id */
    size_t job_count, job_capacity;
    struct sched sched;
    struct lease_table *leases;
    struct farm farm;
    struct waiter *first_waiter, **last_waiter;
    uint64_t film_bytes;  /* of open jobs */
    unsigned tasks;       /* with the writer */
    int64_t now_ms;       /* of this turn */
    int64_t next_tick_ms; /* housekeeping, every second */
    bool news;            /* there may be work for who waits */
    bool stopping;
};

/* Opens the state directory, recovers its jobs, listens. */
bool server_open(struct server *, const struct config *, struct err *) MUST_CHECK;
void server_loop(struct server *); /* until MESSAGE_STOP; leaves every film on disk */
void server_close(struct server *);

/* A job that is done, with a target further on. Its film is kept if it is what the new job would
 * have had there, else it begins anew. ERR_IO: nothing has changed. */
bool server_job_continue(struct server *, struct job *, const struct scene_target *,
                         struct err *) MUST_CHECK;
struct job *server_job_find(const struct server *, uint64_t id); /* NULL: none */
struct job *server_job_add(struct server *, const struct store_job *stored);
bool server_job_save(struct server *, struct job *); /* false: logged; tried again by and by */

/* Reads or makes its film; false: it must wait for memory, and is marked starved. */
bool server_job_open(struct server *, struct job *);

/* The end of a job: failed or cancelled here, done by output.c. Drops its leases and memory. */
void server_job_end(struct server *, struct job *, enum job_state);

void server_lease_end(struct server *, struct lease *); /* the record only, not the slot */
/* The records of a job: all, or only those of passes that are not theirs any more. */
void server_leases_end(struct server *, const struct job *, bool all);
void server_job_directory(const struct server *, const struct job *, char *path, size_t bytes);
void server_random(void *data, size_t bytes);

#endif
