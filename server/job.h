/* job.h - a job while the coordinator knows it: its row, and, once it is open, its film and what
 * has become of each pass of each tile.
 *
 * Passes of a tile are merged in order. Around the next one a window of JOB_LOOKAHEAD passes is
 * open:
 *
 *     READY --granted--> LEASED --delivered--> (merged, or HELD until its turn)
 *       ^                  |  |                    |
 *       +-----expired------+  +--failed--> SHUNNED: for another worker, or for any after a while
 *       +----given back----+                       |
 *       +--of blocks that have stopped since-------+
 *
 * Only the functions here, in sched.c and in merge.c assign a slot's state. Of which blocks a pass
 * is, and what a round is, says round.h; `rounds_done` of them are complete.
 * Owner thread only; time is an argument.
 * SPDX-License-Identifier: MIT */
#ifndef SERVER_JOB_H
#define SERVER_JOB_H

#include "common/adaptive.h"
#include "common/film.h"
#include "server/convergence.h"
#include "server/rate.h"
#include "server/store.h"

enum {
    JOB_LOOKAHEAD = 4,     /* passes of a tile that may be out at once */
    JOB_MAX_WORKERS = 3,   /* a pass that failed on so many different ones fails the job */
    JOB_MAX_FAILURES = 5,  /* or so many times in all */
    JOB_MAX_EXPIRIES = 10, /* or lapsed so many times: it may kill its workers */
    JOB_SHUN_MS = 5000,    /* how long a failed pass waits for another worker */
};

#define JOB_PLAN UINT32_MAX /* in place of a tile: a lease to make the plan, not a pass */

enum slot_state { SLOT_READY, SLOT_LEASED, SLOT_HELD, SLOT_SHUNNED };

struct job_held { /* a payload that came early */
    uint64_t cpu_us;
    struct film_samples samples; /* its arrays: `blocks`, then sums, then layer_sums */
    struct block blocks[];
};

struct job_slot {
    enum slot_state state;
    uint64_t lease;        /* SLOT_LEASED: its id */
    uint32_t blocks;       /* SLOT_LEASED, SLOT_HELD: of how many blocks it is */
    struct job_held *held; /* SLOT_HELD: owned, one block */
};

struct job_tile {
    uint32_t merged;                      /* passes [0, merged) are in the film */
    struct job_slot slots[JOB_LOOKAHEAD]; /* pass p, merged <= p < merged + JOB_LOOKAHEAD, is at
                                           * p % JOB_LOOKAHEAD */
};

struct job_trouble {     /* a pass that failed or lapsed and is not merged yet */
    uint32_t tile, pass; /* or JOB_PLAN, 0: the plan */
    uint32_t expiries, failures, worker_count;
    uint32_t workers[JOB_MAX_WORKERS]; /* their numbers (farm.h) */
    int64_t shun_until_ms;             /* SLOT_SHUNNED: any worker may try again from then on */
};

struct job {
    struct store_job row;
    struct tile_grid grid;
    uint32_t tile_count;
    uint64_t pixels;
    uint64_t version;        /* changes whenever something visible does */
    int64_t running_from_ms; /* elapsed time since then is not in row.elapsed_ms; < 0: standing */
    struct rate rate;        /* merged samples */
    struct convergence
        convergence; /* of a job that is not over: others' points are in the store alone */
    uint32_t lease_count;

    uint64_t plan_lease; /* 0: nobody makes its plan */

    bool unsaved; /* its row did not reach the disk */
    bool open;    /* what follows exists */
    struct film film;
    struct adaptive adaptive; /* aimed at the error target */
    struct job_tile *tiles;
    struct job_trouble *troubles;
    uint32_t trouble_count, trouble_capacity;
    uint32_t rounds_done;
    uint32_t tiles_ahead;   /* tiles with more than rounds_done passes */
    uint32_t rounds_judged; /* error target: rounds found not good enough yet; pass p is merged only
                             * when p <= rounds_judged */
    uint32_t rounds_decided;           /* seconds target: rounds that may be leased */
    uint32_t cursor_pass, cursor_tile; /* nothing READY comes before, in breadth-first order */
    uint64_t held_bytes;

    /* Output (output.c). */
    bool writing;     /* a task for this job is with the writer */
    bool finishing;   /* the last one */
    bool reached;     /* its error target is met: nothing more is merged */
    bool film_failed; /* the last checkpoint did not reach the disk */
    int64_t retry_ms; /* no output before then */
    bool starved;     /* found no memory for its film; tried again when some is freed */
    int64_t next_image_ms, next_film_ms;
    uint64_t image_samples, film_samples; /* row.samples when last written */
};

struct job *job_new(const struct store_job *);
void job_free(struct job *);

/* Memory for its passes; takes over the film's and the records' arrays. They come from a checkpoint
 * with the rounds that were judged then, or are empty and 0. */
void job_open(struct job *, struct film *, struct adaptive *, uint32_t rounds_judged);
void job_close(struct job *);
uint64_t job_film_bytes(const struct job *); /* what being open costs */

bool job_is_over(const struct job *);    /* done, failed or cancelled */
uint32_t job_passes(const struct job *); /* per tile, up to the spp target */
int64_t job_elapsed_ms(const struct job *, int64_t now_ms);
void job_touch(struct job *); /* something visible has changed */

/* Transitions; each asserts where it comes from. The caller saves the row. */
void job_start(struct job *, int64_t now_ms, int64_t unix_ms); /* first lease */
/* Done, and now to be queued for more. */
void job_continue(struct job *, const struct scene_target *);
void job_pause(struct job *, int64_t now_ms);
void job_resume(struct job *, int64_t now_ms);
void job_end(struct job *, enum job_state, int64_t now_ms, int64_t unix_ms); /* done, failed... */
void job_clock(struct job *, int64_t now_ms); /* brings row.elapsed_ms up to date */

/* Passes. */
bool job_in_window(const struct job *, uint32_t tile, uint32_t pass);
struct job_slot *job_slot(struct job *, uint32_t tile, uint32_t pass); /* in the window */
/* Back for anyone; what is held is dropped. */
void job_slot_ready(struct job *, uint32_t tile, uint32_t pass);
struct job_trouble *job_trouble_of(struct job *, uint32_t tile, uint32_t pass); /* makes it */
void job_trouble_forget(struct job *, uint32_t tile, uint32_t pass);

/* Counts an expiry or a reported failure; false: the pass has used up its chances, and the job's
 * failure is filled in. */
bool job_pass_expired(struct job *, uint32_t tile, uint32_t pass);
bool job_pass_failed(struct job *, uint32_t tile, uint32_t pass, uint32_t worker,
                     const char *reason, int64_t now_ms);

/* A plan is wanted of an open job that has none: it is leased as a whole, and lapses and fails as
 * passes do. */
bool job_wants_plan(const struct job *);
bool job_plan_may_try(const struct job *, uint32_t worker, int64_t now_ms);
void job_plan_granted(struct job *, uint64_t lease);
void job_plan_back(struct job *); /* for anyone */
bool job_plan_expired(struct job *);
bool job_plan_failed(struct job *, uint32_t worker, const char *reason, int64_t now_ms);
void job_plan_made(struct job *, enum plan_candidate_kind);
void job_fail_reason(struct job *, const char *reason); /* without a pass */

#endif
