/* head.h - a request line and headers, held against the rules before the body is taken.
 *
 * Everything that two readers of a message could understand differently is refused: a second
 * Content-Length, one beside a Transfer-Encoding, several Hosts, %00 in the target.
 * SPDX-License-Identifier: MIT */
#ifndef SERVER_HEAD_H
#define SERVER_HEAD_H

#include "server/route.h"

struct head { /* strings borrowed */
    const char *method, *version;
    bool target_is_sane;
    unsigned host_count, length_count, transfer_count;
    const char *host, *transfer, *content_type, *if_none_match; /* NULL: absent */
    uint64_t length_bytes;
};

void head_add(struct head *, const char *name, const char *value);

/* Finds the route; false: the reply says what is wrong. */
bool head_check(const struct head *, const struct route *routes, size_t count, struct request *,
                struct reply *);

#endif
