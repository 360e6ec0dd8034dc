/* link.h - the coordinator, as calls that are started and events that tell how they ended.
 *
 * Calls run side by side on kept connections, so a delivery waits neither for the next leases
 * nor for a renewal. What the coordinator says is checked here: an event's leases are within the
 * limits of the formats (whether they fit the scene is checked when it is loaded).
 *
 * When no answer comes, or 5xx, the link closes for a while: 0.1 s, doubling to 10 s, each time
 * between half and all of it by chance, so that a farm does not come back all at once. The first
 * answer opens it. Calls may be started only while it is open. One thread at a time.
 * SPDX-License-Identifier: MIT */
#ifndef WORKER_LINK_H
#define WORKER_LINK_H

#include "common/block.h"
#include "common/buf.h"
#include "common/err.h"
#include "common/hash.h"
#include "common/plan.h"
#include "common/tile.h"

enum { LINK_ID = 17, LINK_MAX_LEASES = 64 };

struct link_lease {
    char id[LINK_ID]; /* 16 hex digits */
    char job[LINK_ID];
    uint64_t job_number; /* the same as a number */
    char document[HASH_HEX];
    bool plan;                       /* a plan is to be made; else a pass to be rendered: */
    enum plan_candidate_kind method; /* PLAN_REAL: as the document says */
    uint32_t tile;
    struct tile_rect rect;
    struct block_set blocks; /* of rect: those to be rendered */
    uint32_t pass_index;
    struct tile_pass pass;
    int64_t ttl_ms;
};

enum link_kind { LINK_ASK, LINK_RENEW, LINK_DELIVER, LINK_RETURN, LINK_STATE };

struct link_event {
    enum link_kind kind;
    int status;       /* of HTTP; 0: no answer */
    char id[LINK_ID]; /* RENEW, DELIVER, RETURN: the lease's */
    uint32_t wanted;  /* ASK, DELIVER: leases that were asked for */
    bool drain;       /* ASK, DELIVER: finish and go */
    int64_t ttl_ms;   /* RENEW */
    char result[16];  /* DELIVER: "merged", "held", "duplicate", "planned" */
    struct link_lease leases[LINK_MAX_LEASES]; /* ASK, DELIVER: at most `wanted` */
    uint32_t lease_count;
    char text[512]; /* why, when status is not 2xx */
};

struct link; /* opaque, heap */

/* name, version: borrowed for the link's life. NULL: the address makes no sense. */
struct link *link_new(const char *server, const char *name, uint32_t threads, struct err *err);
void link_free(struct link *); /* drops what still runs */

bool link_is_open(const struct link *, int64_t now_ms);
int64_t link_opens_ms(const struct link *); /* when it does; in the past when it is open */
uint32_t link_running(const struct link *); /* calls under way */

void link_ask(struct link *, uint32_t want, uint32_t wait_ms);
void link_renew(struct link *, const char *id);
/* payload: borrowed until the event comes */
void link_deliver(struct link *, const char *id, const struct buf *payload, uint32_t want);
void link_deliver_plan(struct link *, const char *id, const struct buf *text, uint32_t want);
/* kind: "worker", "input", or NULL for a lease that is handed back without fault */
void link_return(struct link *, const char *id, const char *kind, const char *reason);
void link_state(struct link *, const char *state); /* of this worker: "draining", "active" */

/* As http_client_poll: true, an event. */
bool link_poll(struct link *, int64_t timeout_ms, const int *fds, size_t fd_count,
               struct link_event *);

#endif
