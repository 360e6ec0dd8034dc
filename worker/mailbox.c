/* SPDX-License-Identifier: MIT */
#include "worker/mailbox.h"

#include <assert.h>
#include <pthread.h>
#include <stdlib.h>
#include <sys/eventfd.h>

#include "common/arena.h"

struct mailbox {
    pthread_mutex_t mutex;
    pthread_cond_t not_empty, not_full;
    void **ring;
    size_t capacity, head, count; /* the oldest is ring[head] */
    int event_fd;
    bool closed;
};

struct mailbox *mailbox_new(size_t capacity, int event_fd)
{
    struct mailbox *m = arena_malloc(1, sizeof *m);
    pthread_mutex_init(&m->mutex, NULL);
    pthread_cond_init(&m->not_empty, NULL);
    pthread_cond_init(&m->not_full, NULL);
    m->ring = arena_malloc(capacity, sizeof *m->ring);
    m->capacity = capacity;
    m->event_fd = event_fd;
    return m;
}

void mailbox_free(struct mailbox *m)
{
    assert(!m->count);
    pthread_cond_destroy(&m->not_full);
    pthread_cond_destroy(&m->not_empty);
    pthread_mutex_destroy(&m->mutex);
    free(m->ring);
    free(m);
}

void mailbox_push(struct mailbox *m, void *item)
{
    pthread_mutex_lock(&m->mutex);
    while (m->count == m->capacity)
        pthread_cond_wait(&m->not_full, &m->mutex);
    m->ring[(m->head + m->count++) % m->capacity] = item;
    pthread_cond_signal(&m->not_empty);
    pthread_mutex_unlock(&m->mutex);
    if (m->event_fd >= 0)
        eventfd_write(m->event_fd, 1);
}

/* With the mutex held and something inside. */
static void *take(struct mailbox *m)
{
    void *item = m->ring[m->head];
    m->head = (m->head + 1) % m->capacity;
    m->count--;
    pthread_cond_signal(&m->not_full);
    return item;
}

void *mailbox_pop(struct mailbox *m)
{
    pthread_mutex_lock(&m->mutex);
    while (!m->count && !m->closed)
        pthread_cond_wait(&m->not_empty, &m->mutex);
    void *item = m->closed ? NULL : take(m);
    pthread_mutex_unlock(&m->mutex);
    return item;
}

void *mailbox_try_pop(struct mailbox *m)
{
    pthread_mutex_lock(&m->mutex);
    void *item = m->count ? take(m) : NULL;
    pthread_mutex_unlock(&m->mutex);
    return item;
}

void mailbox_close(struct mailbox *m)
{
    pthread_mutex_lock(&m->mutex);
    m->closed = true;
    pthread_cond_broadcast(&m->not_empty);
    pthread_mutex_unlock(&m->mutex);
}
