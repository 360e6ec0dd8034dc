/* SPDX-License-Identifier: MIT */
#include "tests/daemon.h"

#include <arpa/inet.h>
#include <errno.h>
#include <netinet/in.h>
#include <pthread.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <sys/wait.h>
#include <unistd.h>

#include "common/clock.h"
#include "common/err.h"
#include "server/server.h"

enum { MAX_FLAGS = 24, START_MS = 20000, PATIENCE_S = 10 };

/* ---- the child ---- */

static void *stop_on_signal(void *inbox)
{
    sigset_t set;
    int number;
    sigemptyset(&set);
    sigaddset(&set, SIGTERM);
    sigwait(&set, &number);
    queue_push(inbox, (struct message){MESSAGE_STOP, NULL});
    return NULL;
}

static int child(int argc, char **argv)
{
    struct config config;
    struct server server;
    struct err err;
    pthread_t thread;
    sigset_t set;
    sigemptyset(&set);
    sigaddset(&set, SIGTERM);
    pthread_sigmask(SIG_BLOCK, &set, NULL);
    signal(SIGPIPE, SIG_IGN);
    log_init("smaltid", LOG_ERROR);
    if (config_parse(&config, argc, argv, &err) != CONFIG_RUN ||
        !server_open(&server, &config, &err)) {
        fprintf(stderr, "# %s\n", err.text);
        return 3;
    }
    pthread_create(&thread, NULL, stop_on_signal, server.inbox);
    server_loop(&server);
    pthread_join(thread, NULL);
    server_close(&server);
    return 0;
}

/* ---- start and stop ---- */

static uint16_t announced_port(const char *path)
{
    char text[128] = "";
    FILE *f = fopen(path, "r");
    if (!f)
        return 0;
    const bool some = fgets(text, sizeof text, f) != NULL;
    fclose(f);
    const char *colon = some ? strrchr(text, ':') : NULL;
    return colon ? (uint16_t)atoi(colon + 1) : 0;
}

bool daemon_start(struct daemon *d, const char *const *flags)
{
    char announce[300], state[300], *argv[MAX_FLAGS + 8];
    int argc = 0;
    if (!*d->dir) {
        snprintf(d->dir, sizeof d->dir, "/tmp/smalti-test-daemon-XXXXXX");
        if (!mkdtemp(d->dir))
            return false;
    }
    snprintf(announce, sizeof announce, "%s/address", d->dir);
    snprintf(state, sizeof state, "%s/state", d->dir);
    unlink(announce);
    const char *const own[] = {"smaltid", "--state",    state,    "--port",
                               "0",       "--announce", announce, NULL};
    for (const char *const *f = own; *f; f++)
        argv[argc++] = strdup(*f);
    for (const char *const *f = flags; *f && argc < MAX_FLAGS; f++)
        argv[argc++] = strdup(*f);
    argv[argc] = NULL;
    fflush(stdout);
    d->pid = fork();
    if (d->pid == 0) {
        prctl(PR_SET_PDEATHSIG, SIGKILL); /* a test that crashes leaves nothing behind */
        exit(child(argc, argv));
    }
    while (argc)
        free(argv[--argc]);
    d->port = 0;
    const int64_t until = clock_ms() + START_MS;
    while (!(d->port = announced_port(announce)) && clock_ms() < until && daemon_lives(d))
        clock_sleep_ms(5);
    return d->port != 0;
}

bool daemon_lives(const struct daemon *d)
{
    siginfo_t info = {0};
    return waitid(P_PID, (id_t)d->pid, &info, WEXITED | WNOHANG | WNOWAIT) == 0 && info.si_pid == 0;
}

int daemon_stop(struct daemon *d)
{
    int status = 0;
    kill(d->pid, SIGTERM);
    waitpid(d->pid, &status, 0);
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

void daemon_kill(struct daemon *d)
{
    kill(d->pid, SIGKILL);
    waitpid(d->pid, NULL, 0);
}

void daemon_remove(struct daemon *d)
{
    char command[300];
    snprintf(command, sizeof command, "rm -rf %s", d->dir);
    if (system(command) != 0)
        fprintf(stderr, "# %s stays\n", d->dir);
}

/* ---- talking ---- */

int daemon_connect(const struct daemon *d)
{
    const int fd = socket(AF_INET, SOCK_STREAM, 0);
    struct sockaddr_in to = {.sin_family = AF_INET, .sin_port = htons(d->port)};
    to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    const struct timeval limit = {.tv_sec = PATIENCE_S};
    setsockopt(fd, SOL_SOCKET, SO_RCVTIMEO, &limit, sizeof limit);
    setsockopt(fd, SOL_SOCKET, SO_SNDTIMEO, &limit, sizeof limit);
    if (connect(fd, (struct sockaddr *)&to, sizeof to) == 0)
        return fd;
    close(fd);
    return -1;
}

static size_t body_length(const char *head)
{
    static const char name[] = "\r\nContent-Length:";
    for (const char *at = head; *at; at++)
        if (!strncasecmp(at, name, sizeof name - 1))
            return (size_t)atol(at + sizeof name - 1);
    return 0;
}

static bool is_whole(const struct answer *a)
{
    const char *text = (const char *)a->text.data, *end = text ? strstr(text, "\r\n\r\n") : NULL;
    return end && a->text.size - (size_t)(end + 4 - text) >= body_length(text);
}

struct answer daemon_read(int fd)
{
    struct answer a = {.status = -1};
    while (!is_whole(&a)) {
        char bytes[65537];
        const ssize_t n = recv(fd, bytes, sizeof bytes - 1, 0);
        if (n < 0 && errno == EINTR)
            continue;
        if (n < 0 && errno != ECONNRESET && errno != EPIPE)
            return a;
        if (n <= 0)
            break;
        buf_append(&a.text, bytes, (size_t)n);
        *(char *)buf_grow(&a.text, 1) = '\0';
        a.text.size--;
    }
    if (a.text.size < 12) {
        a.status = 0;
        return a;
    }
    a.status = atoi((char *)a.text.data + 9);
    const char *end = strstr((char *)a.text.data, "\r\n\r\n");
    a.body = end ? end + 4 : "";
    return a;
}

static void send_all(int fd, const char *at, size_t bytes)
{
    while (bytes) {
        const ssize_t n = send(fd, at, bytes, MSG_NOSIGNAL);
        if (n <= 0)
            return; /* refused before its end: the answer tells */
        at += n;
        bytes -= (size_t)n;
    }
}

struct answer daemon_send(const struct daemon *d, const void *bytes, size_t count)
{
    const int fd = daemon_connect(d);
    if (fd < 0)
        return (struct answer){.status = -1};
    send_all(fd, bytes, count);
    const struct answer a = daemon_read(fd);
    close(fd);
    return a;
}

struct answer daemon_call(const struct daemon *d, const char *method, const char *target,
                          const char *type, const void *body, size_t bytes)
{
    char head[1024];
    struct buf message = {0};
    const int n = snprintf(head, sizeof head,
                           "%s %s HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n"
                           "Content-Length: %zu\r\n%s%s%s\r\n",
                           method, target, bytes, type ? "Content-Type: " : "", type ? type : "",
                           type ? "\r\n" : "");
    buf_append(&message, head, (size_t)n);
    buf_append(&message, body, bytes);
    const struct answer a = daemon_send(d, message.data, message.size);
    buf_release(&message);
    return a;
}

const char *daemon_scene(uint32_t side, const char *target)
{
    static char text[2048];
    snprintf(
        text, sizeof text,
        "{\"smalti\": 1, \"film\": {\"width\": %u, \"height\": %u}, \"camera\": {\"type\": "
        "\"perspective\", \"fov_deg\": 40, \"look_at\": {\"from\": [0, 0, 5], \"to\": [0, 0, 0]}}, "
        "\"materials\": {\"grey\": {\"type\": \"diffuse\", \"albedo\": [0.5, 0.5, 0.5]}}, "
        "\"shapes\": [{\"type\": \"sphere\", \"center\": [0, 0, 0], \"radius\": 1, "
        "\"material\": \"grey\"}], \"lights\": [{\"type\": \"sky\", \"radiance\": [1, 1, 1]}], "
        "\"settings\": {\"integrator\": \"path\", \"target\": %s}}",
        side, side, target);
    return text;
}
