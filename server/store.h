/* store.h - what survives a restart: one row per job and the points of its curve, in SQLite
 * (STATE/smalti.db).
 *
 * Every call is one transaction, on disk when it returns (WAL, synchronous=FULL). Samples are not
 * here but in films (checkpoint.h); the film is written first and the row second, so a row
 * never claims samples that are only in memory. Owner thread only. Errors: ERR_IO.
 *
 * To change the schema: 1. add a step at the end of `steps` in store.c; never edit an old one.
 * 2. add the column to `columns` there, and to read_row and bind_row. 3. let test_store open a
 * store of the old version. SPDX-License-Identifier: MIT */
#ifndef SERVER_STORE_H
#define SERVER_STORE_H

#include "common/err.h"
#include "common/film.h"
#include "common/hash.h"
#include "common/plan.h"
#include "common/scene.h"

/*      queued ----> running ----> done ----> queued, for more
 *        |  ^         | ^  \
 *        v  |         v |   `---> failed      queued, running, paused ---> cancelled
 *       paused <----> paused
 */
enum job_state {
    JOB_QUEUED,
    JOB_RUNNING,
    JOB_PAUSED,
    JOB_DONE,
    JOB_FAILED,
    JOB_CANCELLED,
};

enum { STORE_REASON = 512 };

/* A job's method. */
enum {
    STORE_METHOD_GIVEN = 0,   /* by its document */
    STORE_METHOD_OPEN = 1,    /* it is still to be planned */
    STORE_METHOD_PLANNED = 2, /* + enum plan_candidate_kind */
};

struct store_failure {
    char reason[STORE_REASON]; /* "": none */
    bool has_pass;             /* it happened in a pass of a tile */
    uint32_t tile, pass;
};

enum { STORE_WARNINGS = 2048 };

struct store_report {             /* report.h; of the film that the error is of */
    double error_low, error_high; /* 95 % interval of the error; < 0: unknown */
    double unknown, heavy; /* shares of pixels without trusted bars (evidence.h); < 0: unknown */
    double energy;         /* mean luminance of the image */
    double clamped, cut;   /* what settings.clamp and max_bounces have taken from that */
    struct film_work work;
    struct film_dropped dropped;
    uint32_t spp_least, spp_most; /* samples of a pixel */
    double spp_mean;
    double stopped; /* share of the pixels that have enough for the error target; 0: without one */
};

struct store_job {
    uint64_t id;     /* never 0 */
    uint64_t number; /* in order of submission, from 1; given by store_job_add */
    char document[HASH_HEX];
    char title[SCENE_MAX_NAME + 1];
    enum job_state state;
    int32_t priority;
    uint32_t width_px, height_px, tile_px;
    struct tile_rect crop;
    uint32_t layers;            /* of the film, layers.h */
    struct scene_target target; /* spp: the one settled on, once that is known */
    uint32_t method;            /* STORE_METHOD_... */
    bool stratified; /* its samples are made for target.spp as submitted: it cannot go on beyond */
    bool settled;    /* a job with a seconds target has decided where to stop */
    int64_t created_unix_ms, started_unix_ms, finished_unix_ms; /* 0: not yet */
    int64_t elapsed_ms;   /* running, from the first lease, up to the last time it was stored */
    uint64_t samples;     /* merged, over all pixels */
    uint64_t passes_done; /* merged, over all tiles */
    uint32_t spp_done;    /* every pixel has at least these */
    double error;         /* < 0: unknown */
    struct store_report report;
    uint64_t cpu_us;
    uint64_t granted, expired, returned, duplicates; /* leases; results that came twice */
    uint64_t invalid_count;
    uint32_t key_count;
    struct film_key keys[FILM_MAX_KEYS];
    uint64_t image_version; /* 0: no image yet */
    char digest[HASH_HEX];  /* of the finished image; "" before */
    uint64_t checkpoint;    /* generation of the film on disk; 0: none */
    struct store_failure failure;
    char warnings[STORE_WARNINGS]; /* status_warnings.h; "": none */
};

struct store_point {  /* of a job's curve (convergence.h) */
    uint64_t samples; /* merged, over all pixels */
    uint32_t spp;
    int64_t elapsed_ms;
    uint64_t cpu_us;
    uint64_t units;                      /* of work (common/film.h) */
    double error, error_low, error_high; /* the ends of its 95 % interval; < 0: unknown */
};

struct store; /* opaque */

struct store *store_open(const char *path, struct err *); /* NULL: failed */
void store_close(struct store *);

bool store_job_add(struct store *, struct store_job *, struct err *) MUST_CHECK;
bool store_job_save(struct store *, const struct store_job *, struct err *) MUST_CHECK;

/* Calls `each` for every job, oldest first. */
bool store_jobs(struct store *, void (*each)(void *context, const struct store_job *),
                void *context, struct err *) MUST_CHECK;

/* The job's points from this one's samples on are replaced by it. */
bool store_point_add(struct store *, uint64_t number, const struct store_point *,
                     struct err *) MUST_CHECK;
bool store_points(struct store *, uint64_t number,
                  void (*each)(void *context, const struct store_point *), void *context,
                  struct err *) MUST_CHECK; /* by samples, ascending */

const char *store_state_name(enum job_state);

#endif
