/* daemon.h - a coordinator in a child process, and raw bytes to and from it. The parent must not
 * have threads when it starts one. SPDX-License-Identifier: MIT */
#ifndef TESTS_DAEMON_H
#define TESTS_DAEMON_H

#include <sys/types.h>

#include "common/buf.h"

struct daemon {
    pid_t pid;
    uint16_t port;
    char dir[256]; /* its state directory, and what else it writes */
};

/* flags: smaltid's own, ended by NULL; the state directory is `dir` (made when empty). */
bool daemon_start(struct daemon *, const char *const *flags);
int daemon_stop(struct daemon *);    /* SIGTERM; its exit status, or -1 */
void daemon_kill(struct daemon *);   /* SIGKILL */
void daemon_remove(struct daemon *); /* its directory */
bool daemon_lives(const struct daemon *);

int daemon_connect(const struct daemon *); /* a socket; reads give up after ten seconds */

struct answer {
    int status;      /* 0: closed without an answer, -1: nothing came in time */
    struct buf text; /* head and body, NUL at the end */
    const char *body;
};

/* Sends the bytes on a fresh connection, reads one answer. */
struct answer daemon_send(const struct daemon *, const void *bytes, size_t count);
struct answer daemon_read(int socket);
/* A well-formed request; body may be NULL. */
struct answer daemon_call(const struct daemon *, const char *method, const char *target,
                          const char *type, const void *body, size_t bytes);

/* A grey sphere under a white sky, side x side pixels; target: JSON text. Static; the next call overwrites it. */
const char *daemon_scene(uint32_t side, const char *target);

#endif
