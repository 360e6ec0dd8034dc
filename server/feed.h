/* feed.h - what workers ask for: leases, renewal, delivery, giving back; and the list of workers.
 *
 * A call that finds no work is parked until there is some or its time is up; feed_turn looks after
 * parked calls and lapsed leases. Owner thread only, except the feed_prepare_* functions.
 * SPDX-License-Identifier: MIT */
#ifndef SERVER_FEED_H
#define SERVER_FEED_H

#include "server/server.h"

route_prepare feed_prepare_delivery; /* decodes the payload; pool threads */

route_handler feed_lease;   /* POST   /v1/leases */
route_handler feed_deliver; /* PUT    /v1/leases/ID */
route_handler feed_plan;    /* PUT    /v1/leases/ID/plan */
route_handler feed_renew;   /* POST   /v1/leases/ID/renew */
route_handler feed_return;  /* DELETE /v1/leases/ID */
route_handler feed_workers; /* GET    /v1/workers */
route_handler feed_worker;  /* PATCH  /v1/workers/NAME */

void feed_turn(struct server *);
int64_t feed_next_deadline(const struct server *); /* of a parked call; INT64_MAX: none */
void feed_release(struct server *);                /* answers all parked calls: shutting down */

#endif
