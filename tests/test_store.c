/* store.c and checkpoint.c: what is written is read back; what is damaged is refused.
 * SPDX-License-Identifier: MIT */
#include "server/store.h"

#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include <sqlite3.h>

#include "common/buf.h"
#include "server/asset.h"
#include "server/checkpoint.h"
#include "server/disk.h"
#include "server/report.h"
#include "tests/fake_job.h"
#include "tests/tap.h"

static char dir[] = "/tmp/smalti-test-store-XXXXXX";
static char scratch[256];

static const char *path_of(const char *name)
{
    snprintf(scratch, sizeof scratch, "%s/%s", dir, name);
    return scratch;
}

/* ---- rows ---- */

struct seen {
    struct store_job jobs[4];
    size_t count;
};

static void note(void *context, const struct store_job *row)
{
    struct seen *s = context;
    if (s->count < countof(s->jobs))
        s->jobs[s->count++] = *row;
}

static struct store_job full_row(void)
{
    struct store_job row =
        fake_job_row(300, 200, (struct scene_target){.error = .0125, .spp = 77, .seconds = 2.5});
    row.id = 0xffffffffffffffff;
    row.crop = (struct tile_rect){10, 20, 110, 190};
    row.layers = LAYER_ALBEDO | 3 << 8;
    row.method = STORE_METHOD_PLANNED + PLAN_PATH_BSDF;
    row.state = JOB_PAUSED;
    row.priority = -100;
    row.settled = true;
    row.created_unix_ms = 1764000000000;
    row.started_unix_ms = 1764000000001;
    row.finished_unix_ms = 0;
    row.elapsed_ms = 123456;
    row.samples = (uint64_t)1 << 50;
    row.passes_done = 9;
    row.spp_done = 64;
    row.error = .25;
    row.cpu_us = 5;
    row.granted = 6;
    row.expired = 7;
    row.returned = 8;
    row.duplicates = 9;
    row.invalid_count = 3;
    row.key_count = 2;
    row.keys[0] = (struct film_key){1, 2, 3};
    row.keys[1] = (struct film_key){4, 5, 6};
    row.image_version = 11;
    row.stratified = true;
    row.report =
        (struct store_report){.1, .2, .3, .4, .5, .6, .7, {1, 2, 3, 4, 5, 6}, {6, 7}, 8, 9, .8, .9};
    hash_hex("x", 1, row.digest);
    row.checkpoint = 12;
    row.failure = (struct store_failure){.has_pass = true, .tile = 3, .pass = 2};
    snprintf(row.warnings, STORE_WARNINGS, "[{\"pointer\":\"/a\"}]");
    snprintf(row.failure.reason, STORE_REASON, "a 'quoted' reason, \xc3\xa4");
    return row;
}

static bool rows_equal(const struct store_job *a, const struct store_job *b)
{
    return a->id == b->id && a->number == b->number && !strcmp(a->document, b->document) &&
           !strcmp(a->title, b->title) && a->state == b->state && a->priority == b->priority &&
           a->width_px == b->width_px && a->height_px == b->height_px && a->tile_px == b->tile_px &&
           !memcmp(&a->crop, &b->crop, sizeof a->crop) && a->layers == b->layers &&
           a->method == b->method && a->target.error == b->target.error &&
           a->target.spp == b->target.spp && a->target.seconds == b->target.seconds &&
           a->settled == b->settled && a->stratified == b->stratified &&
           a->created_unix_ms == b->created_unix_ms && a->started_unix_ms == b->started_unix_ms &&
           a->finished_unix_ms == b->finished_unix_ms && a->elapsed_ms == b->elapsed_ms &&
           a->samples == b->samples && a->passes_done == b->passes_done &&
           a->spp_done == b->spp_done && a->error == b->error &&
           !memcmp(&a->report, &b->report, sizeof a->report) && a->cpu_us == b->cpu_us &&
           a->granted == b->granted && a->expired == b->expired && a->returned == b->returned &&
           a->duplicates == b->duplicates && a->invalid_count == b->invalid_count &&
           a->key_count == b->key_count &&
           !memcmp(a->keys, b->keys, a->key_count * sizeof a->keys[0]) &&
           a->image_version == b->image_version && !strcmp(a->digest, b->digest) &&
           a->checkpoint == b->checkpoint && !strcmp(a->failure.reason, b->failure.reason) &&
           a->failure.has_pass == b->failure.has_pass && a->failure.tile == b->failure.tile &&
           a->failure.pass == b->failure.pass && !strcmp(a->warnings, b->warnings);
}

static void rows(void)
{
    struct err err = {.text = ""};
    struct store *s = store_open(path_of("a.db"), &err);
    struct store_job full = full_row(), plain = fake_job_row(8, 8, (struct scene_target){.spp = 1});
    if (!ok(s != NULL, "a store opens where there was none %s", err.text))
        return;
    ok(store_job_add(s, &full, &err) && store_job_add(s, &plain, &err) && full.number == 1 &&
           plain.number == 2,
       "jobs are numbered in order of submission");
    struct store_job again = full;
    ok(!store_job_add(s, &again, &err) && err.code == ERR_IO, "an id is taken once: %s", err.text);
    plain.state = JOB_DONE;
    plain.samples = 64;
    ok(store_job_save(s, &plain, &err), "a row is saved");
    store_close(s);

    struct seen seen = {.count = 0};
    s = store_open(path_of("a.db"), &err);
    ok(s && store_jobs(s, note, &seen, &err) && seen.count == 2, "both are there after reopening");
    ok(rows_equal(&seen.jobs[0], &full), "every field comes back");
    ok(rows_equal(&seen.jobs[1], &plain), "and what was saved last");
    store_close(s);
}

/* A store as version 1 left it is taken over: its jobs have no layers, warnings or report, and
 * tiles that are whole blocks from now on. */
static void former_version(void)
{
    struct err err = {.text = ""};
    struct store *s = store_open(path_of("v1.db"), &err);
    struct store_job row = full_row();
    ok(s && store_job_add(s, &row, &err), "a store to be made old %s", err.text);
    store_close(s);
    sqlite3 *db = NULL;
    ok(sqlite3_open(path_of("v1.db"), &db) == SQLITE_OK &&
           sqlite3_exec(db,
                        "ALTER TABLE job DROP COLUMN error_low;"
                        "ALTER TABLE job DROP COLUMN error_high;"
                        "ALTER TABLE job DROP COLUMN unknown;"
                        "ALTER TABLE job DROP COLUMN heavy;"
                        "ALTER TABLE job DROP COLUMN energy;"
                        "ALTER TABLE job DROP COLUMN clamped;"
                        "ALTER TABLE job DROP COLUMN cut;"
                        "ALTER TABLE job DROP COLUMN camera_rays;"
                        "ALTER TABLE job DROP COLUMN bounce_rays;"
                        "ALTER TABLE job DROP COLUMN shadow_rays;"
                        "ALTER TABLE job DROP COLUMN plain_vertices;"
                        "ALTER TABLE job DROP COLUMN other_vertices;"
                        "ALTER TABLE job DROP COLUMN units;"
                        "ALTER TABLE job DROP COLUMN degenerate;"
                        "ALTER TABLE job DROP COLUMN nonfinite;"
                        "ALTER TABLE job DROP COLUMN warnings;"
                        "ALTER TABLE job DROP COLUMN method;"
                        "ALTER TABLE job DROP COLUMN stratified;"
                        "ALTER TABLE job DROP COLUMN spp_least;"
                        "ALTER TABLE job DROP COLUMN spp_most;"
                        "ALTER TABLE job DROP COLUMN spp_mean;"
                        "ALTER TABLE job DROP COLUMN stopped;"
                        "DROP TABLE point; ALTER TABLE job DROP COLUMN layers; UPDATE job SET "
                        "tile_px = 33; PRAGMA "
                        "user_version = 1",
                        NULL, NULL, NULL) == SQLITE_OK,
       "it becomes one of version 1");
    sqlite3_close(db);
    struct seen seen = {.count = 0};
    s = store_open(path_of("v1.db"), &err);
    row.layers = row.method = 0;
    row.tile_px = 40;
    row.report = report_none();
    row.report.spp_least = row.report.spp_most = row.spp_done;
    row.report.spp_mean = row.spp_done;
    *row.warnings = '\0';
    row.stratified = false;
    ok(s && store_jobs(s, note, &seen, &err) && seen.count == 1 && rows_equal(&seen.jobs[0], &row),
       "and is read by this one %s", err.text);
    store_close(s);
}

static void damaged(void)
{
    struct err err = {.text = ""};
    FILE *f = fopen(path_of("b.db"), "wb");
    fputs("this is not a database, however one looks at it, and it is long enough", f);
    fclose(f);
    ok(!store_open(path_of("b.db"), &err), "what is not a store is refused: %s", err.text);

    struct store *s = store_open(path_of("c.db"), &err);
    struct store_job row = fake_job_row(8, 8, (struct scene_target){.spp = 1});
    row.tile_px = 0; /* would divide by zero later */
    struct seen seen = {.count = 0};
    ok(store_job_add(s, &row, &err) && !store_jobs(s, note, &seen, &err) && seen.count == 0,
       "a row that makes no sense is refused: %s", err.text);
    store_close(s);
}

/* ---- films ---- */

enum { WIDTH = 20, HEIGHT = 17, TILES = 9 };

static struct checkpoint expect(const struct store_job *row)
{
    return (struct checkpoint){.row = *row, .tile_count = TILES};
}

/* Of two judged rounds. */
static void records_make(struct checkpoint *c)
{
    c->rounds_judged = 2;
    adaptive_init(&c->adaptive, c->row.crop);
    adaptive_resize(&c->adaptive, 2);
    c->adaptive.least = .0123;
    c->adaptive.spp[0] = 8;
    c->adaptive.spp[1] = 16;
    for (size_t i = 0; i < 2 * c->adaptive.count; i++)
        c->adaptive.blocks[i] = (struct adaptive_block){(float)i / 7, (float)i - 5};
}

static bool records_equal(const struct adaptive *a, const struct adaptive *b)
{
    return a->count == b->count && a->rounds == b->rounds && a->least == b->least &&
           !memcmp(a->spp, b->spp, a->rounds * sizeof *a->spp) &&
           !memcmp(a->blocks, b->blocks, a->rounds * a->count * sizeof *a->blocks);
}

static struct checkpoint made(uint32_t layers)
{
    struct arena arena = {0};
    struct job *j = fake_job_open(WIDTH, HEIGHT, (struct scene_target){.spp = 64});
    struct checkpoint c = expect(&j->row);
    film_init(&c.film, j->row.crop);
    film_add_layers(&c.film, layers);
    c.row.layers = layers;
    records_make(&c);
    for (uint32_t t = 0; t < TILES; t++)
        for (uint32_t p = 0; p < t % 4; p++) {
            struct wire_samples w = fake_job_payload(j, t, p, .3f, &arena);
            film_samples_add_layers(&w.samples, layers, &arena);
            for (uint32_t i = 0; i < tile_rect_pixels(w.samples.rect) * layers_channels(layers);
                 i++)
                w.samples.layer_sums[i] = (float)i - 7;
            film_samples_note_invalid(&w.samples, (struct film_key){w.samples.rect.x_begin, t, p});
            film_merge(&c.film, &w.samples);
        }
    c.row.samples = 4711;
    c.row.passes_done = 12;
    c.row.cpu_us = 99;
    c.row.elapsed_ms = 1234;
    c.generation = 3;
    arena_release(&arena);
    job_free(j);
    return c;
}

static void films(uint32_t layers)
{
    struct err err = {.text = ""};
    struct checkpoint c = made(layers), back = expect(&c.row);
    back.row.samples = back.row.cpu_us = 0;
    const size_t pixels = WIDTH * HEIGHT;
    unlink(path_of("film"));
    ok(!checkpoint_read(&back, path_of("film"), &err) && err.code == ERR_NOT_FOUND,
       "no film yet: %s", err.text);
    ok(checkpoint_write(&c, path_of("film"), &err), "a film is written %s", err.text);
    if (!ok(checkpoint_read(&back, path_of("film"), &err), "and read back %s", err.text))
        return;
    ok(!memcmp(back.film.sum, c.film.sum, pixels * 3 * sizeof *c.film.sum) &&
           !memcmp(back.film.replicate, c.film.replicate,
                   pixels * FILM_CHANNELS * sizeof *c.film.replicate) &&
           !memcmp(back.film.spp, c.film.spp, pixels * sizeof *c.film.spp) &&
           back.rounds_judged == c.rounds_judged && records_equal(&back.adaptive, &c.adaptive) &&
           (!layers || !memcmp(back.film.layer, c.film.layer,
                               pixels * layers_channels(layers) * sizeof *c.film.layer)),
       "bit for bit%s", layers ? ", with its layers" : "");
    ok(back.row.samples == 4711 && back.row.passes_done == 12 && back.row.cpu_us == 99 &&
           back.row.elapsed_ms == 1234 && back.generation == 3,
       "with its counters");
    ok(back.film.invalid_count == c.film.invalid_count && back.row.key_count == c.film.key_count &&
           !memcmp(back.row.keys, c.film.keys, c.film.key_count * sizeof c.film.keys[0]),
       "and the keys of invalid samples");
    checkpoint_release(&back);

    struct checkpoint other = expect(&c.row);
    other.row.id++;
    ok(!checkpoint_read(&other, path_of("film"), &err) && err.code == ERR_INPUT,
       "another job's film is refused: %s", err.text);
    other = expect(&c.row);
    other.row.layers ^= LAYER_NORMAL;
    ok(!checkpoint_read(&other, path_of("film"), &err) && err.code == ERR_INPUT,
       "one with other layers is refused: %s", err.text);
    other = expect(&c.row);
    other.row.target.spp = 16; /* merged passes beyond the job's end */
    ok(!checkpoint_read(&other, path_of("film"), &err) && err.code == ERR_INPUT,
       "so is one with passes that the job has not: %s", err.text);
    checkpoint_release(&c);
}

static bool still_read(const struct store_job *row, const char *path)
{
    struct err err;
    struct checkpoint c = expect(row);
    if (!checkpoint_read(&c, path, &err))
        return false;
    checkpoint_release(&c);
    return true;
}

static void put(const char *path, const struct buf *bytes, size_t n)
{
    FILE *f = fopen(path, "wb");
    fwrite(bytes->data, 1, n, f);
    fclose(f);
}

/* The same film as version 3 wrote it: with passes per tile, without records. */
static void former_film(void)
{
    struct err err = {.text = ""};
    struct buf new = {0}, old = {0};
    struct checkpoint c = made(0);
    const size_t head = 96 + 12 * c.film.key_count + sizeof c.film.work + sizeof c.film.dropped;
    const size_t records = 8 + 8 + 2 * 4 + 2 * 8 * c.adaptive.count;
    const uint32_t version = 3;
    char hex[HASH_HEX];
    if (!ok(checkpoint_write(&c, path_of("film"), &err) &&
                buf_read_file(&new, path_of("film"), 1 << 24, &err),
            "a film to be made old %s", err.text))
        return;
    buf_append(&old, new.data, head);
    memcpy(old.data + 8, &version, sizeof version);
    for (uint32_t t = 0; t < TILES; t++)
        buf_u32(&old, t % 4);
    buf_append(&old, new.data + head, new.size - head - records - 64);
    hash_hex(old.data, old.size, hex);
    buf_append(&old, hex, 64);
    put(path_of("film"), &old, old.size);
    struct checkpoint back = expect(&c.row);
    if (ok(checkpoint_read(&back, path_of("film"), &err), "a film of version 3 is read %s",
           err.text)) {
        ok(!memcmp(back.film.spp, c.film.spp, WIDTH * HEIGHT * sizeof *c.film.spp) &&
               back.adaptive.rounds == 0 && back.rounds_judged == 0,
           "with its samples, and nothing of rounds");
        checkpoint_release(&back);
    }
    back = expect(&c.row);
    back.row.target.error = .1;
    ok(!checkpoint_read(&back, path_of("film"), &err) && err.code == ERR_INPUT,
       "but not for a job with an error target: %s", err.text);
    new.data[8] = 4; /* the same, but that blocks have stopped by another rule */
    hash_hex(new.data, new.size - 64, hex);
    memcpy(new.data + new.size - 64, hex, 64);
    put(path_of("film"), &new, new.size);
    ok(still_read(&c.row, path_of("film")), "a film of version 4 is read");
    c.row.target.error = .1;
    ok(!still_read(&c.row, path_of("film")), "but not for a job with an error target");
    buf_release(&new);
    buf_release(&old);
    checkpoint_release(&c);
}

static void broken_films(void)
{
    struct err err;
    struct buf bytes = {0};
    struct checkpoint c = made(LAYER_DEPTH);
    if (!checkpoint_write(&c, path_of("film"), &err) ||
        !buf_read_file(&bytes, path_of("film"), 1 << 24, &err)) {
        ok(false, "%s", err.text);
        return;
    }
    const char *path = path_of("film");
    bool refused = true;
    for (size_t n = 0; n < bytes.size; n += 1 + n / 50) {
        put(path, &bytes, n);
        refused &= !still_read(&c.row, path);
    }
    ok(refused, "a film cut short anywhere is refused");
    refused = true;
    for (size_t at = 0; at < bytes.size; at += 1 + at / 50) {
        bytes.data[at] ^= 0x10;
        put(path, &bytes, bytes.size);
        refused &= !still_read(&c.row, path);
        bytes.data[at] ^= 0x10;
    }
    ok(refused, "and one with a flipped bit");
    buf_append(&bytes, "x", 1);
    put(path, &bytes, bytes.size);
    ok(!still_read(&c.row, path), "and one with a byte too many");
    put(path, &bytes, bytes.size - 1);
    ok(still_read(&c.row, path), "the whole one is taken");
    buf_release(&bytes);
    checkpoint_release(&c);
}

/* ---- files ---- */

static void files(void)
{
    struct err err;
    struct disk_file f;
    struct stat st;
    ok(disk_directory(path_of("x/y/z"), &err) && disk_directory(path_of("x/y/z"), &err),
       "a directory is made with its parents, once");
    put(path_of("plain"), &(struct buf){(unsigned char *)dir, 1, 1}, 1);
    ok(!disk_directory(path_of("plain/x"), &err), "not under a file: %s", err.text);
    ok(disk_create(&f, path_of("whole"), &err) && disk_write(&f, "abc", 3, &err) &&
           stat(path_of("whole"), &st) != 0,
       "a file is not seen before it is whole");
    ok(disk_commit(&f, &err) && stat(path_of("whole"), &st) == 0 && st.st_size == 3, "then it is");
    if (disk_create(&f, path_of("whole"), &err) && disk_write(&f, "nothing", 7, &err))
        disk_abort(&f);
    ok(stat(f.temporary, &st) != 0 && stat(path_of("whole"), &st) == 0 && st.st_size == 3,
       "giving up leaves the old one and no trace");
    ok(disk_create(&f, path_of("whole"), &err), "a crash leaves a temporary");
    close(f.fd);
    disk_clean(dir);
    ok(stat(f.temporary, &st) != 0 && stat(path_of("whole"), &st) == 0, "which is cleaned up");
    ok(disk_lock(path_of("lock"), &err) && !disk_lock(path_of("lock"), &err) &&
           err.code == ERR_CONFLICT,
       "a state directory belongs to one: %s", err.text);
}

static void full_disk(void)
{
    struct err err = {.text = ""};
    struct disk_file f = {.fd = open("/dev/full", O_WRONLY), .path = "film", .temporary = "none"};
    if (f.fd < 0) {
        skip("no /dev/full here");
        return;
    }
    ok(!disk_write(&f, "x", 1, &err) && err.code == ERR_IO, "a full disk is an error: %s",
       err.text);
    close(f.fd);
}

static void assets(void)
{
    struct err err;
    char hex[HASH_HEX];
    uint64_t bytes;
    ok(asset_open_store(dir, &err), "assets have a place");
    struct asset_spool *s = asset_spool_new(&err), *dropped = asset_spool_new(&err);
    ok(s && asset_spool_add(s, "ab", 2, &err) && asset_spool_add(s, "c", 1, &err) &&
           asset_spool_finish(s, &err) &&
           !strcmp(s->hex, "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad"),
       "a spool knows the hash of its bytes");
    ok(!asset_exists(s->hex) && asset_adopt(s, &err) && asset_exists(s->hex), "and gets its name");
    const int fd = asset_fd(s->hex, &bytes);
    ok(fd >= 0 && bytes == 3, "an asset is read");
    close(fd);
    memcpy(hex, s->hex, sizeof hex);
    asset_spool_free(s);
    ok(asset_exists(hex), "and outlives its spool");
    ok(dropped && asset_spool_add(dropped, "xyz", 3, &err), "one that is broken off");
    struct stat st;
    const struct disk_file gone = dropped->file;
    asset_spool_free(dropped);
    ok(stat(gone.temporary, &st) != 0, "leaves nothing");
    ok(asset_put("abc", 3, hex, &err) && asset_exists(hex), "bytes that are here stay as they are");
}

int main(void)
{
    if (!mkdtemp(dir))
        return 1;
    rows();
    former_version();
    damaged();
    films(0);
    films(LAYER_POSITION | 2 << 8);
    former_film();
    broken_films();
    files();
    full_disk();
    assets();
    char command[300];
    snprintf(command, sizeof command, "rm -rf %s", dir);
    return tap_done() || system(command);
}
