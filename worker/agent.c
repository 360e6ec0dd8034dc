/* SPDX-License-Identifier: MIT */
#include "worker/agent.h"

#include <assert.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/eventfd.h>
#include <sys/signalfd.h>
#include <unistd.h>

#include "common/clock.h"
#include "worker/held.h"

enum {
    ASK_WAIT_MS = 20000,     /* long poll */
    REFUSED_WAIT_MS = 10000, /* after an answer that will not change soon */
    MOST_DELIVERIES = 4,     /* at once */
    GRACE_MS = 2000,         /* for passes that are being rendered when a signal comes */
    GIVE_UP_MS = 3000,       /* after that, for the last calls */
    IDLE_WAIT_MS = 30000,
    LOADS = 4096, /* more scenes than anybody can submit while one is prepared */
};

enum agent_phase {
    AGENT_WORKING,
    AGENT_DRAINING, /* told by the coordinator: what is being rendered is finished */
    AGENT_STOPPING, /* told by a signal: the same, but for GRACE_MS only */
};

struct agent {
    struct link *link;
    struct loader *loader;
    struct held held;
    int event_fd;             /* something is in one of the two */
    struct mailbox *rendered; /* struct pass */
    struct mailbox *loaded;   /* struct load */
    enum agent_phase phase;
    uint32_t target;                    /* passes not yet finished that we want to hold */
    uint32_t asked;                     /* leases that calls under way may bring */
    bool asking;                        /* a long poll is under way */
    bool told_draining;                 /* we said so, and take it back before we go */
    bool refused;                       /* the last ask was: said once in the log */
    int64_t ask_ms;                     /* not before */
    int64_t abandon_ms, give_up_ms;     /* STOPPING */
    uint64_t delivered, returned, lost; /* leases */
};

static void empty_mailboxes(struct agent *a)
{
    eventfd_t pushes;
    if (eventfd_read(a->event_fd, &pushes))
        return; /* nothing in there */
    for (struct pass *p; (p = mailbox_try_pop(a->rendered));)
        held_rendered(&a->held, p);
    for (struct load *load; (load = mailbox_try_pop(a->loaded));) {
        if (!load->done)
            log_error("scene_failed document=%.12s kind=%s reason=\"%s\"", load->document,
                      load->fault_kind, load->err.text);
        held_loaded(&a->held, load);
    }
}

/* ------------------------------------------------------------------ calls */

static uint32_t missing(const struct agent *a)
{
    const uint32_t have = held_count(&a->held, PASS_WAITING, PASS_POOLED) + a->asked;
    return a->phase == AGENT_WORKING && have < a->target ? a->target - have : 0;
}

/* By a long poll. Once finished passes pile up, delivering them comes first. */
static uint32_t to_ask(const struct agent *a)
{
    if (a->asking || held_count(&a->held, PASS_DONE, PASS_DONE) >= a->target)
        return 0;
    return min_u32(missing(a), LINK_MAX_LEASES);
}

static void start_call(struct agent *a, struct pass *p, int64_t now_ms)
{
    switch (p->state) {
    case PASS_WAITING:
    case PASS_POOLED:
        if (now_ms >= p->renew_ms && !p->renewing && !p->forget) {
            p->renewing = true;
            link_renew(a->link, p->lease.id);
        }
        return;
    case PASS_DONE:
        if (held_count(&a->held, PASS_DELIVERING, PASS_DELIVERING) < MOST_DELIVERIES) {
            const uint32_t want = min_u32(missing(a), LINK_MAX_LEASES);
            p->state = PASS_DELIVERING;
            a->asked += want;
            if (p->lease.plan)
                link_deliver_plan(a->link, p->lease.id, &p->payload, want);
            else
                link_deliver(a->link, p->lease.id, &p->payload, want);
        }
        return;
    case PASS_RETURN:
        p->state = PASS_RETURNING;
        link_return(a->link, p->lease.id, p->fault_kind, p->fault);
        return;
    case PASS_DELIVERING:
    case PASS_RETURNING:
        return;
    }
}

static void start_calls(struct agent *a, int64_t now_ms)
{
    if (!link_is_open(a->link, now_ms))
        return;
    for (struct pass *p = a->held.first; p; p = p->next)
        start_call(a, p, now_ms);
    const uint32_t want = to_ask(a); /* what deliveries under way do not bring */
    if (want && now_ms >= a->ask_ms) {
        a->asking = true;
        a->asked += want;
        link_ask(a->link, want, ASK_WAIT_MS);
    }
}

/* ----------------------------------------------------------------- events */

static void drain(struct agent *a, enum agent_phase phase, int64_t now_ms)
{
    if (a->phase >= phase)
        return;
    log_info("%s held=%u", phase == AGENT_STOPPING ? "stop" : "drain",
             held_count(&a->held, PASS_WAITING, PASS_RETURNING));
    a->phase = phase;
    held_abandon_unbegun(&a->held);
    if (phase != AGENT_STOPPING)
        return;
    a->abandon_ms = now_ms + GRACE_MS;
    a->give_up_ms = a->abandon_ms + GIVE_UP_MS;
    if (a->asking) { /* else leases may be granted to nobody, and be missing until they lapse */
        a->told_draining = true;
        link_state(a->link, "draining");
    }
}

static void take_leases(struct agent *a, const struct link_event *e, int64_t now_ms)
{
    for (uint32_t i = 0; i < e->lease_count; i++)
        if (a->phase == AGENT_WORKING)
            held_accept(&a->held, &e->leases[i], now_ms);
        else
            held_decline(&a->held, &e->leases[i]);
    if (e->drain)
        drain(a, AGENT_DRAINING, now_ms);
}

static void on_ask(struct agent *a, const struct link_event *e, int64_t now_ms)
{
    a->asking = false;
    a->asked -= e->wanted;
    if (e->status / 100 == 4) {
        if (!a->refused)
            log_error("refused version=%s reason=\"%s\"", SMALTI_VERSION, e->text);
        a->refused = true;
        a->ask_ms = now_ms + REFUSED_WAIT_MS;
        return;
    }
    if (e->status)
        a->refused = false;
    take_leases(a, e, now_ms);
}

static void on_renew(struct agent *a, const struct link_event *e, int64_t now_ms)
{
    struct pass *p = held_find(&a->held, e->id);
    if (!p)
        return;
    p->renewing = false;
    if (e->status / 100 == 2) {
        p->renew_ms = now_ms + e->ttl_ms / 3;
    } else if (e->status / 100 == 4) {
        a->lost++;
        log_warn("lease_lost lease=%s job=%s tile=%u pass=%u reason=\"%s\"", p->lease.id,
                 p->lease.job, p->lease.tile, p->lease.pass_index, e->text);
        if (p->state == PASS_WAITING || p->state == PASS_POOLED)
            held_forget(&a->held, p);
    }
}

/* The job takes no more: whatever else is held of it goes back. */
static void abandon_job(struct agent *a, const char job[LINK_ID])
{
    for (struct pass *p = a->held.first; p; p = p->next)
        if (!strcmp(p->lease.job, job))
            held_abandon(p);
}

static void on_deliver(struct agent *a, const struct link_event *e, int64_t now_ms)
{
    struct pass *p = held_find(&a->held, e->id);
    assert(p && p->state == PASS_DELIVERING);
    a->asked -= e->wanted;
    if (e->status / 100 == 2) {
        a->delivered++;
        log_debug("delivered lease=%s job=%s tile=%u pass=%u cpu_us=%llu invalid=%llu result=%s",
                  p->lease.id, p->lease.job, p->lease.tile, p->lease.pass_index,
                  (unsigned long long)p->cpu_us, (unsigned long long)p->invalid_count, e->result);
        held_remove(&a->held, p);
        take_leases(a, e, now_ms);
    } else if (e->status == 409) {
        log_info("job_ended job=%s reason=\"%s\"", p->lease.job, e->text);
        abandon_job(a, p->lease.job);
        held_remove(&a->held, p);
    } else if (e->status == 404) {
        log_warn("delivery_late lease=%s job=%s reason=\"%s\"", p->lease.id, p->lease.job, e->text);
        a->lost++;
        held_remove(&a->held, p);
    } else if (e->status / 100 == 4) {
        log_error("delivery_refused lease=%s job=%s tile=%u pass=%u reason=\"%s\"", p->lease.id,
                  p->lease.job, p->lease.tile, p->lease.pass_index, e->text);
        held_return(p, "worker", e->text);
    } else {
        p->state = PASS_DONE; /* again, when the link is open */
    }
}

static void on_return(struct agent *a, const struct link_event *e)
{
    struct pass *p = held_find(&a->held, e->id);
    assert(p && p->state == PASS_RETURNING);
    if (e->status / 100 == 2 || e->status / 100 == 4) {
        a->returned++;
        held_remove(&a->held, p);
    } else {
        p->state = PASS_RETURN;
    }
}

static void handle(struct agent *a, const struct link_event *e, int64_t now_ms)
{
    switch (e->kind) {
    case LINK_ASK:
        on_ask(a, e, now_ms);
        return;
    case LINK_RENEW:
        on_renew(a, e, now_ms);
        return;
    case LINK_DELIVER:
        on_deliver(a, e, now_ms);
        return;
    case LINK_RETURN:
        on_return(a, e);
        return;
    case LINK_STATE:
        return;
    }
}

/* -------------------------------------------------------------- main loop */

static void read_signals(struct agent *a, int signal_fd, int64_t now_ms)
{
    struct signalfd_siginfo info;
    while (read(signal_fd, &info, sizeof info) == (ssize_t)sizeof info) {
        if (a->phase == AGENT_STOPPING) {
            log_warn("second_signal");
            _exit(0);
        }
        drain(a, AGENT_STOPPING, now_ms);
    }
}

static void stop_slow_passes(struct agent *a, int64_t now_ms)
{
    if (a->phase != AGENT_STOPPING || now_ms < a->abandon_ms)
        return;
    for (struct pass *p = a->held.first; p; p = p->next)
        held_abandon(p);
}

static bool is_over(struct agent *a, int64_t now_ms)
{
    if (a->phase == AGENT_WORKING)
        return false;
    if (a->phase == AGENT_STOPPING && now_ms >= a->give_up_ms)
        return true;
    if (a->held.first || a->asking)
        return false;
    if (a->told_draining) { /* or the next process of this name would be sent home */
        a->told_draining = false;
        link_state(a->link, "active");
    }
    return !link_running(a->link);
}

/* Until when nothing will happen by itself. */
static int64_t wait_ms(const struct agent *a, int64_t now_ms)
{
    const int64_t opens_ms = link_is_open(a->link, now_ms) ? now_ms : link_opens_ms(a->link);
    int64_t until = now_ms + IDLE_WAIT_MS;
    for (const struct pass *p = a->held.first; p; p = p->next) {
        if ((p->state == PASS_WAITING || p->state == PASS_POOLED) && !p->renewing && !p->forget)
            until = min_i64(until, max_i64(p->renew_ms, opens_ms));
        if ((p->state == PASS_DONE || p->state == PASS_RETURN) && opens_ms > now_ms)
            until = min_i64(until, opens_ms);
    }
    if (to_ask(a))
        until = min_i64(until, max_i64(a->ask_ms, opens_ms));
    if (a->phase == AGENT_STOPPING)
        until = min_i64(until, now_ms < a->abandon_ms ? a->abandon_ms : a->give_up_ms);
    return max_i64(until - now_ms, 0);
}

static void loop(struct agent *a, int signal_fd)
{
    const int fds[] = {signal_fd, a->event_fd};
    int64_t now_ms = clock_ms();
    while (!is_over(a, now_ms)) {
        struct link_event e;
        empty_mailboxes(a);
        stop_slow_passes(a, now_ms);
        start_calls(a, now_ms);
        const bool event = link_poll(a->link, wait_ms(a, now_ms), fds, countof(fds), &e);
        now_ms = clock_ms();
        if (event)
            handle(a, &e, now_ms);
        read_signals(a, signal_fd, now_ms);
    }
}

/* Everything that is still held at the end (after GIVE_UP_MS) lapses by itself. */
static int finish(struct agent *a)
{
    log_info("end delivered=%llu returned=%llu lost=%llu cpu_s=%.2f idle_s=%.2f",
             (unsigned long long)a->delivered, (unsigned long long)a->returned,
             (unsigned long long)a->lost, (double)a->held.cpu_us * 1e-6,
             (double)pool_idle_ms(a->held.pool) * 1e-3);
    if (!loader_stop(a->loader, 200))
        _exit(0); /* in the middle of preparing a scene that nobody waits for */
    for (struct load *load; (load = mailbox_try_pop(a->loaded));)
        stages_loaded(&a->held.stages, load);
    for (struct pass *p = a->held.first; p; p = p->next)
        atomic_store(&p->abandon, true);
    pool_free(a->held.pool);
    for (struct pass *p; (p = mailbox_try_pop(a->rendered));)
        held_rendered(&a->held, p);
    link_free(a->link);
    while (a->held.first)
        held_remove(&a->held, a->held.first);
    stages_release(&a->held.stages);
    mailbox_free(a->rendered);
    mailbox_free(a->loaded);
    close(a->event_fd);
    return 0;
}

int agent_run(const struct args *args, const struct cache *cache, int signal_fd)
{
    struct agent a = {.target = 2 * args->threads};
    struct err err;
    a.link = link_new(args->server, args->name, args->threads, &err);
    if (!a.link) {
        log_error("bad_server reason=\"%s\"", err.text);
        return 2;
    }
    a.event_fd = eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC);
    a.rendered = mailbox_new(a.target, a.event_fd);
    a.loaded = mailbox_new(LOADS, a.event_fd);
    a.loader = loader_new(args, cache, LOADS, a.loaded, &err);
    if (a.event_fd < 0 || !a.loader)
        abort(); /* the address has just been accepted: the machine is full */
    a.held.stages = (struct stages){.loader = a.loader, .most_bytes = args->stage_bytes};
    a.held.pool = pool_new(args->threads, a.target, a.rendered);
    loop(&a, signal_fd);
    return finish(&a);
}
