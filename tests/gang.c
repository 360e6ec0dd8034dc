/* SPDX-License-Identifier: MIT */
#include "tests/gang.h"

#include <pthread.h>
#include <stdatomic.h>
#include <stdlib.h>

#include "common/arena.h"
#include "tests/dice.h"

struct work {
    crew_task *task;
    void *arg;
    const uint32_t *order;
    uint32_t count;
    atomic_uint next;
};

static void *help(void *user)
{
    struct work *w = user;
    for (uint32_t i; (i = atomic_fetch_add(&w->next, 1)) < w->count;)
        w->task(w->arg, w->order[i]);
    return NULL;
}

static void run(void *user, crew_task *task, void *arg, uint32_t count)
{
    struct gang *team = user;
    struct dice d = dice_make(team->seed);
    uint32_t *order = arena_malloc(count + 1, sizeof *order);
    for (uint32_t i = 0; i < count; i++) { /* Fisher and Yates, from the inside out */
        const uint32_t j = dice_bits(&d) % (i + 1);
        order[i] = order[j];
        order[j] = i;
    }
    struct work w = {.task = task, .arg = arg, .order = order, .count = count};
    pthread_t threads[TEAM_MOST];
    for (uint32_t i = 0; i < team->threads; i++)
        if (pthread_create(&threads[i], NULL, help, &w))
            abort();
    for (uint32_t i = 0; i < team->threads; i++)
        pthread_join(threads[i], NULL);
    team->tasks += count;
    free(order);
}

struct crew gang_crew(struct gang *team)
{
    return (struct crew){run, team};
}
