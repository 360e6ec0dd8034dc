/* config.h - flags to one struct; refuses what it does not know.
 * SPDX-License-Identifier: MIT */
#ifndef SERVER_CONFIG_H
#define SERVER_CONFIG_H

#include "common/err.h"
#include "common/log.h"

struct config {
    const char *listen;    /* a loopback address, IPv4 or IPv6 */
    uint16_t port;         /* 0: any */
    const char *state_dir;
    const char *announce;  /* file that gets the address once we listen; NULL: none */
    uint32_t tile_px;
    int64_t lease_ttl_ms;
    int64_t checkpoint_ms; /* least time between two checkpoints of a film */
    int64_t image_ms;      /* least time between two images of a job */
    uint64_t memory_bytes; /* of films; jobs beyond it wait */
    enum log_level log;
};

enum config_result { CONFIG_RUN, CONFIG_DONE /* --help, --version: printed */, CONFIG_WRONG };

enum config_result config_parse(struct config *, int argc, char *const *argv, struct err *);
void config_log(const struct config *);

#endif
