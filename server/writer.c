/* SPDX-License-Identifier: MIT */
#include "server/writer.h"

#include <math.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>

#include "common/clock.h"
#include "common/estimate.h"
#include "server/image.h"
#include "server/report.h"
#include "server/status_report.h"

enum { QUEUE = 64, PATIENCE_MS = 60000 };

struct writer {
    struct queue *inbox;  /* the owner's */
    struct queue *outbox; /* ours */
    pthread_t thread;
};

static void target_text(const struct scene_target *t, char *out, size_t bytes)
{
    char error[40] = "null", seconds[40] = "null";
    if (t->error > 0)
        snprintf(error, sizeof error, "%.9g", t->error);
    if (t->seconds > 0)
        snprintf(seconds, sizeof seconds, "%.9g", t->seconds);
    snprintf(out, bytes, "{\"error\": %s, \"spp\": %u, \"seconds\": %s}", error, t->spp, seconds);
}

/* The job's plan, to be freed; "": it has none. */
static char *plan_text(const struct writer_task *t)
{
    struct buf text = {0};
    struct err err;
    char path[DISK_PATH];
    snprintf(path, sizeof path, "%s/plan.json", t->directory);
    const bool good = t->snapshot.row.method >= STORE_METHOD_PLANNED &&
                      buf_read_file(&text, path, PLAN_MAX_BYTES, &err);
    if (!good)
        text.size = 0;
    buf_append(&text, "", 1);
    return (char *)text.data;
}

static bool write_files(struct writer_task *t, const struct image *image, const char *report)
{
    const struct store_job *row = &t->snapshot.row;
    char path[DISK_PATH], job[24], target[160];
    snprintf(job, sizeof job, "%016llx", (unsigned long long)row->id);
    target_text(&row->target, target, sizeof target);
    char *plan = plan_text(t);
    const struct image_facts facts = {
        .job = job,
        .document = row->document,
        .target = target,
        .plan = plan,
        .digest = t->digest,
        .report = report,
        .error = t->error < 0 ? INFINITY : (float)t->error,
        .error_low = row->report.error_low < 0 ? 0 : (float)row->report.error_low,
        .error_high = row->report.error_low < 0 ? INFINITY : (float)row->report.error_high,
        .unknown = (float)row->report.unknown,
        .heavy = (float)row->report.heavy,
        .cpu_seconds = (float)((double)row->cpu_us / 1e6),
        .stopped = (float)row->report.stopped,
        .spp_mean = (float)row->report.spp_mean,
        .spp = row->spp_done,
        .spp_least = row->report.spp_least,
        .spp_most = row->report.spp_most,
    };
    snprintf(path, sizeof path, "%s/image.exr", t->directory);
    const bool good = image_write_exr(
        image, &facts, t->parts & WRITER_FINAL ? IMAGE_ZIP : IMAGE_PLAIN, path, &t->err);
    free(plan);
    if (!good)
        return false;
    snprintf(path, sizeof path, "%s/preview.png", t->directory);
    return image_write_png(image, path, &t->err);
}

static bool write_images(struct writer_task *t, const struct image *image)
{
    const struct store_job *row = &t->snapshot.row;
    char *report = status_report_text(row);
    const bool ok = write_files(t, image, report);
    free(report);
    return ok;
}

void writer_run(struct writer_task *t)
{
    const int64_t begin_ms = clock_ms();
    const struct film *film = &t->snapshot.film;
    t->ok = disk_directory(t->directory, &t->err);
    if (t->ok && t->parts & WRITER_FILM) {
        char path[DISK_PATH];
        snprintf(path, sizeof path, "%s/film", t->directory);
        t->ok = checkpoint_write(&t->snapshot, path, &t->err);
    }
    if (t->parts & (WRITER_ERROR | WRITER_IMAGE)) {
        const double e = estimate_error(film);
        t->error = isfinite(e) ? e : -1;
        t->snapshot.row.error = t->error;
        t->snapshot.row.report = report_make(film);
        t->snapshot.row.report.stopped =
            adaptive_stopped(&t->snapshot.adaptive, t->snapshot.row.spp_done);
    }
    if (t->judge_spp)
        t->look = adaptive_look(film, t->judge_spp, &t->snapshot.adaptive, &t->arena);
    if (t->ok && t->parts & WRITER_IMAGE) {
        struct arena arena = {0};
        const struct image image =
            image_from_film(film, t->snapshot.row.width_px, t->snapshot.row.height_px, &arena);
        image_digest(&image, t->digest);
        t->ok = write_images(t, &image);
        arena_release(&arena);
    }
    t->took_ms = clock_ms() - begin_ms;
}

static void *loop(void *context)
{
    struct writer *w = context;
    for (;;) {
        struct message m;
        if (!queue_pop(w->outbox, &m, clock_ms() + PATIENCE_MS))
            continue;
        if (m.kind == MESSAGE_STOP)
            return NULL;
        writer_run(m.data);
        queue_push(w->inbox, (struct message){MESSAGE_WRITTEN, m.data});
    }
}

struct writer *writer_start(struct queue *inbox)
{
    struct writer *w = arena_malloc(1, sizeof *w);
    w->inbox = inbox;
    w->outbox = queue_new(QUEUE);
    if (pthread_create(&w->thread, NULL, loop, w) == 0)
        return w;
    queue_free(w->outbox);
    free(w);
    return NULL;
}

void writer_push(struct writer *w, struct writer_task *t)
{
    queue_push(w->outbox, (struct message){MESSAGE_WRITE, t});
}

void writer_stop(struct writer *w)
{
    queue_push(w->outbox, (struct message){MESSAGE_STOP, NULL});
    pthread_join(w->thread, NULL);
    queue_free(w->outbox);
    free(w);
}

void writer_task_free(struct writer_task *t)
{
    checkpoint_release(&t->snapshot);
    arena_release(&t->arena);
    free(t);
}
