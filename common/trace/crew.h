/* crew.h - work that may be done by several threads, for a core that knows none.
 *
 * The caller's crew runs task(arg, i) for all i < count, in any order, at the same time or one
 * after the other, and returns when all are done. Results do not depend on which.
 * SPDX-License-Identifier: MIT */
#ifndef COMMON_TRACE_CREW_H
#define COMMON_TRACE_CREW_H

#include "common/base.h"

typedef void crew_task(void *arg, uint32_t i);

struct crew {
    void (*run)(void *user, crew_task *task, void *arg, uint32_t count);
    void *user;
};

/* crew NULL: here and now. */
static inline void crew_run(const struct crew *crew, crew_task *task, void *arg, uint32_t count)
{
    if (crew) {
        crew->run(crew->user, task, arg, count);
        return;
    }
    for (uint32_t i = 0; i < count; i++)
        task(arg, i);
}

#endif
