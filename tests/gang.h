/* gang.h - a crew of threads for the builder (crew.h), which takes its tasks in a shuffled order.
 * SPDX-License-Identifier: MIT */
#ifndef TESTS_GANG_H
#define TESTS_GANG_H

#include "common/trace/crew.h"

enum { TEAM_MOST = 8 };

struct gang {
    uint32_t threads; /* at most TEAM_MOST */
    uint64_t seed;    /* of the order */
    uint32_t tasks;   /* how many there were */
};

struct crew gang_crew(struct gang *);

#endif
