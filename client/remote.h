/* remote.h - a coordinator, as the CLI sees it (docs/http.md).
 *
 * What it answers is checked before use; text in it is only ever printed.
 * Errors: ERR_IO no answer (or 5xx), ERR_NOT_FOUND, ERR_CONFLICT, ERR_INPUT what we sent was
 * refused, ERR_PROTOCOL the answer makes no sense.
 * SPDX-License-Identifier: MIT */
#ifndef CLIENT_REMOTE_H
#define CLIENT_REMOTE_H

#include "common/buf.h"
#include "common/err.h"
#include "common/hash.h"

struct http_client;

struct remote {
    struct http_client *http;
};

enum remote_state {
    REMOTE_QUEUED,
    REMOTE_RUNNING,
    REMOTE_PAUSED,
    REMOTE_DONE,
    REMOTE_FAILED,
    REMOTE_CANCELLED
};

struct remote_job {
    char id[17];
    char title[129];
    enum remote_state state;
    double progress;              /* of the nearest target, 0 to 1 */
    double error;                 /* < 0: not known yet */
    double error_low, error_high; /* its 95 % interval; < 0: not known */
    double untrusted;   /* share of pixels whose error bars are not to be trusted; < 0: not known */
    double rate;        /* samples per second; < 0: not known */
    double eta_seconds; /* < 0: not known */
    double elapsed_seconds, cpu_seconds;
    uint32_t spp, target_spp, workers;
    double target_error; /* 0: none */
    char ended_by[16];   /* the target that did; "" before */
    uint64_t samples, invalid_samples;
    char digest[HASH_HEX]; /* of the finished image; "" before */
    char failure[512];     /* "" unless it failed */
};

struct remote_target { /* of a job that is done; at least one is given */
    double error;      /* 0: none */
    uint32_t spp;      /* 0: none */
};

enum { REMOTE_CURVE = 512 };

struct remote_point {
    double spp; /* mean of the pixels */
    double error;
};

struct remote_curve {
    struct remote_point points[REMOTE_CURVE]; /* the latest so many, in order */
    size_t count;
    double target_error; /* 0: none */
    double forecast_spp; /* when it should be there; 0: not known, or reached */
};

bool remote_open(struct remote *, const char *server, struct err *) MUST_CHECK;
void remote_close(struct remote *);

bool remote_is_id(const char *text); /* 16 lower-case hex digits */
const char *remote_state_name(enum remote_state);
bool remote_is_over(enum remote_state);

/* Each fills `job` and, when not NULL, appends the JSON as it came to `json`. */
bool remote_submit(struct remote *, const char *document, size_t bytes, int32_t priority,
                   struct remote_job *job, struct buf *json, struct err *) MUST_CHECK;
bool remote_cancel(struct remote *, const char *id, struct remote_job *job,
                   struct err *) MUST_CHECK;
bool remote_continue(struct remote *, const char *id, const struct remote_target *,
                     struct err *) MUST_CHECK;
/* etag: in and out, "" at first; *changed false: as before, `job` is untouched. */
bool remote_look(struct remote *, const char *id, char etag[80], bool *changed,
                 struct remote_job *job, struct buf *json, struct err *) MUST_CHECK;

/* How the job's error went. */
bool remote_convergence(struct remote *, const char *id, struct remote_curve *,
                        struct err *) MUST_CHECK;

/* The newest jobs, at most `most`; *count of them. */
bool remote_list(struct remote *, struct remote_job *jobs, size_t most, size_t *count,
                 struct buf *json, struct err *) MUST_CHECK;

/* "image.exr", "preview.png": appended to `out`. */
bool remote_fetch(struct remote *, const char *id, const char *what, struct buf *out,
                  struct err *) MUST_CHECK;

/* Assets, by the SHA-256 of their bytes. */
bool remote_has_asset(struct remote *, const char hex[HASH_HEX], bool *here,
                      struct err *) MUST_CHECK;
/* Appended to the empty `out`; its hash was checked. */
bool remote_get_asset(struct remote *, const char *hex, size_t max_bytes, struct buf *out,
                      struct err *) MUST_CHECK;
bool remote_put_asset(struct remote *, const char hex[HASH_HEX], const struct buf *bytes,
                      struct err *) MUST_CHECK;

#endif
