/* body.h - JSON bodies in and out. The one place where requests and replies meet jansson; its
 * type is named here, its header is not.
 * SPDX-License-Identifier: MIT */
#ifndef SERVER_BODY_H
#define SERVER_BODY_H

#include "server/route.h"

struct json_t;

/* The request's body; the caller owns it. NULL: not JSON, and the reply says where. */
struct json_t *body_parse(const struct request *, struct reply *);

/* Fills the reply and releases the document. */
void body_reply(const struct request *, struct reply *, int status, struct json_t *);

#endif
