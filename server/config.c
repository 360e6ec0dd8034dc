/* SPDX-License-Identifier: MIT */
#include "server/config.h"

#include <arpa/inet.h>
#include <errno.h>
#include <getopt.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/tile.h"

static const char help[] =
    "Usage: smaltid [OPTION]...\n"
    "The coordinator: takes scenes over HTTP, leases their tiles to workers, keeps the images.\n"
    "\n"
    "  --listen ADDR           loopback address to listen on (127.0.0.1)\n"
    "  --port N                port, 0 for any free one (7080)\n"
    "  --state DIR             where jobs, assets and images live (./smalti-state)\n"
    "  --announce FILE         write the address to FILE once listening\n"
    "  --tile N                side of a tile in pixels, 8 to 256 (64)\n"
    "  --lease-ttl SECONDS     a pass not renewed for so long is given to another worker (30)\n"
    "  --checkpoint SECONDS    least time between two checkpoints of a film (10)\n"
    "  --image-interval SECONDS  least time between two images of a running job (2)\n"
    "  --memory MIB            for films; jobs beyond it wait (4096)\n"
    "  --log LEVEL             debug, info, warn or error (info)\n"
    "  --help, --version\n"
    "\n"
    "Exit status: 0 stopped by SIGTERM or SIGINT, 1 the system failed, 2 wrong usage.\n";

static bool read_number(const char *flag, const char *text, double least, double most, double *out,
                        struct err *err)
{
    char *end;
    errno = 0;
    const double v = strtod(text, &end);
    if (end == text || *end || errno || !(v >= least && v <= most))
        return err_set(err, ERR_INPUT, "--%s: expected a number from %g to %g, got '%s'", flag,
                       least, most, text);
    *out = v;
    return true;
}

static bool read_integer(const char *flag, const char *text, double least, double most, double *out,
                         struct err *err)
{
    if (!read_number(flag, text, least, most, out, err))
        return false;
    if (*out != floor(*out) || strspn(text, "0123456789") != strlen(text))
        return err_set(err, ERR_INPUT, "--%s: expected a whole number, got '%s'", flag, text);
    return true;
}

static bool read_seconds(const char *flag, const char *text, double least, int64_t *ms,
                         struct err *err)
{
    double v = 0;
    if (!read_number(flag, text, least, 86400, &v, err))
        return false;
    *ms = (int64_t)(v * 1000);
    return true;
}

static bool read_log(const char *text, enum log_level *level, struct err *err)
{
    static const char *const names[] = {"debug", "info", "warn", "error"};
    for (size_t i = 0; i < countof(names); i++)
        if (!strcmp(text, names[i])) {
            *level = (enum log_level)i;
            return true;
        }
    return err_set(err, ERR_INPUT, "--log: expected debug, info, warn or error, got '%s'", text);
}

/* Only loopback: there are no tokens yet, so whoever reaches the port may do anything. */
static bool check_listen(const char *text, struct err *err)
{
    struct in_addr four;
    struct in6_addr six;
    const bool ok = inet_pton(AF_INET, text, &four) == 1   ? ntohl(four.s_addr) >> 24 == 127
                    : inet_pton(AF_INET6, text, &six) == 1 ? !memcmp(&six, &in6addr_loopback, 16)
                                                           : false;
    return ok || err_set(err, ERR_INPUT,
                         "--listen: expected a loopback address (127.0.0.1, ::1), got '%s'; access "
                         "tokens do not exist yet, so reach another machine's coordinator through "
                         "an SSH tunnel (ssh -L 7080:127.0.0.1:7080 HOST)",
                         text);
}

enum flag {
    FLAG_LISTEN,
    FLAG_PORT,
    FLAG_STATE,
    FLAG_ANNOUNCE,
    FLAG_TILE,
    FLAG_LEASE_TTL,
    FLAG_CHECKPOINT,
    FLAG_IMAGE_INTERVAL,
    FLAG_MEMORY,
    FLAG_LOG,
    FLAG_HELP,
    FLAG_VERSION,
    FLAG_COUNT
};

static const struct option options[FLAG_COUNT + 1] = {
    [FLAG_LISTEN] = {"listen", required_argument, NULL, FLAG_LISTEN},
    [FLAG_PORT] = {"port", required_argument, NULL, FLAG_PORT},
    [FLAG_STATE] = {"state", required_argument, NULL, FLAG_STATE},
    [FLAG_ANNOUNCE] = {"announce", required_argument, NULL, FLAG_ANNOUNCE},
    [FLAG_TILE] = {"tile", required_argument, NULL, FLAG_TILE},
    [FLAG_LEASE_TTL] = {"lease-ttl", required_argument, NULL, FLAG_LEASE_TTL},
    [FLAG_CHECKPOINT] = {"checkpoint", required_argument, NULL, FLAG_CHECKPOINT},
    [FLAG_IMAGE_INTERVAL] = {"image-interval", required_argument, NULL, FLAG_IMAGE_INTERVAL},
    [FLAG_MEMORY] = {"memory", required_argument, NULL, FLAG_MEMORY},
    [FLAG_LOG] = {"log", required_argument, NULL, FLAG_LOG},
    [FLAG_HELP] = {"help", no_argument, NULL, FLAG_HELP},
    [FLAG_VERSION] = {"version", no_argument, NULL, FLAG_VERSION},
};

static bool apply(struct config *c, enum flag flag, const char *text, struct err *err)
{
    const char *name = options[flag].name;
    double v = 0;
    switch (flag) {
    case FLAG_LISTEN:
        c->listen = text;
        return check_listen(text, err);
    case FLAG_PORT:
        if (!read_integer(name, text, 0, 65535, &v, err))
            return false;
        c->port = (uint16_t)v;
        return true;
    case FLAG_STATE:
        c->state_dir = text;
        return *text || err_set(err, ERR_INPUT, "--state: expected a directory, got ''");
    case FLAG_ANNOUNCE:
        c->announce = text;
        return *text || err_set(err, ERR_INPUT, "--announce: expected a file, got ''");
    case FLAG_TILE:
        if (!read_integer(name, text, TILE_MIN_PX, TILE_MAX_PX, &v, err))
            return false;
        if (!tile_px_is_sane((uint64_t)v))
            return err_set(err, ERR_INPUT, "%s: expected a multiple of %d, got %s", name,
                           TILE_STEP_PX, text);
        c->tile_px = (uint32_t)v;
        return true;
    case FLAG_LEASE_TTL:
        return read_seconds(name, text, 0.1, &c->lease_ttl_ms, err);
    case FLAG_CHECKPOINT:
        return read_seconds(name, text, 0, &c->checkpoint_ms, err);
    case FLAG_IMAGE_INTERVAL:
        return read_seconds(name, text, 0, &c->image_ms, err);
    case FLAG_MEMORY:
        if (!read_integer(name, text, 1, 1e9, &v, err))
            return false;
        c->memory_bytes = (uint64_t)v << 20;
        return true;
    case FLAG_LOG:
        return read_log(text, &c->log, err);
    case FLAG_HELP:
    case FLAG_VERSION:
    case FLAG_COUNT:
        break;
    }
    __builtin_unreachable();
}

enum config_result config_parse(struct config *c, int argc, char *const *argv, struct err *err)
{
    *c = (struct config){
        .listen = "127.0.0.1",
        .port = 7080,
        .state_dir = "./smalti-state",
        .tile_px = TILE_DEFAULT_PX,
        .lease_ttl_ms = 30000,
        .checkpoint_ms = 10000,
        .image_ms = 2000,
        .memory_bytes = (uint64_t)4096 << 20,
        .log = LOG_INFO,
    };
    optind = 1;
    opterr = 0;
    for (int flag; (flag = getopt_long(argc, argv, "", options, NULL)) != -1;) {
        if (flag == FLAG_HELP || flag == FLAG_VERSION) {
            fputs(flag == FLAG_HELP ? help : "smaltid " SMALTI_VERSION "\n", stdout);
            return CONFIG_DONE;
        }
        if (flag == '?') {
            err_set(err, ERR_INPUT, "%s: unknown flag, or its value is missing; see --help",
                    argv[optind - 1]);
            return CONFIG_WRONG;
        }
        if (!apply(c, (enum flag)flag, optarg, err))
            return CONFIG_WRONG;
    }
    if (optind < argc) {
        err_set(err, ERR_INPUT, "%s: expected flags only; see --help", argv[optind]);
        return CONFIG_WRONG;
    }
    return CONFIG_RUN;
}

void config_log(const struct config *c)
{
    log_info("start version=%s listen=%s port=%u state=%s tile=%u lease_ttl_ms=%lld "
             "checkpoint_ms=%lld image_interval_ms=%lld memory_mib=%llu",
             SMALTI_VERSION, c->listen, c->port, c->state_dir, c->tile_px,
             (long long)c->lease_ttl_ms, (long long)c->checkpoint_ms, (long long)c->image_ms,
             (unsigned long long)(c->memory_bytes >> 20));
}
