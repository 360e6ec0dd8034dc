/* SPDX-License-Identifier: MIT */
#include "client/progress.h"

#include <stdarg.h>
#include <string.h>
#include <unistd.h>

enum { PLAIN_EVERY_MS = 5000, BAR = 24 };

struct text {
    char *out;
    size_t room, used;
};

static void add(struct text *, const char *fmt, ...) PRINTF(2, 3);

static void add(struct text *t, const char *fmt, ...)
{
    va_list ap;
    va_start(ap, fmt);
    const int n = vsnprintf(t->out + t->used, t->room - t->used, fmt, ap);
    va_end(ap);
    if (n > 0)
        t->used = min_size(t->used + (size_t)n, t->room - 1);
}

static void add_rate(struct text *t, double rate)
{
    if (rate >= 1e6)
        add(t, "  %.2f Msamples/s", rate * 1e-6);
    else
        add(t, "  %.1f ksamples/s", rate * 1e-3);
}

static void add_time(struct text *t, double seconds)
{
    const long s = seconds < 1e8 ? (long)(seconds + .5) : 100000000;
    if (s >= 3600)
        add(t, "  %ld:%02ld:%02ld left", s / 3600, s / 60 % 60, s % 60);
    else
        add(t, "  %ld:%02ld left", s / 60, s % 60);
}

static int percent(const struct remote_job *job)
{
    const double p = job->progress;
    return p >= 1 ? 100 : p > 0 ? (int)(p * 100) : 0; /* 100 % only at the end; 0 for a NaN */
}

void progress_samples(const struct remote_job *job, char *out, size_t bytes)
{
    if (job->spp_least < job->spp_most && remote_is_over(job->state))
        snprintf(out, bytes, "%u to %u spp", job->spp_least, job->spp_most);
    else
        snprintf(out, bytes, "%u spp", job->spp);
}

void progress_text(const struct remote_job *job, char *out, size_t bytes)
{
    struct text t = {out, bytes, 0};
    char samples[40];
    progress_samples(job, samples, sizeof samples);
    add(&t, "%3d %%  %s", percent(job), samples);
    if (job->error >= 0)
        add(&t, "  error %.3g", job->error);
    if (job->error >= 0 && job->error_high > 0)
        add(&t, " (%.3g to %.3g)", job->error_low, job->error_high);
    if (job->error >= 0 && job->untrusted >= .0005)
        add(&t, "  %.1f %% untrusted", 100 * job->untrusted);
    if (job->rate > 0)
        add_rate(&t, job->rate);
    if (job->workers)
        add(&t, "  %u worker%s", job->workers, job->workers == 1 ? "" : "s");
    if (job->eta_seconds >= 0 && !remote_is_over(job->state))
        add_time(&t, job->eta_seconds);
}

struct progress progress_make(FILE *out, bool quiet)
{
    return (struct progress){
        .out = out,
        .style = quiet                 ? PROGRESS_QUIET
                 : isatty(fileno(out)) ? PROGRESS_MOVING
                                       : PROGRESS_PLAIN,
    };
}

/* In the place of what was there before. */
static void show_above(struct progress *p)
{
    if (p->lines)
        fprintf(p->out, "\r\033[%dA", p->lines);
    p->lines = 0;
    for (const char *at = p->above; at && *at; p->lines++) {
        const int n = (int)strcspn(at, "\n");
        fprintf(p->out, "\r%.*s\033[K\n", n, at);
        at += n + (at[n] == '\n');
    }
}

static void show_moving(struct progress *p, const struct remote_job *job)
{
    char bar[BAR + 1], text[160];
    const size_t full = (size_t)percent(job) * BAR / 100;
    memset(bar, ' ', BAR);
    memset(bar, '#', full);
    bar[BAR] = 0;
    progress_text(job, text, sizeof text);
    show_above(p);
    fprintf(p->out, "\r%-9s [%s] %s\033[K", remote_state_name(job->state), bar, text);
    fflush(p->out);
    p->on_line = true;
}

void progress_show(struct progress *p, const struct remote_job *job, int64_t now_ms)
{
    const bool fresh = !p->started || job->state != p->last_state;
    char text[160];
    switch (p->style) {
    case PROGRESS_QUIET:
        break;
    case PROGRESS_MOVING:
        show_moving(p, job);
        break;
    case PROGRESS_PLAIN:
        if (!fresh && now_ms - p->last_ms < PLAIN_EVERY_MS)
            return;
        progress_text(job, text, sizeof text);
        fprintf(p->out, "%s %s\n", remote_state_name(job->state), text);
        fflush(p->out);
        p->last_ms = now_ms;
        break;
    }
    p->started = true;
    p->last_state = job->state;
}

void progress_end(struct progress *p)
{
    if (p->on_line)
        fputc('\n', p->out);
    p->on_line = false;
}
