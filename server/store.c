/* SPDX-License-Identifier: MIT */
#include "server/store.h"

#include <assert.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <sqlite3.h>

#include "common/arena.h"
#include "common/buf.h"

/* steps[v] takes a store of version v to version v + 1. */
static const char *const steps[] = {
    "CREATE TABLE job ("
    " number INTEGER PRIMARY KEY AUTOINCREMENT, id INTEGER NOT NULL UNIQUE,"
    " document TEXT NOT NULL, title TEXT NOT NULL, state INTEGER NOT NULL,"
    " priority INTEGER NOT NULL, width INTEGER NOT NULL, height INTEGER NOT NULL,"
    " tile_px INTEGER NOT NULL, x_begin INTEGER NOT NULL, y_begin INTEGER NOT NULL,"
    " x_end INTEGER NOT NULL, y_end INTEGER NOT NULL, target_error REAL NOT NULL,"
    " target_spp INTEGER NOT NULL, target_seconds REAL NOT NULL, settled INTEGER NOT NULL,"
    " created INTEGER NOT NULL, started INTEGER NOT NULL, finished INTEGER NOT NULL,"
    " elapsed_ms INTEGER NOT NULL, samples INTEGER NOT NULL, passes INTEGER NOT NULL,"
    " spp INTEGER NOT NULL, error REAL NOT NULL, cpu_us INTEGER NOT NULL,"
    " granted INTEGER NOT NULL, expired INTEGER NOT NULL, returned INTEGER NOT NULL,"
    " duplicates INTEGER NOT NULL, invalid INTEGER NOT NULL, keys BLOB NOT NULL,"
    " image INTEGER NOT NULL, digest TEXT NOT NULL, checkpoint INTEGER NOT NULL,"
    " reason TEXT NOT NULL, in_pass INTEGER NOT NULL, in_tile INTEGER NOT NULL,"
    " has_pass INTEGER NOT NULL) STRICT",
    "ALTER TABLE job ADD COLUMN layers INTEGER NOT NULL DEFAULT 0",
    "CREATE TABLE point ("
    " job INTEGER NOT NULL REFERENCES job(number), samples INTEGER NOT NULL, spp INTEGER NOT NULL,"
    " elapsed_ms INTEGER NOT NULL, cpu_us INTEGER NOT NULL, error REAL NOT NULL,"
    " PRIMARY KEY (job, samples)) STRICT, WITHOUT ROWID",
    /* Tiles are whole blocks from here on. */
    "ALTER TABLE job ADD COLUMN error_low REAL NOT NULL DEFAULT -1;"
    "ALTER TABLE job ADD COLUMN error_high REAL NOT NULL DEFAULT -1;"
    "ALTER TABLE job ADD COLUMN unknown REAL NOT NULL DEFAULT -1;"
    "ALTER TABLE job ADD COLUMN heavy REAL NOT NULL DEFAULT -1;"
    "ALTER TABLE job ADD COLUMN energy REAL NOT NULL DEFAULT 0;"
    "ALTER TABLE job ADD COLUMN clamped REAL NOT NULL DEFAULT 0;"
    "ALTER TABLE job ADD COLUMN cut REAL NOT NULL DEFAULT 0;"
    "ALTER TABLE job ADD COLUMN camera_rays INTEGER NOT NULL DEFAULT 0;"
    "ALTER TABLE job ADD COLUMN bounce_rays INTEGER NOT NULL DEFAULT 0;"
    "ALTER TABLE job ADD COLUMN shadow_rays INTEGER NOT NULL DEFAULT 0;"
    "ALTER TABLE job ADD COLUMN plain_vertices INTEGER NOT NULL DEFAULT 0;"
    "ALTER TABLE job ADD COLUMN other_vertices INTEGER NOT NULL DEFAULT 0;"
    "ALTER TABLE job ADD COLUMN degenerate INTEGER NOT NULL DEFAULT 0;"
    "ALTER TABLE job ADD COLUMN nonfinite INTEGER NOT NULL DEFAULT 0;"
    "UPDATE job SET tile_px = (tile_px + 7) / 8 * 8",
    "ALTER TABLE job ADD COLUMN units INTEGER NOT NULL DEFAULT 0;"
    "ALTER TABLE point ADD COLUMN error_low REAL NOT NULL DEFAULT -1;"
    "ALTER TABLE point ADD COLUMN error_high REAL NOT NULL DEFAULT -1;"
    "ALTER TABLE point ADD COLUMN units INTEGER NOT NULL DEFAULT 0",
    "ALTER TABLE job ADD COLUMN warnings TEXT NOT NULL DEFAULT ''",
    "ALTER TABLE job ADD COLUMN method INTEGER NOT NULL DEFAULT 0",
    "ALTER TABLE job ADD COLUMN stratified INTEGER NOT NULL DEFAULT 0",
    /* Until here all pixels of a job that is done have equally many. */
    "ALTER TABLE job ADD COLUMN spp_least INTEGER NOT NULL DEFAULT 0;"
    "ALTER TABLE job ADD COLUMN spp_most INTEGER NOT NULL DEFAULT 0;"
    "ALTER TABLE job ADD COLUMN spp_mean REAL NOT NULL DEFAULT 0;"
    "ALTER TABLE job ADD COLUMN stopped REAL NOT NULL DEFAULT 0;"
    "UPDATE job SET spp_least = spp, spp_most = spp, spp_mean = spp",
};

#define NAMES                                                                                      \
    "id, document, title, state, priority, width, height, tile_px, x_begin, y_begin, x_end, "      \
    "y_end, target_error, target_spp, target_seconds, settled, created, started, finished, "       \
    "elapsed_ms, samples, passes, spp, error, cpu_us, granted, expired, returned, duplicates, "    \
    "invalid, image, digest, checkpoint, reason, in_pass, in_tile, has_pass, layers, "             \
    "error_low, error_high, unknown, heavy, energy, clamped, cut, camera_rays, bounce_rays, "      \
    "shadow_rays, plain_vertices, other_vertices, units, degenerate, nonfinite, "                  \
    "warnings, method, stratified, spp_least, spp_most, spp_mean, stopped, keys"
#define MARKS                                                                                      \
    "?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8, ?9, ?10, ?11, ?12, ?13, ?14, ?15, ?16, ?17, ?18, ?19, ?20, "  \
    "?21, ?22, ?23, ?24, ?25, ?26, ?27, ?28, ?29, ?30, ?31, ?32, ?33, ?34, ?35, ?36, ?37, ?38, "   \
    "?39, ?40, ?41, ?42, ?43, ?44, ?45, ?46, ?47, ?48, ?49, ?50, ?51, ?52, ?53, ?54, ?55, ?56, "   \
    "?57, ?58, ?59, ?60, ?61"

enum column_kind { COLUMN_INT, COLUMN_REAL, COLUMN_TEXT };

/* Where the fields of NAMES are, in its order; the keys come last and are bound by hand. */
static const struct column {
    enum column_kind kind;
    size_t offset, size;
} columns[] = {
#define AT(kind, field)                                                                            \
    {                                                                                              \
        kind, offsetof(struct store_job, field), sizeof((struct store_job *)0)->field              \
    }
    AT(COLUMN_INT, id),
    AT(COLUMN_TEXT, document),
    AT(COLUMN_TEXT, title),
    AT(COLUMN_INT, state),
    AT(COLUMN_INT, priority),
    AT(COLUMN_INT, width_px),
    AT(COLUMN_INT, height_px),
    AT(COLUMN_INT, tile_px),
    AT(COLUMN_INT, crop.x_begin),
    AT(COLUMN_INT, crop.y_begin),
    AT(COLUMN_INT, crop.x_end),
    AT(COLUMN_INT, crop.y_end),
    AT(COLUMN_REAL, target.error),
    AT(COLUMN_INT, target.spp),
    AT(COLUMN_REAL, target.seconds),
    AT(COLUMN_INT, settled),
    AT(COLUMN_INT, created_unix_ms),
    AT(COLUMN_INT, started_unix_ms),
    AT(COLUMN_INT, finished_unix_ms),
    AT(COLUMN_INT, elapsed_ms),
    AT(COLUMN_INT, samples),
    AT(COLUMN_INT, passes_done),
    AT(COLUMN_INT, spp_done),
    AT(COLUMN_REAL, error),
    AT(COLUMN_INT, cpu_us),
    AT(COLUMN_INT, granted),
    AT(COLUMN_INT, expired),
    AT(COLUMN_INT, returned),
    AT(COLUMN_INT, duplicates),
    AT(COLUMN_INT, invalid_count),
    AT(COLUMN_INT, image_version),
    AT(COLUMN_TEXT, digest),
    AT(COLUMN_INT, checkpoint),
    AT(COLUMN_TEXT, failure.reason),
    AT(COLUMN_INT, failure.pass),
    AT(COLUMN_INT, failure.tile),
    AT(COLUMN_INT, failure.has_pass),
    AT(COLUMN_INT, layers),
    AT(COLUMN_REAL, report.error_low),
    AT(COLUMN_REAL, report.error_high),
    AT(COLUMN_REAL, report.unknown),
    AT(COLUMN_REAL, report.heavy),
    AT(COLUMN_REAL, report.energy),
    AT(COLUMN_REAL, report.clamped),
    AT(COLUMN_REAL, report.cut),
    AT(COLUMN_INT, report.work.camera_rays),
    AT(COLUMN_INT, report.work.bounce_rays),
    AT(COLUMN_INT, report.work.shadow_rays),
    AT(COLUMN_INT, report.work.plain_vertices),
    AT(COLUMN_INT, report.work.other_vertices),
    AT(COLUMN_INT, report.work.units),
    AT(COLUMN_INT, report.dropped.degenerate),
    AT(COLUMN_INT, report.dropped.nonfinite),
    AT(COLUMN_TEXT, warnings),
    AT(COLUMN_INT, method),
    AT(COLUMN_INT, stratified),
    AT(COLUMN_INT, report.spp_least),
    AT(COLUMN_INT, report.spp_most),
    AT(COLUMN_REAL, report.spp_mean),
    AT(COLUMN_REAL, report.stopped),
#undef AT
};

struct store {
    sqlite3 *db;
    sqlite3_stmt *add, *save;
};

static const char *const state_names[] = {
    [JOB_QUEUED] = "queued", [JOB_RUNNING] = "running", [JOB_PAUSED] = "paused",
    [JOB_DONE] = "done",     [JOB_FAILED] = "failed",   [JOB_CANCELLED] = "cancelled",
};

const char *store_state_name(enum job_state s)
{
    return state_names[s];
}

static bool failed(struct store *s, struct err *err)
{
    return err_set(err, ERR_IO, "job store: %s", sqlite3_errmsg(s->db));
}

static bool run(struct store *s, const char *sql, struct err *err)
{
    return sqlite3_exec(s->db, sql, NULL, NULL, NULL) == SQLITE_OK || failed(s, err);
}

/* ---- opening ---- */

static bool version_of(struct store *s, size_t *version, struct err *err)
{
    sqlite3_stmt *q = NULL;
    const bool ok = sqlite3_prepare_v2(s->db, "PRAGMA user_version", -1, &q, NULL) == SQLITE_OK &&
                    sqlite3_step(q) == SQLITE_ROW;
    *version = ok ? (size_t)sqlite3_column_int64(q, 0) : 0;
    if (!ok)
        failed(s, err);
    sqlite3_finalize(q);
    return ok;
}

static bool migrate(struct store *s, struct err *err)
{
    size_t version;
    if (!version_of(s, &version, err))
        return false;
    if (version > countof(steps))
        return err_set(err, ERR_INPUT, "job store: version %zu is newer than this program's, %zu",
                       version, countof(steps));
    for (; version < countof(steps); version++) {
        char bump[64];
        snprintf(bump, sizeof bump, "PRAGMA user_version = %zu", version + 1);
        if (!run(s, "BEGIN IMMEDIATE", err))
            return false;
        if (!run(s, steps[version], err) || !run(s, bump, err) || !run(s, "COMMIT", err))
            return false; /* closing rolls back */
    }
    return true;
}

static bool prepare(struct store *s, const char *sql, sqlite3_stmt **out, struct err *err)
{
    return sqlite3_prepare_v2(s->db, sql, -1, out, NULL) == SQLITE_OK || failed(s, err);
}

static bool open_all(struct store *s, const char *path, struct err *err)
{
    if (sqlite3_open_v2(path, &s->db,
                        SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE | SQLITE_OPEN_NOMUTEX,
                        NULL) != SQLITE_OK)
        return failed(s, err);
    sqlite3_busy_timeout(s->db, 5000);
    return run(s, "PRAGMA journal_mode = WAL", err) && run(s, "PRAGMA synchronous = FULL", err) &&
           run(s, "PRAGMA foreign_keys = ON", err) && run(s, "PRAGMA trusted_schema = OFF", err) &&
           migrate(s, err) &&
           prepare(s, "INSERT INTO job (" NAMES ") VALUES (" MARKS ")", &s->add, err) &&
           prepare(s, "UPDATE job SET (" NAMES ") = (" MARKS ") WHERE id = ?1", &s->save, err);
}

struct store *store_open(const char *path, struct err *err)
{
    struct store *s = arena_malloc(1, sizeof *s);
    if (open_all(s, path, err))
        return s;
    err_at(err, "%s", path);
    store_close(s);
    return NULL;
}

void store_close(struct store *s)
{
    sqlite3_finalize(s->add);
    sqlite3_finalize(s->save);
    sqlite3_close(s->db);
    free(s);
}

/* ---- rows ---- */

static void bind_field(sqlite3_stmt *q, int at, const struct column *c, const char *field)
{
    int64_t wide;
    int32_t narrow;
    double real;
    switch (c->kind) {
    case COLUMN_INT:
        memcpy(&wide, field, min_size(c->size, sizeof wide));
        memcpy(&narrow, field, min_size(c->size, sizeof narrow));
        if (c->size < sizeof wide)
            wide = c->size == 1 ? *field : narrow;
        sqlite3_bind_int64(q, at, wide);
        return;
    case COLUMN_REAL:
        memcpy(&real, field, sizeof real);
        sqlite3_bind_double(q, at, real);
        return;
    case COLUMN_TEXT:
        sqlite3_bind_text(q, at, field, -1, SQLITE_STATIC);
        return;
    }
    __builtin_unreachable();
}

static void read_field(sqlite3_stmt *q, int at, const struct column *c, char *field)
{
    int64_t wide;
    double real;
    const unsigned char *text;
    switch (c->kind) {
    case COLUMN_INT: /* little-endian: the low bytes come first */
        wide = sqlite3_column_int64(q, at);
        if (c->size == 1)
            wide = wide != 0;
        memcpy(field, &wide, c->size);
        return;
    case COLUMN_REAL:
        real = sqlite3_column_double(q, at);
        memcpy(field, &real, sizeof real);
        return;
    case COLUMN_TEXT:
        text = sqlite3_column_text(q, at);
        snprintf(field, c->size, "%s", text ? (const char *)text : "");
        return;
    }
    __builtin_unreachable();
}

static bool write_row(struct store *s, sqlite3_stmt *q, const struct store_job *job,
                      struct err *err)
{
    struct buf keys = {0};
    for (size_t i = 0; i < countof(columns); i++)
        bind_field(q, (int)i + 1, &columns[i], (const char *)job + columns[i].offset);
    for (uint32_t i = 0; i < job->key_count; i++) {
        buf_u32(&keys, job->keys[i].x_px);
        buf_u32(&keys, job->keys[i].y_px);
        buf_u32(&keys, job->keys[i].sample);
    }
    sqlite3_bind_blob(q, (int)countof(columns) + 1, keys.data ? (void *)keys.data : "",
                      (int)keys.size, SQLITE_STATIC);
    const bool ok = sqlite3_step(q) == SQLITE_DONE || failed(s, err);
    sqlite3_reset(q);
    sqlite3_clear_bindings(q);
    buf_release(&keys);
    return ok;
}

/* A damaged value must not become a bad index later. */
static bool row_is_sane(const struct store_job *j)
{
    const struct tile_rect c = j->crop;
    return j->id && (unsigned)j->state <= JOB_CANCELLED && hash_is_hex(j->document) &&
           j->width_px && j->width_px <= SCENE_MAX_SIDE_PX && j->height_px &&
           j->height_px <= SCENE_MAX_SIDE_PX && c.x_begin < c.x_end && c.x_end <= j->width_px &&
           c.y_begin < c.y_end && c.y_end <= j->height_px && tile_px_is_sane(j->tile_px) &&
           j->target.spp >= 1 && j->target.spp <= SCENE_MAX_SPP && layers_are_known(j->layers) &&
           j->method < STORE_METHOD_PLANNED + PLAN_REAL;
}

static bool read_row(sqlite3_stmt *q, struct store_job *job, struct err *err)
{
    *job = (struct store_job){.number = (uint64_t)sqlite3_column_int64(q, 0)};
    for (size_t i = 0; i < countof(columns); i++)
        read_field(q, (int)i + 1, &columns[i], (char *)job + columns[i].offset);
    const int at = (int)countof(columns) + 1;
    const size_t bytes = (size_t)sqlite3_column_bytes(q, at);
    struct buf_reader r = buf_reader_make(sqlite3_column_blob(q, at), bytes);
    job->key_count = (uint32_t)min_size(bytes / 12, FILM_MAX_KEYS);
    for (uint32_t i = 0; i < job->key_count; i++) {
        job->keys[i].x_px = buf_read_u32(&r);
        job->keys[i].y_px = buf_read_u32(&r);
        job->keys[i].sample = buf_read_u32(&r);
    }
    return row_is_sane(job) || err_set(err, ERR_INPUT, "job store: row %llu is damaged",
                                       (unsigned long long)job->number);
}

bool store_job_add(struct store *s, struct store_job *job, struct err *err)
{
    if (!write_row(s, s->add, job, err))
        return false;
    job->number = (uint64_t)sqlite3_last_insert_rowid(s->db);
    return true;
}

bool store_job_save(struct store *s, const struct store_job *job, struct err *err)
{
    if (!write_row(s, s->save, job, err))
        return false;
    assert(sqlite3_changes(s->db) == 1);
    return true;
}

bool store_jobs(struct store *s, void (*each)(void *context, const struct store_job *),
                void *context, struct err *err)
{
    sqlite3_stmt *q = NULL;
    if (!prepare(s, "SELECT number, " NAMES " FROM job ORDER BY number", &q, err))
        return false;
    int step;
    bool ok = true;
    while (ok && (step = sqlite3_step(q)) != SQLITE_DONE) {
        struct store_job job;
        ok = step == SQLITE_ROW ? read_row(q, &job, err) : failed(s, err);
        if (ok)
            each(context, &job);
    }
    sqlite3_finalize(q);
    return ok;
}

/* ---- points ---- */

bool store_point_add(struct store *s, uint64_t number, const struct store_point *p, struct err *err)
{
    sqlite3_stmt *forget = NULL, *q = NULL;
    bool ok = run(s, "BEGIN IMMEDIATE", err);
    if (!ok)
        return false;
    ok = prepare(s, "DELETE FROM point WHERE job = ?1 AND samples >= ?2", &forget, err) &&
         prepare(
             s,
             "INSERT INTO point (job, samples, spp, elapsed_ms, cpu_us, units, error, error_low, "
             "error_high) VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8, ?9)",
             &q, err);
    if (ok) {
        const int64_t numbers[] = {(int64_t)number, (int64_t)p->samples, p->spp,
                                   p->elapsed_ms,   (int64_t)p->cpu_us,  (int64_t)p->units};
        const double errors[] = {p->error, p->error_low, p->error_high};
        for (int i = 0; i < 2; i++)
            sqlite3_bind_int64(forget, i + 1, numbers[i]);
        for (int i = 0; i < 6; i++)
            sqlite3_bind_int64(q, i + 1, numbers[i]);
        for (int i = 0; i < 3; i++)
            sqlite3_bind_double(q, i + 7, errors[i]);
        ok = (sqlite3_step(forget) == SQLITE_DONE && sqlite3_step(q) == SQLITE_DONE) ||
             failed(s, err);
    }
    sqlite3_finalize(forget);
    sqlite3_finalize(q);
    if (ok && run(s, "COMMIT", err))
        return true;
    sqlite3_exec(s->db, "ROLLBACK", NULL, NULL, NULL);
    return false;
}

bool store_points(struct store *s, uint64_t number,
                  void (*each)(void *context, const struct store_point *), void *context,
                  struct err *err)
{
    sqlite3_stmt *q = NULL;
    if (!prepare(s,
                 "SELECT samples, spp, elapsed_ms, cpu_us, units, error, error_low, error_high "
                 "FROM point WHERE job = ?1 "
                 "ORDER BY samples",
                 &q, err))
        return false;
    sqlite3_bind_int64(q, 1, (int64_t)number);
    int step;
    while ((step = sqlite3_step(q)) == SQLITE_ROW) {
        const struct store_point p = {
            .samples = (uint64_t)sqlite3_column_int64(q, 0),
            .spp = (uint32_t)sqlite3_column_int64(q, 1),
            .elapsed_ms = sqlite3_column_int64(q, 2),
            .cpu_us = (uint64_t)sqlite3_column_int64(q, 3),
            .units = (uint64_t)sqlite3_column_int64(q, 4),
            .error = sqlite3_column_double(q, 5),
            .error_low = sqlite3_column_double(q, 6),
            .error_high = sqlite3_column_double(q, 7),
        };
        each(context, &p);
    }
    const bool ok = step == SQLITE_DONE || failed(s, err);
    sqlite3_finalize(q);
    return ok;
}
