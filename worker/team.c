/* SPDX-License-Identifier: MIT */
#include "worker/team.h"

#include <pthread.h>
#include <stdatomic.h>

#include "common/clock.h"
#include "common/log.h"

enum { MOST = 256, REPORT_MS = 2000 };

struct piece {
    crew_task *task;
    void *arg;
    uint32_t count;
    atomic_uint next, done;
};

static void *work(void *user)
{
    struct piece *p = user;
    for (uint32_t i; (i = atomic_fetch_add(&p->next, 1)) < p->count;) {
        p->task(p->arg, i);
        atomic_fetch_add(&p->done, 1);
    }
    return NULL;
}

/* The caller's share of the work, and its word on the progress. */
static void work_and_tell(struct piece *p, const struct team *team)
{
    int64_t told_ms = clock_ms();
    for (uint32_t i; (i = atomic_fetch_add(&p->next, 1)) < p->count;) {
        p->task(p->arg, i);
        const uint32_t done = atomic_fetch_add(&p->done, 1) + 1;
        if (clock_ms() - told_ms < REPORT_MS)
            continue;
        told_ms = clock_ms();
        log_info("scene_preparing document=%.12s step=%u done=%u%%", team->what, team->pieces,
                 (unsigned)((uint64_t)done * 100 / p->count));
    }
}

static void run(void *user, crew_task *task, void *arg, uint32_t count)
{
    struct team *team = user;
    struct piece p = {.task = task, .arg = arg, .count = count};
    atomic_init(&p.next, 0);
    atomic_init(&p.done, 0);
    team->pieces++;
    pthread_t thread[MOST];
    uint32_t started = 0;
    const uint32_t wanted = min_u32(min_u32(team->threads, MOST), count);
    while (started + 1 < wanted && !pthread_create(&thread[started], NULL, work, &p))
        started++; /* fewer than wanted will do */
    work_and_tell(&p, team);
    for (uint32_t i = 0; i < started; i++)
        pthread_join(thread[i], NULL);
}

struct crew team_crew(struct team *team)
{
    return (struct crew){run, team};
}
