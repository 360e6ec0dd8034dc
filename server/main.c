/* smaltid - the coordinator. Flags, signals, start, the loop, stop.
 * SPDX-License-Identifier: MIT */
#include <pthread.h>
#include <signal.h>
#include <stdio.h>
#include <unistd.h>

#include "server/server.h"

static sigset_t stop_signals(void)
{
    sigset_t set;
    sigemptyset(&set);
    sigaddset(&set, SIGTERM);
    sigaddset(&set, SIGINT);
    return set;
}

/* The first signal is a message to the owner; a second one ends us at once. */
static void *wait_for_signals(void *inbox)
{
    const sigset_t set = stop_signals();
    int number;
    sigwait(&set, &number);
    queue_push(inbox, (struct message){MESSAGE_STOP, NULL});
    sigwait(&set, &number);
    _exit(128 + number);
}

static int run(const struct config *config)
{
    struct server server;
    struct err err;
    if (!server_open(&server, config, &err)) {
        log_error("%s", err.text);
        return 1;
    }
    pthread_t thread;
    if (pthread_create(&thread, NULL, wait_for_signals, server.inbox) != 0) {
        log_error("cannot start a thread");
        server_close(&server);
        return 1;
    }
    pthread_detach(thread);
    server_loop(&server);
    server_close(&server);
    return 0;
}

int main(int argc, char **argv)
{
    struct config config;
    struct err err;
    switch (config_parse(&config, argc, argv, &err)) {
    case CONFIG_DONE:
        return 0;
    case CONFIG_WRONG:
        fprintf(stderr, "smaltid: %s\n", err.text);
        return 2;
    case CONFIG_RUN:
        break;
    }
    const sigset_t set = stop_signals();
    pthread_sigmask(SIG_BLOCK, &set, NULL); /* inherited by every thread */
    signal(SIGPIPE, SIG_IGN);
    log_init("smaltid", config.log);
    config_log(&config);
    return run(&config);
}
