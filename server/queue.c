/* SPDX-License-Identifier: MIT */
#include "server/queue.h"

#include <pthread.h>
#include <stdlib.h>
#include <time.h>

#include "common/arena.h"

struct queue {
    pthread_mutex_t lock; /* guards everything below */
    pthread_cond_t filled, emptied;
    struct message *ring;
    size_t capacity, first, count;
};

struct queue *queue_new(size_t capacity)
{
    struct queue *q = arena_malloc(1, sizeof *q);
    q->ring = arena_malloc(capacity, sizeof *q->ring);
    q->capacity = capacity;
    pthread_condattr_t monotonic;
    pthread_condattr_init(&monotonic);
    pthread_condattr_setclock(&monotonic, CLOCK_MONOTONIC);
    pthread_mutex_init(&q->lock, NULL);
    pthread_cond_init(&q->filled, &monotonic);
    pthread_cond_init(&q->emptied, &monotonic);
    pthread_condattr_destroy(&monotonic);
    return q;
}

void queue_free(struct queue *q)
{
    pthread_cond_destroy(&q->emptied);
    pthread_cond_destroy(&q->filled);
    pthread_mutex_destroy(&q->lock);
    free(q->ring);
    free(q);
}

void queue_push(struct queue *q, struct message m)
{
    pthread_mutex_lock(&q->lock);
    while (q->count == q->capacity)
        pthread_cond_wait(&q->emptied, &q->lock);
    q->ring[(q->first + q->count++) % q->capacity] = m;
    pthread_cond_signal(&q->filled);
    pthread_mutex_unlock(&q->lock);
}

bool queue_pop(struct queue *q, struct message *m, int64_t until_ms)
{
    const struct timespec until = {.tv_sec = until_ms / 1000, .tv_nsec = until_ms % 1000 * 1000000};
    pthread_mutex_lock(&q->lock);
    while (!q->count)
        if (pthread_cond_timedwait(&q->filled, &q->lock, &until) != 0)
            break;
    const bool some = q->count > 0;
    if (some) {
        *m = q->ring[q->first];
        q->first = (q->first + 1) % q->capacity;
        q->count--;
        pthread_cond_signal(&q->emptied);
    }
    pthread_mutex_unlock(&q->lock);
    return some;
}
