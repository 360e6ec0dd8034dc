/* smalti-worker: flags, signals, start and stop. The work is agent.c's.
 * SPDX-License-Identifier: MIT */
#include <signal.h>
#include <stdio.h>
#include <sys/signalfd.h>
#include <unistd.h>

#include "worker/agent.h"

static int open_signals(void)
{
    sigset_t set;
    sigemptyset(&set);
    sigaddset(&set, SIGTERM);
    sigaddset(&set, SIGINT);
    signal(SIGPIPE, SIG_IGN);
    signal(SIGXFSZ, SIG_IGN); /* a limit on file sizes is a full disk: write and the like say so */
    return pthread_sigmask(SIG_BLOCK, &set, NULL) ? -1
                                                  : signalfd(-1, &set, SFD_NONBLOCK | SFD_CLOEXEC);
}

int main(int argc, char **argv)
{
    struct args args;
    struct err err;
    switch (args_parse(&args, argc, argv, &err)) {
    case ARGS_DONE:
        return 0;
    case ARGS_WRONG:
        fprintf(stderr, "smalti-worker: %s\nTry 'smalti-worker --help'.\n", err.text);
        return 2;
    case ARGS_RUN:
        break;
    }
    log_init("smalti-worker", args.log);
    if (!__builtin_cpu_supports("avx2") || !__builtin_cpu_supports("fma")) {
        log_error("cpu_unsupported reason=\"this build needs a processor with AVX2 and FMA "
                  "(x86-64-v3)\"");
        return 1;
    }
    args_log(&args);
    const int signal_fd = open_signals();
    if (signal_fd < 0) {
        log_error("signals_failed");
        return 1;
    }
    struct cache cache;
    cache_init(&cache, args.cache, args.cache_bytes);
    const int status = agent_run(&args, &cache, signal_fd);
    close(signal_fd);
    return status;
}
