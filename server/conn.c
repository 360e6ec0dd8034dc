/* SPDX-License-Identifier: MIT */
#include "server/conn.h"

#include <pthread.h>
#include <stdlib.h>
#include <sys/socket.h>

#include "common/arena.h"

enum {
    PATIENCE_MS = 15000, /* for headers, and before a body's first bytes count */
    IDLE_MS = 75000,     /* longer than a worker needs between two calls */
    BYTES_PER_MS = 16,   /* the slowest peer that we wait for: 16 kB/s */
};

struct conn {
    struct conn *next, **link; /* link: what points to us */
    int fd;
    enum conn_phase phase;
    int64_t since_ms;
    uint64_t bytes; /* that this phase has moved or has to move */
};

struct conn_list {
    pthread_mutex_t lock; /* guards the list and every field in it */
    struct conn *first;
};

struct conn_list *conn_list_new(void)
{
    struct conn_list *all = arena_malloc(1, sizeof *all);
    pthread_mutex_init(&all->lock, NULL);
    return all;
}

void conn_list_free(struct conn_list *all)
{
    pthread_mutex_destroy(&all->lock);
    free(all);
}

struct conn *conn_new(struct conn_list *all, int fd, int64_t now_ms)
{
    struct conn *c = arena_malloc(1, sizeof *c);
    c->fd = fd;
    c->phase = CONN_HEADERS;
    c->since_ms = now_ms;
    pthread_mutex_lock(&all->lock);
    c->next = all->first;
    c->link = &all->first;
    if (c->next)
        c->next->link = &c->next;
    all->first = c;
    pthread_mutex_unlock(&all->lock);
    return c;
}

void conn_free(struct conn_list *all, struct conn *c)
{
    pthread_mutex_lock(&all->lock);
    *c->link = c->next;
    if (c->next)
        c->next->link = c->link;
    pthread_mutex_unlock(&all->lock);
    free(c);
}

void conn_enter(struct conn_list *all, struct conn *c, enum conn_phase phase, uint64_t bytes,
                int64_t now_ms)
{
    pthread_mutex_lock(&all->lock);
    c->phase = phase;
    c->since_ms = now_ms;
    c->bytes = bytes;
    pthread_mutex_unlock(&all->lock);
}

void conn_received(struct conn_list *all, struct conn *c, uint64_t bytes)
{
    pthread_mutex_lock(&all->lock);
    c->bytes += bytes;
    pthread_mutex_unlock(&all->lock);
}

static int64_t allowance_ms(const struct conn *c)
{
    switch (c->phase) {
    case CONN_HEADERS:
        return PATIENCE_MS;
    case CONN_BODY:
    case CONN_DOWNLOAD:
        return PATIENCE_MS + (int64_t)(c->bytes / BYTES_PER_MS);
    case CONN_ANSWER:
        return INT64_MAX;
    case CONN_IDLE:
        return IDLE_MS;
    }
    __builtin_unreachable();
}

size_t conn_reap(struct conn_list *all, int64_t now_ms)
{
    size_t count = 0;
    pthread_mutex_lock(&all->lock);
    for (struct conn *c = all->first; c; c = c->next)
        if (now_ms - c->since_ms > allowance_ms(c)) {
            shutdown(c->fd, SHUT_RDWR); /* its pool thread notices and closes it */
            c->since_ms = now_ms;
            count++;
        }
    pthread_mutex_unlock(&all->lock);
    return count;
}
