/* SPDX-License-Identifier: MIT */
#include "worker/args.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/random.h>
#include <unistd.h>

#include "common/flags.h"

static const char help[] =
    "Usage: smalti-worker --server URL [OPTION]...\n"
    "Leases passes from a coordinator, renders them and delivers the samples.\n"
    "\n"
    "  --server URL        the coordinator, as in http://127.0.0.1:7080\n"
    "  --threads N         threads that render, 1 to 1024 (as many as there are cores)\n"
    "  --cache DIR         where assets and prepared scenes are kept ($XDG_CACHE_HOME/smalti,\n"
    "                      ~/.cache/smalti, or /tmp/smalti-UID), on a local disk; the workers of\n"
    "                      a machine that share it share one copy of a scene, in memory, too\n"
    "  --cache-bytes N     its bound, as in 500M or 8G; the oldest go first; 0: no cache (4G)\n"
    "  --name NAME         unique to this process; A-Z a-z 0-9 . _ - (host-pid-random)\n"
    "  --log LEVEL         debug, info, warn or error (info)\n"
    "  --help, --version\n"
    "\n"
    "A worker whose coordinator is away, or of another version, keeps trying for ever.\n"
    "SIGTERM or SIGINT: what is nearly finished is delivered, the rest handed back.\n"
    "Exit status: 0 stopped or drained, 1 the system failed, 2 wrong usage.\n";

static const char name_characters[] =
    "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789"
    "._-";

static uint32_t cores(void)
{
    const long n = sysconf(_SC_NPROCESSORS_ONLN);
    return n < 1 ? 1 : n > 1024 ? 1024 : (uint32_t)n;
}

static uint64_t quarter_of_memory(void)
{
    const long pages = sysconf(_SC_PHYS_PAGES), page = sysconf(_SC_PAGESIZE);
    return pages > 0 && page > 0 ? (uint64_t)pages / 4 * (uint64_t)page : (uint64_t)1 << 30;
}

static void choose_name(struct args *a)
{
    char host[40] = "";
    uint32_t random = 0;
    gethostname(host, sizeof host - 1);
    host[strspn(host, name_characters)] = 0;
    if (getrandom(&random, sizeof random, GRND_NONBLOCK) != sizeof random)
        random = (uint32_t)getppid();
    snprintf(a->name_default, sizeof a->name_default, "%s-%ld-%08x", *host ? host : "worker",
             (long)getpid(), random);
    a->name = a->name_default;
}

static void choose_cache(struct args *a)
{
    const char *xdg = getenv("XDG_CACHE_HOME"), *home = getenv("HOME");
    const size_t room = sizeof a->cache_default;
    int n = (int)room;
    if (xdg && *xdg == '/')
        n = snprintf(a->cache_default, room, "%s/smalti", xdg);
    else if (home && *home == '/')
        n = snprintf(a->cache_default, room, "%s/.cache/smalti", home);
    if (n >= (int)room)
        snprintf(a->cache_default, room, "/tmp/smalti-%lu", (unsigned long)getuid());
    a->cache = a->cache_default;
}

static bool check(const struct args *a, const char *log, enum log_level *level, struct err *err)
{
    if (!a->server)
        return err_set(err, ERR_INPUT, "--server is missing");
    const size_t length = strlen(a->name);
    if (length > 64 || strspn(a->name, name_characters) != length)
        return err_set(err, ERR_INPUT,
                       "--name: expected 1 to 64 characters of A-Z a-z 0-9 . _ -, got '%s'",
                       a->name);
    static const char *const levels[] = {"debug", "info", "warn", "error"};
    for (size_t i = 0; i < countof(levels); i++)
        if (!strcmp(log, levels[i])) {
            *level = (enum log_level)i;
            return true;
        }
    return err_set(err, ERR_INPUT, "--log: expected debug, info, warn or error, got '%s'", log);
}

enum args_result args_parse(struct args *a, int argc, char *const *argv, struct err *err)
{
    *a = (struct args){
        .threads = cores(),
        .cache_bytes = (uint64_t)4 << 30,
        .stage_bytes = quarter_of_memory(),
    };
    choose_name(a);
    choose_cache(a);
    bool want_help = false, want_version = false;
    const char *log = "info";
    const struct flags_entry table[] = {
        {.name = "server", .kind = FLAGS_TEXT, .value = &a->server},
        {.name = "threads", .kind = FLAGS_COUNT, .value = &a->threads, .least = 1, .most = 1024},
        {.name = "cache", .kind = FLAGS_TEXT, .value = &a->cache},
        {.name = "cache-bytes", .kind = FLAGS_BYTES, .value = &a->cache_bytes, .most = 0x1p53},
        {.name = "name", .kind = FLAGS_TEXT, .value = &a->name},
        {.name = "log", .kind = FLAGS_TEXT, .value = &log},
        {.name = "help", .kind = FLAGS_SWITCH, .value = &want_help, .letter = 'h'},
        {.name = "version", .kind = FLAGS_SWITCH, .value = &want_version},
    };
    size_t operands = 0;
    if (!flags_parse(table, countof(table), argc - 1, argv + 1, NULL, 0, &operands, err))
        return ARGS_WRONG;
    if (want_help || want_version) {
        fputs(want_help ? help : "smalti-worker " SMALTI_VERSION "\n", stdout);
        return ARGS_DONE;
    }
    return check(a, log, &a->log, err) ? ARGS_RUN : ARGS_WRONG;
}

void args_log(const struct args *a)
{
    log_info("start version=%s name=%s server=%s threads=%u cache=%s cache_bytes=%llu "
             "stage_bytes=%llu",
             SMALTI_VERSION, a->name, a->server, a->threads, a->cache,
             (unsigned long long)a->cache_bytes, (unsigned long long)a->stage_bytes);
}
