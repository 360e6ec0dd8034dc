/* SPDX-License-Identifier: MIT */
#include "server/output.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "common/clock.h"
#include "server/merge.h"
#include "server/round.h"

enum {
    SHARE = 50,      /* output takes less than one part in so many of the time */
    MAX_COPIES = 4,  /* snapshots of films at once */
    MAX_TASKS = 48,  /* at the writer */
    RETRY_MS = 5000, /* after a failure of the disk */
};

/* ---- tasks ---- */

static struct writer_task *task_new(const struct server *s, struct job *j, unsigned parts)
{
    struct writer_task *t = arena_malloc(1, sizeof *t);
    job_clock(j, s->now_ms);
    t->parts = parts;
    t->job = j;
    t->error = -1;
    t->snapshot.row = j->row;
    t->snapshot.generation = j->row.checkpoint + 1;
    t->snapshot.tile_count = j->tile_count;
    t->snapshot.rounds_judged = j->rounds_judged;
    adaptive_copy(&t->snapshot.adaptive, &j->adaptive);
    t->judge_spp = parts & WRITER_ERROR && round_wants_judge(j) ? round_spp(j) : 0;
    server_job_directory(s, j, t->directory, sizeof t->directory);
    return t;
}

static void film_move(struct film *to, struct film *from)
{
    *to = *from;
    from->sum = NULL;
    from->replicate = NULL;
    from->spp = NULL;
    from->blocks = NULL;
    from->variance = NULL;
    from->layer = NULL;
}

static void hand_over(struct server *s, struct writer_task *t)
{
    t->job->writing = true;
    s->tasks++;
    writer_push(s->writer, t);
}

/* ---- what is due ---- */

static unsigned parts_due(const struct server *s, const struct job *j)
{
    const bool film_behind = j->row.samples != j->film_samples;
    if (s->stopping)
        return film_behind && !j->film_failed ? WRITER_FILM : 0;
    unsigned parts = 0;
    if (round_wants_judge(j) && !j->reached)
        parts |= WRITER_ERROR;
    if (j->rounds_done && j->row.samples != j->image_samples && s->now_ms >= j->next_image_ms)
        parts |= WRITER_IMAGE;
    if (film_behind && s->now_ms >= j->next_film_ms)
        parts |= WRITER_FILM;
    return parts;
}

static void job_turn(struct server *s, struct job *j)
{
    if (!j->open || j->writing || s->now_ms < j->retry_ms || s->tasks >= MAX_TASKS)
        return;
    const bool last = round_is_last(j) && !round_wants_judge(j);
    if (!s->stopping && j->row.state == JOB_RUNNING && (last || j->reached)) {
        struct writer_task *t =
            task_new(s, j, WRITER_FILM | WRITER_ERROR | WRITER_IMAGE | WRITER_FINAL);
        film_move(&t->snapshot.film, &j->film);
        j->finishing = true;
        hand_over(s, t);
        return;
    }
    const unsigned parts = parts_due(s, j);
    if (!parts || s->tasks >= MAX_COPIES)
        return;
    struct writer_task *t = task_new(s, j, parts);
    film_copy(&t->snapshot.film, &j->film);
    hand_over(s, t);
}

void output_turn(struct server *s)
{
    for (size_t i = 0; i < s->sched.count; i++)
        job_turn(s, s->sched.jobs[i]);
}

bool output_is_settled(const struct server *s)
{
    if (s->tasks)
        return false;
    for (size_t i = 0; i < s->sched.count; i++)
        if (s->sched.jobs[i]->open && parts_due(s, s->sched.jobs[i]))
            return false;
    return true;
}

/* ---- what came back ---- */

static void film_forget(const struct server *s, const struct job *j)
{
    char path[DISK_PATH];
    server_job_directory(s, j, path, sizeof path - 8);
    strcat(path, "/film");
    unlink(path);
}

void output_last(struct server *s, struct job *j)
{
    if (j->open && !j->finishing && j->rounds_done && j->row.samples != j->image_samples) {
        struct writer_task *t = task_new(s, j, WRITER_IMAGE);
        film_move(&t->snapshot.film, &j->film);
        hand_over(s, t);
    } else if (!j->writing) {
        film_forget(s, j);
    }
    job_close(j);
}

/* A point of the curve is of the snapshot, not of what has come meanwhile. */
static void note_point(struct server *s, struct job *j, const struct writer_task *t)
{
    struct store_job row = t->snapshot.row;
    struct err err;
    row.error = t->error;
    if (t->parts & WRITER_FINAL)
        row.state = JOB_DONE;
    if (!convergence_note(&j->convergence, s->store, &row, &err))
        log_error("curve job=%016llx %s", (unsigned long long)row.id, err.text);
}

static void note_image(struct job *j, const struct writer_task *t)
{
    j->row.image_version++;
    j->row.error = t->error;
    j->row.report = t->snapshot.row.report;
    job_touch(j);
}

/* The row goes to disk as done before anybody hears that it is. */
static bool finish(struct server *s, struct writer_task *t)
{
    struct job *j = t->job;
    struct store_job row = j->row;
    row.state = JOB_DONE;
    row.finished_unix_ms = clock_unix_ms();
    row.checkpoint = t->snapshot.generation;
    row.image_version++;
    row.error = t->error;
    row.report = t->snapshot.row.report;
    memcpy(row.digest, t->digest, sizeof row.digest);
    if (!store_job_save(s->store, &row, &t->err))
        return false;
    j->row.checkpoint = row.checkpoint;
    memcpy(j->row.digest, row.digest, sizeof j->row.digest);
    note_point(s, j, t);
    note_image(j, t);
    server_job_end(s, j, JOB_DONE);
    return true;
}

static void try_again(struct server *s, struct writer_task *t)
{
    struct job *j = t->job;
    log_error("output job=%016llx %s", (unsigned long long)j->row.id, t->err.text);
    j->retry_ms = s->now_ms + RETRY_MS;
    j->film_failed = true;
    if (j->finishing) {
        film_move(&j->film, &t->snapshot.film);
        j->finishing = false;
    }
}

static void judge(struct server *s, struct job *j, const struct writer_task *t)
{
    const uint32_t spp = t->judge_spp;
    adaptive_add(&j->adaptive, &t->look);
    j->reached = adaptive_is_due(&j->adaptive, spp);
    j->row.error = t->error;
    j->row.report = t->snapshot.row.report;
    j->row.report.stopped = adaptive_stopped(&j->adaptive, spp);
    job_touch(j);
    if (!j->reached) {
        merge_next_round(j, s->now_ms);
        server_leases_end(s, j, false);
    }
    s->news = true;
}

static void note_parts(struct server *s, const struct writer_task *t)
{
    struct job *j = t->job;
    const int64_t rest_ms = t->took_ms * SHARE;
    if (t->parts & WRITER_FILM) {
        j->row.checkpoint = t->snapshot.generation;
        j->film_samples = t->snapshot.row.samples;
        j->next_film_ms = s->now_ms + max_i64(s->config->checkpoint_ms, rest_ms);
        j->film_failed = false;
    }
    if (t->parts & WRITER_IMAGE) {
        note_image(j, t);
        j->image_samples = t->snapshot.row.samples;
        j->next_image_ms = s->now_ms + max_i64(s->config->image_ms, rest_ms);
    }
    if (t->parts & (WRITER_ERROR | WRITER_IMAGE))
        note_point(s, j, t);
    if (t->parts & (WRITER_FILM | WRITER_IMAGE))
        server_job_save(s, j);
    if (t->judge_spp && !s->stopping)
        judge(s, j, t);
}

void output_written(struct server *s, struct writer_task *t)
{
    struct job *j = t->job;
    s->tasks--;
    j->writing = false;
    if (job_is_over(j)) { /* ended meanwhile: its image stays, its film goes */
        if (t->ok && t->parts & WRITER_IMAGE) {
            note_image(j, t);
            server_job_save(s, j);
        }
        film_forget(s, j);
    } else if (!t->ok) {
        try_again(s, t);
    } else if (!(t->parts & WRITER_FINAL)) {
        note_parts(s, t);
    } else if (!finish(s, t)) {
        try_again(s, t);
    }
    writer_task_free(t);
}
