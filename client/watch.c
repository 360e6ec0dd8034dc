/* SPDX-License-Identifier: MIT */
#include "client/watch.h"

#include <signal.h>
#include <string.h>
#include <time.h>

#include "client/cmd.h"
#include "common/clock.h"

enum { NAP_MS = 250 };

static sigset_t stop_signals(void)
{
    sigset_t set;
    sigemptyset(&set);
    sigaddset(&set, SIGINT);
    sigaddset(&set, SIGTERM);
    sigaddset(&set, SIGHUP);
    return set;
}

void watch_block(void)
{
    const sigset_t set = stop_signals();
    sigprocmask(SIG_BLOCK, &set, NULL);
}

static bool signal_within(int64_t ms)
{
    const sigset_t set = stop_signals();
    const struct timespec t = {.tv_sec = ms / 1000, .tv_nsec = ms % 1000 * 1000000};
    return sigtimedwait(&set, NULL, &t) > 0;
}

/* One line, whatever white space the coordinator put in. */
static void print_json_line(const struct buf *json)
{
    for (size_t i = 0; i < json->size; i++)
        putchar(json->data[i] == '\n' || json->data[i] == '\r' ? ' ' : json->data[i]);
    putchar('\n');
    fflush(stdout);
}

/* One that cannot be had is no reason to stop: the line below is what matters. */
static void look_at_curve(struct watch *w)
{
    struct remote_curve curve;
    struct err err;
    if (!w->curve || w->progress->style != PROGRESS_MOVING)
        return;
    if (remote_convergence(w->remote, w->id, &curve, &err) && plot_draw(&curve, w->plot))
        w->progress->above = w->plot;
}

static bool look(struct watch *w, struct err *err)
{
    struct buf json = {0};
    bool changed = false;
    const bool good = remote_look(w->remote, w->id, w->etag, &changed, &w->job, &json, err);
    if (good && changed && w->json)
        print_json_line(&json);
    if (good && changed)
        look_at_curve(w);
    buf_release(&json);
    return good;
}

enum watch_event watch_step(struct watch *w, struct err *err)
{
    if (look(w, err)) {
        w->silent_since_ms = 0;
        progress_show(w->progress, &w->job, clock_ms());
        if (remote_is_over(w->job.state))
            return WATCH_OVER;
    } else {
        const int64_t now_ms = clock_ms();
        if (!w->silent_since_ms)
            w->silent_since_ms = now_ms;
        if (err->code != ERR_IO || now_ms - w->silent_since_ms >= WATCH_PATIENCE_MS)
            return WATCH_LOST;
    }
    return signal_within(w->nap_ms ? w->nap_ms : NAP_MS) ? WATCH_SIGNAL : WATCH_RUNNING;
}

enum watch_event watch_run(struct watch *w, struct err *err)
{
    enum watch_event event = WATCH_RUNNING;
    while (event == WATCH_RUNNING)
        event = watch_step(w, err);
    progress_end(w->progress);
    return event;
}

/* A cap came first: what was reached instead. */
static void say_target(const struct remote_job *job)
{
    if (job->target_error > 0 && *job->ended_by && strcmp(job->ended_by, "error") &&
        !(job->error <= job->target_error))
        fprintf(stderr,
                "smalti: error %.3g reached, %.3g was asked for: ended by its %s, with %u samples "
                "per pixel\n",
                job->error, job->target_error, job->ended_by, job->spp);
}

int watch_verdict(const struct watch *w)
{
    const struct remote_job *job = &w->job;
    if (job->invalid_samples)
        fprintf(stderr, "smalti: %llu samples were not finite and count as black\n",
                (unsigned long long)job->invalid_samples);
    if (job->state == REMOTE_DONE) {
        say_target(job);
        return CMD_OK;
    }
    fprintf(stderr, "smalti: job %s %s%s%s\n", job->id, remote_state_name(job->state),
            *job->failure ? ": " : "", job->failure);
    return CMD_FAILED;
}
