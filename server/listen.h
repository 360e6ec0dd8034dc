/* listen.h - a listening TCP socket. The address was checked by config.c: IPv4 or ::1.
 * SPDX-License-Identifier: MIT */
#ifndef SERVER_LISTEN_H
#define SERVER_LISTEN_H

#include "common/err.h"

/* -1: failed. `bound` is the port it got, which matters when `port` is 0. */
int listen_open(const char *address, uint16_t port, uint16_t *bound, struct err *);

#endif
