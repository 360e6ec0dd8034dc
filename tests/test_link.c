/* link.c: what a worker makes of answers, good, hostile and absent, against a server of canned
 * answers.
 * SPDX-License-Identifier: MIT */
#include "worker/link.h"

#include <arpa/inet.h>
#include <pthread.h>
#include <stdio.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

#include "common/clock.h"
#include "tests/tap.h"

/* Answers every request of every connection with the same bytes. */
struct canned {
    int listener;
    char url[64];
    pthread_mutex_t mutex; /* over the rest */
    char answer[4096];
    char request[4096]; /* the last one's head */
};

static void serve_one(struct canned *c, int fd)
{
    char head[4096] = "", answer[4096], rest[4096];
    for (size_t used = 0; used < sizeof head - 1 && !strstr(head, "\r\n\r\n");) {
        const ssize_t n = read(fd, head + used, sizeof head - 1 - used);
        if (n <= 0)
            break;
        used += (size_t)n;
        head[used] = 0;
    }
    pthread_mutex_lock(&c->mutex);
    strcpy(c->request, head);
    strcpy(answer, c->answer);
    pthread_mutex_unlock(&c->mutex);
    if (write(fd, answer, strlen(answer)) != (ssize_t)strlen(answer))
        diag("short write");
    shutdown(fd, SHUT_WR);
    while (read(fd, rest, sizeof rest) > 0)
        ; /* a body: closing with bytes unread would reset the answer away */
    close(fd);
}

static void *serve(void *user)
{
    struct canned *c = user;
    for (int fd; (fd = accept(c->listener, NULL, NULL)) >= 0;)
        serve_one(c, fd);
    return NULL;
}

static void open_canned(struct canned *c, pthread_t *thread)
{
    struct sockaddr_in address = {.sin_family = AF_INET, .sin_addr.s_addr = htonl(INADDR_LOOPBACK)};
    socklen_t length = sizeof address;
    pthread_mutex_init(&c->mutex, NULL);
    c->listener = socket(AF_INET, SOCK_STREAM, 0);
    if (bind(c->listener, (struct sockaddr *)&address, length) || listen(c->listener, 8) ||
        getsockname(c->listener, (struct sockaddr *)&address, &length))
        diag("no listener");
    snprintf(c->url, sizeof c->url, "http://127.0.0.1:%u/", ntohs(address.sin_port));
    pthread_create(thread, NULL, serve, c);
}

static void set_answer(struct canned *c, const char *status, const char *body)
{
    pthread_mutex_lock(&c->mutex);
    snprintf(c->answer, sizeof c->answer,
             "HTTP/1.1 %s\r\nContent-Length: %zu\r\nConnection: close\r\n\r\n%s", status,
             strlen(body), body);
    pthread_mutex_unlock(&c->mutex);
}

static bool was_sent(struct canned *c, const char *text)
{
    pthread_mutex_lock(&c->mutex);
    const bool found = strstr(c->request, text) != NULL;
    pthread_mutex_unlock(&c->mutex);
    return found;
}

static struct link_event wait_for(struct link *l)
{
    static struct link_event e;
    const int64_t until = clock_ms() + 10000;
    while (!link_poll(l, 1000, NULL, 0, &e))
        if (clock_ms() > until)
            return (struct link_event){.status = -1};
    return e;
}

#define DOCUMENT "c93283b149a433bddc5c2f5d005366f4be19c07e741265595f6502875f02b2c9"
#define LEASE(rect, samples)                                                                       \
    "{\"lease\": \"00a1b2c300000007\", \"job\": \"5f0c9b1e8a7d6c34\", \"document\": \"" DOCUMENT   \
    "\", \"tile\": 12, \"rect\": " rect ", \"pass\": 3, \"samples\": " samples                     \
    ", \"ttl_ms\": 30000}"
#define BLOCKS_LEASE(blocks)                                                                       \
    "{\"lease\": \"00a1b2c300000007\", \"job\": \"5f0c9b1e8a7d6c34\", \"document\": \"" DOCUMENT   \
    "\", \"tile\": 12, \"rect\": [64, 0, 104, 16], \"pass\": 3, \"samples\": [0, 8], "             \
    "\"blocks\": " blocks ", \"ttl_ms\": 30000}"
#define METHOD_LEASE(method)                                                                       \
    "{\"lease\": \"00a1b2c300000007\", \"job\": \"5f0c9b1e8a7d6c34\", \"document\": \"" DOCUMENT   \
    "\", \"tile\": 12, \"rect\": [0, 0, 8, 8], \"pass\": 3, \"samples\": [0, 8], "                 \
    "\"method\": " method ", \"ttl_ms\": 30000}"
#define PLAN_LEASE                                                                                 \
    "{\"lease\": \"00a1b2c300000008\", \"job\": \"5f0c9b1e8a7d6c34\", \"document\": \"" DOCUMENT   \
    "\", \"plan\": true, \"ttl_ms\": 30000}"
#define GOOD_LEASE LEASE("[256, 64, 320, 128]", "[32, 64]")

static void good_answers(struct canned *c, struct link *l)
{
    set_answer(c, "200 OK", "{\"leases\": [" GOOD_LEASE "]}");
    link_ask(l, 2, 1000);
    ok(link_running(l) == 1, "a call runs until its event has come");
    struct link_event e = wait_for(l);
    ok(e.kind == LINK_ASK && e.status == 200 && e.wanted == 2 && e.lease_count == 1 && !e.drain &&
           link_running(l) == 0,
       "an ask brings leases");
    const struct link_lease *x = &e.leases[0];
    ok(!strcmp(x->id, "00a1b2c300000007") && x->job_number == 0x5f0c9b1e8a7d6c34 && x->tile == 12 &&
           x->rect.x_begin == 256 && x->rect.y_end == 128 && x->pass.s_begin == 32 &&
           x->pass.s_end == 64 && x->ttl_ms == 30000 && !strcmp(x->document, DOCUMENT),
       "and a lease has all its fields");
    ok(was_sent(c, "POST /v1/leases HTTP/1.1\r\n") &&
           was_sent(c, "Content-Type: application/json\r\n") && !was_sent(c, "Expect"),
       "it was asked for by POST, without waiting for 100 Continue");

    set_answer(c, "200 OK", "{\"leases\": [], \"drain\": true}");
    link_ask(l, 1, 0);
    e = wait_for(l);
    ok(e.drain && !e.lease_count, "a worker can be told to go");
    set_answer(c, "200 OK", "{\"ttl_ms\": 12345}");
    link_renew(l, "00a1b2c300000007");
    e = wait_for(l);
    ok(e.kind == LINK_RENEW && e.ttl_ms == 12345 && !strcmp(e.id, "00a1b2c300000007"),
       "a renewal brings the new deadline");
    unsigned char bytes[] = "SMLT";
    const struct buf payload = {.data = bytes, .size = 4};
    set_answer(c, "200 OK", "{\"result\": \"merged\", \"leases\": [" GOOD_LEASE "]}");
    link_deliver(l, "00a1b2c300000007", &payload, 1);
    e = wait_for(l);
    ok(e.kind == LINK_DELIVER && !strcmp(e.result, "merged") && e.lease_count == 1 &&
           was_sent(c, "PUT /v1/leases/00a1b2c300000007?worker=w-1&want=1 HTTP/1.1\r\n"),
       "a delivery says what became of it and brings the next lease");
    set_answer(c, "204 No Content", "");
    link_return(l, "00a1b2c300000007", "worker", "cut \xc3"); /* half a character */
    e = wait_for(l);
    ok(e.kind == LINK_RETURN && e.status == 204,
       "a lease is handed back, whatever the reason's bytes");
}

static void plans(struct canned *c, struct link *l)
{
    set_answer(c, "200 OK",
               "{\"leases\": [" PLAN_LEASE ", " GOOD_LEASE
               ", " METHOD_LEASE("{\"integrator\": \"path\", \"strategy\": \"bsdf\"}") "]}");
    link_ask(l, 3, 0);
    struct link_event e = wait_for(l);
    ok(e.lease_count == 3 && e.leases[0].plan && !strcmp(e.leases[0].document, DOCUMENT) &&
           !e.leases[1].plan && e.leases[1].method == PLAN_REAL,
       "a lease may be for a plan, and a pass without a method is of the document's");
    ok(e.leases[2].method == PLAN_PATH_BSDF, "a pass of a planned job says its method");
    unsigned char text[] = "{}";
    const struct buf plan = {.data = text, .size = 2};
    set_answer(c, "200 OK", "{\"result\": \"planned\", \"leases\": []}");
    link_deliver_plan(l, "00a1b2c300000008", &plan, 2);
    e = wait_for(l);
    ok(e.kind == LINK_DELIVER && !strcmp(e.result, "planned") &&
           was_sent(c, "PUT /v1/leases/00a1b2c300000008/plan?worker=w-1&want=2 HTTP/1.1\r\n") &&
           was_sent(c, "Content-Type: application/json\r\n"),
       "a plan is delivered as JSON");
}

static void some_blocks(struct canned *c, struct link *l)
{
    set_answer(c, "200 OK",
               "{\"leases\": [" BLOCKS_LEASE("\"840\"") ", " GOOD_LEASE
                                                        ", " BLOCKS_LEASE("\"ffc\"") "]}");
    link_ask(l, 3, 0);
    struct link_event e = wait_for(l);
    struct block_set some = {0};
    block_set_add(&some, 0);
    block_set_add(&some, 5);
    const struct block_set ten = block_set_all(10), all = block_set_all(64);
    ok(e.lease_count == 3 && block_set_equal(&e.leases[0].blocks, &some),
       "a lease may be for some blocks of its tile");
    ok(block_set_equal(&e.leases[1].blocks, &all) && block_set_equal(&e.leases[2].blocks, &ten),
       "without a word it is for all of them");
    set_answer(c, "200 OK", "{\"leases\": [" BLOCKS_LEASE("\"ffe\"") "]}");
    link_ask(l, 1, 0);
    e = wait_for(l);
    ok(strstr(e.text, "leases[0]: blocks: expected 3 hex digits that name some of 10, got 'ffe'") !=
           NULL,
       "what is wrong with one is said: %s", e.text);
}

static void hostile_answers(struct canned *c, struct link *l)
{
    static const struct {
        const char *body, *what;
    } cases[] = {
        {"", "an empty answer"},
        {"<html>", "another server's answer"},
        {"[]", "an array"},
        {"{}", "an answer without leases"},
        {"{\"leases\": [" GOOD_LEASE ", " GOOD_LEASE "]}", "more leases than were asked for"},
        {"{\"leases\": [" LEASE("[0, 0, 257, 8]", "[0, 8]") "]}", "a tile beyond the limit"},
        {"{\"leases\": [" LEASE("[8, 0, 8, 8]", "[0, 8]") "]}", "an empty tile"},
        {"{\"leases\": [" LEASE("[-8, 0, 8, 8]", "[0, 8]") "]}", "a negative pixel"},
        {"{\"leases\": [" LEASE("[0, 0, 8]", "[0, 8]") "]}", "a rectangle of three"},
        {"{\"leases\": [" LEASE("[0, 0, 8, 8]", "[8, 8]") "]}", "a pass without samples"},
        {"{\"leases\": [" LEASE("[0, 0, 8, 8]", "[0, 16777217]") "]}", "samples beyond the limit"},
        {"{\"leases\": [" LEASE("[0, 0, 8, 8]", "[0, 8.5]") "]}", "half a sample"},
        {"{\"leases\": [" METHOD_LEASE("{\"integrator\": \"auto\", \"strategy\": \"mis\"}") "]}",
         "a method that is none"},
        {"{\"leases\": [" METHOD_LEASE("\"path\"") "]}", "a method that is a word"},
        {"{\"leases\": [{\"lease\": \"../../../etc/pass\"}]}", "an id that is none"},
        {"{\"leases\": [" BLOCKS_LEASE("\"000\"") "]}", "no block at all"},
        {"{\"leases\": [" BLOCKS_LEASE("\"ff\"") "]}", "too few digits of blocks"},
        {"{\"leases\": [" BLOCKS_LEASE("\"ff00\"") "]}", "too many"},
        {"{\"leases\": [" BLOCKS_LEASE("\"ff1\"") "]}", "a block beyond the tile"},
        {"{\"leases\": [" BLOCKS_LEASE("\"FFC\"") "]}", "digits of another kind"},
        {"{\"leases\": [" BLOCKS_LEASE("[0, 1]") "]}", "blocks that are no text"},
    };
    for (size_t i = 0; i < countof(cases); i++) {
        set_answer(c, "200 OK", cases[i].body);
        link_ask(l, 1, 0);
        const struct link_event e = wait_for(l);
        ok(e.status == 0 && !e.lease_count, "not taken: %s", cases[i].what);
    }
    pthread_mutex_lock(&c->mutex);
    strcpy(c->answer, "HTTP/1.1 200 OK\r\nContent-Length: 100\r\n\r\n{\"leases\": []}");
    pthread_mutex_unlock(&c->mutex);
    link_ask(l, 1, 0);
    ok(wait_for(l).status == 0, "not taken: an answer that breaks off");
}

static void refusals(struct canned *c, struct link *l)
{
    set_answer(c, "409 Conflict",
               "{\"title\": \"Conflict\", \"status\": 409, \"detail\": \"version: this "
               "coordinator is 0.2.0\"}");
    link_ask(l, 1, 0);
    const struct link_event e = wait_for(l);
    ok(e.status == 409 && !strcmp(e.text, "409: version: this coordinator is 0.2.0"),
       "a refusal says why");
    ok(link_is_open(l, clock_ms()), "and is an answer: the link is open");
}

static void back_off(struct canned *c, struct link *l)
{
    bool in_range = true;
    set_answer(c, "503 Service Unavailable", "{}");
    for (int i = 0; i < 5; i++) {
        const int64_t whole = 100 << i;
        while (!link_is_open(l, clock_ms()))
            clock_sleep_ms(5);
        const int64_t before = clock_ms();
        link_renew(l, "00a1b2c300000007");
        if (i == 4)
            link_renew(l, "00a1b2c300000008");
        wait_for(l);
        const int64_t opens = link_opens_ms(l);
        in_range &= opens >= before + whole / 2 && opens <= clock_ms() + whole;
        if (i == 4) {
            wait_for(l);
            ok(link_opens_ms(l) == opens, "calls that fail together count once");
        }
    }
    ok(in_range, "each failure closes the link for twice as long, less by chance");
    set_answer(c, "200 OK", "{\"ttl_ms\": 1000}");
    link_renew(l, "00a1b2c300000007");
    wait_for(l);
    ok(link_is_open(l, clock_ms()), "an answer opens it at once");
}

int main(void)
{
    static struct canned canned;
    pthread_t thread;
    struct err err;
    open_canned(&canned, &thread);
    struct link *l = link_new(canned.url, "w-1", 2, &err);
    good_answers(&canned, l);
    plans(&canned, l);
    some_blocks(&canned, l);
    hostile_answers(&canned, l);
    refusals(&canned, l);
    back_off(&canned, l);
    link_ask(l, 1, 20000);
    link_free(l); /* with a call under way */
    static const char *const bad[] = {
        "",           "127.0.0.1:7080", "ftp://127.0.0.1/", "http://",
        "http://h/x", "http://h:99999", "http://u:p@h/",    "http://h/?q"};
    for (size_t i = 0; i < countof(bad); i++)
        ok(!link_new(bad[i], "w", 1, &err) && err.code == ERR_INPUT, "no address: '%s'", bad[i]);
    shutdown(canned.listener, SHUT_RDWR);
    pthread_join(thread, NULL);
    close(canned.listener);
    return tap_done();
}
