/* farm.h - the workers we have heard of.
 *
 * A worker is a name; it exists from its first call on and is forgotten a day after its last one.
 * Owner thread only; time is an argument.
 * SPDX-License-Identifier: MIT */
#ifndef SERVER_FARM_H
#define SERVER_FARM_H

#include "common/base.h"

enum { FARM_NAME = 65, FARM_MAX_WORKERS = 20000 };

enum worker_state { WORKER_ACTIVE, WORKER_DRAINING };

struct worker {
    char name[FARM_NAME];
    uint32_t threads;
    enum worker_state state;
    uint32_t leases;   /* held now */
    uint32_t parked;   /* calls that wait for work */
    uint64_t delivered;
    uint64_t cpu_us;   /* of delivered passes */
    int64_t seen_ms;   /* its last call */
    uint32_t number;   /* never given to another worker; from 1 */
};

struct farm {
    struct worker **workers; /* sorted by name */
    size_t count, capacity;
    uint32_t last_number;
    int64_t patience_ms; /* silent for longer: lost */
};

void farm_init(struct farm *, int64_t lease_ttl_ms);
void farm_release(struct farm *);

bool farm_name_is_sane(const char *); /* 1 to 64 of A-Z a-z 0-9 . _ - */
struct worker *farm_find(const struct farm *, const char *name);
struct worker *farm_call(struct farm *, const char *name, int64_t now_ms); /* NULL: no room */
bool farm_is_lost(const struct farm *, const struct worker *, int64_t now_ms);
size_t farm_present(const struct farm *, int64_t now_ms); /* workers that are not lost */
void farm_forget(struct farm *, int64_t now_ms); /* those that have been silent for a day */

#endif
