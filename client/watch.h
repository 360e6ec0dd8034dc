/* watch.h - follow a job: look, show, sleep; a signal ends the sleep.
 *
 * watch_block keeps SIGINT, SIGTERM and SIGHUP from ending the program: they are seen by watch_step
 * only. A coordinator that does not answer is asked again for WATCH_PATIENCE_MS.
 * SPDX-License-Identifier: MIT */
#ifndef CLIENT_WATCH_H
#define CLIENT_WATCH_H

#include "client/plot.h"
#include "client/progress.h"
#include "client/remote.h"

enum { WATCH_PATIENCE_MS = 60000 };

enum watch_event {
    WATCH_RUNNING,
    WATCH_OVER,   /* done, failed or cancelled */
    WATCH_SIGNAL, /* somebody wants us to stop */
    WATCH_LOST,   /* `err` says why */
};

struct watch {
    struct remote *remote;
    const char *id;
    struct progress *progress;
    bool json;             /* also a line of JSON per change on stdout */
    bool curve;            /* draw the error's curve above the moving line (plot.h) */
    struct remote_job job; /* as last seen */
    char etag[80];
    int64_t nap_ms;          /* between two looks */
    int64_t silent_since_ms; /* 0: the last look was answered */
    char plot[PLOT_BYTES];
};

void watch_block(void);
enum watch_event watch_step(struct watch *, struct err *);

/* Steps until anything but WATCH_RUNNING. */
enum watch_event watch_run(struct watch *, struct err *);

/* After WATCH_OVER: says on stderr how the job ended, and returns the exit status of it. */
int watch_verdict(const struct watch *);

#endif
