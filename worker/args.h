/* args.h - the worker's flags and environment as one struct.
 * SPDX-License-Identifier: MIT */
#ifndef WORKER_ARGS_H
#define WORKER_ARGS_H

#include "common/err.h"
#include "common/log.h"

struct args {
    const char *server;   /* http://HOST:PORT */
    uint32_t threads;     /* that render */
    const char *cache;    /* directory of assets and prepared scenes */
    uint64_t cache_bytes; /* its bound */
    uint64_t stage_bytes; /* prepared scenes kept in memory beside those in use */
    const char *name;     /* 1 to 64 of A-Z a-z 0-9 . _ - ; unique to the process */
    enum log_level log;
    char cache_default[512], name_default[72]; /* what cache, name point to unless flags say else */
};

enum args_result { ARGS_RUN, ARGS_DONE /* --help, --version: printed */, ARGS_WRONG };

enum args_result args_parse(struct args *, int argc, char *const *argv, struct err *);
void args_log(const struct args *);

#endif
