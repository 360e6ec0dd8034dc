/* SPDX-License-Identifier: MIT */
#include "server/checkpoint.h"

#include <assert.h>
#include <errno.h>
#include <fcntl.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "common/buf.h"
#include "server/disk.h"

enum { VERSION_UNIFORM = 3, VERSION = 5, STEP = 1 << 20 };

static const char magic[8] = {'S', 'M', 'L', 'T', 'F', 'I', 'L', 'M'};

_Static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__, "arrays are written as they lie");

/* ---- the parts, in file order ---- */

_Static_assert(sizeof(struct block) == 5 * 8 + BLOCK_TOP * 4, "no padding in blocks");
_Static_assert(sizeof(struct film_work) == 6 * 8 && sizeof(struct film_dropped) == 2 * 4,
               "nor in these");
_Static_assert(sizeof(struct adaptive_block) == 2 * 4, "nor in these");

static void head_write(const struct checkpoint *c, struct buf *out)
{
    const struct store_job *row = &c->row;
    const struct tile_rect w = row->crop;
    buf_append(out, magic, sizeof magic);
    buf_u32(out, VERSION);
    buf_u32(out, c->tile_count);
    buf_u64(out, row->id);
    buf_u64(out, c->generation);
    const uint32_t shape[] = {w.x_begin, w.y_begin,    w.x_end,
                              w.y_end,   row->tile_px, c->film.key_count};
    for (size_t i = 0; i < countof(shape); i++)
        buf_u32(out, shape[i]);
    const uint64_t counters[] = {row->samples, row->passes_done, row->cpu_us, c->film.invalid_count,
                                 (uint64_t)row->elapsed_ms};
    for (size_t i = 0; i < countof(counters); i++)
        buf_u64(out, counters[i]);
    for (uint32_t i = 0; i < c->film.key_count; i++) {
        buf_u32(out, c->film.keys[i].x_px);
        buf_u32(out, c->film.keys[i].y_px);
        buf_u32(out, c->film.keys[i].sample);
    }
}

enum { HEAD_BYTES = 8 + 4 + 4 + 8 + 8 + 6 * 4 + 5 * 8, ARRAYS = 9, RECORDS = 5 };

struct span {
    void *data;
    size_t bytes;
};

static void arrays_of(struct checkpoint *c, struct span out[ARRAYS])
{
    struct film *f = &c->film;
    const size_t pixels = tile_rect_pixels(c->row.crop), blocks = block_count(c->row.crop);
    const size_t channels = layers_channels(c->row.layers);
    const struct span all[ARRAYS] = {
        {&f->work, sizeof f->work},
        {&f->dropped, sizeof f->dropped},
        {f->sum, pixels * 3 * sizeof *f->sum},
        {f->replicate, pixels * FILM_CHANNELS * sizeof *f->replicate},
        {f->spp, pixels * sizeof *f->spp},
        {&f->layers, sizeof f->layers},
        {f->layer, pixels * channels * sizeof *f->layer},
        {f->blocks, blocks * sizeof *f->blocks},
        {f->variance, blocks * BLOCK_DOUBLINGS * sizeof *f->variance},
    };
    memcpy(out, all, sizeof all);
}

/* Once a->rounds is known: all but the first two. */
static void records_of(struct checkpoint *c, struct span out[RECORDS])
{
    struct adaptive *a = &c->adaptive;
    const struct span all[RECORDS] = {
        {&c->rounds_judged, sizeof c->rounds_judged},
        {&a->rounds, sizeof a->rounds},
        {&a->least, sizeof a->least},
        {a->spp, a->rounds * sizeof *a->spp},
        {a->blocks, a->rounds * a->count * sizeof *a->blocks},
    };
    memcpy(out, all, sizeof all);
}

/* ---- writing ---- */

static bool put(struct disk_file *f, struct hash *h, const void *data, size_t bytes,
                struct err *err)
{
    if (!bytes) /* the layers of a film that has none */
        return true;
    hash_add(h, data, bytes);
    return disk_write(f, data, bytes, err);
}

static bool write_all(struct checkpoint *c, struct disk_file *f, struct err *err)
{
    struct buf head = {0};
    struct span arrays[ARRAYS + RECORDS];
    struct hash *h = hash_new();
    char hex[HASH_HEX];
    head_write(c, &head);
    arrays_of(c, arrays);
    records_of(c, arrays + ARRAYS);
    bool ok = put(f, h, head.data, head.size, err);
    for (size_t i = 0; ok && i < countof(arrays); i++)
        ok = put(f, h, arrays[i].data, arrays[i].bytes, err);
    buf_release(&head);
    hash_finish(h, hex);
    return ok && disk_write(f, hex, HASH_HEX - 1, err);
}

bool checkpoint_write(struct checkpoint *c, const char *path, struct err *err)
{
    struct disk_file f;
    if (!disk_create(&f, path, err))
        return false;
    if (!write_all(c, &f, err)) {
        disk_abort(&f);
        return false;
    }
    return disk_commit(&f, err);
}

/* ---- reading ---- */

struct source {
    int fd;
    const char *path;
    struct hash *hash;
    uint32_t version;
};

static bool get(struct source *s, void *data, size_t bytes, struct err *err)
{
    char *at = data;
    while (bytes) {
        const ssize_t n = read(s->fd, at, min_size(bytes, STEP));
        if (n < 0 && errno == EINTR)
            continue;
        if (n <= 0)
            return n < 0 ? err_set(err, ERR_IO, "%s: %s", s->path, strerror(errno))
                         : err_set(err, ERR_INPUT, "%s: film is cut short", s->path);
        hash_add(s->hash, at, (size_t)n);
        at += n;
        bytes -= (size_t)n;
    }
    return true;
}

static bool read_head(struct source *s, struct checkpoint *c, struct err *err)
{
    unsigned char bytes[HEAD_BYTES];
    if (!get(s, bytes, sizeof bytes, err))
        return false;
    struct buf_reader r = buf_reader_make(bytes, sizeof bytes);
    struct store_job *row = &c->row;
    const struct tile_rect w = row->crop;
    bool ok = !memcmp(buf_read(&r, sizeof magic), magic, sizeof magic);
    s->version = buf_read_u32(&r);
    ok &= s->version >= VERSION_UNIFORM && s->version <= VERSION;
    ok &= buf_read_u32(&r) == c->tile_count;
    ok &= buf_read_u64(&r) == row->id;
    c->generation = buf_read_u64(&r);
    const uint32_t shape[] = {w.x_begin, w.y_begin, w.x_end, w.y_end, row->tile_px};
    for (size_t i = 0; i < countof(shape); i++)
        ok &= buf_read_u32(&r) == shape[i];
    c->film.key_count = buf_read_u32(&r);
    row->samples = buf_read_u64(&r);
    row->passes_done = buf_read_u64(&r);
    row->cpu_us = buf_read_u64(&r);
    c->film.invalid_count = buf_read_u64(&r);
    row->elapsed_ms = (int64_t)buf_read_u64(&r);
    assert(!r.failed && r.at == r.end);
    ok &= c->film.key_count <= FILM_MAX_KEYS;
    if (ok && s->version < VERSION && row->target.error > 0)
        return err_set(err, ERR_INPUT, "%s: a film of version %u went by another rule", s->path,
                       s->version);
    return ok || err_set(err, ERR_INPUT, "%s: not a film of this job", s->path);
}

static bool read_keys(struct source *s, struct checkpoint *c, struct err *err)
{
    unsigned char bytes[FILM_MAX_KEYS * 12];
    const size_t n = c->film.key_count * (size_t)12;
    if (!get(s, bytes, n, err))
        return false;
    struct buf_reader r = buf_reader_make(bytes, n);
    for (uint32_t i = 0; i < c->film.key_count; i++) {
        c->film.keys[i].x_px = buf_read_u32(&r);
        c->film.keys[i].y_px = buf_read_u32(&r);
        c->film.keys[i].sample = buf_read_u32(&r);
    }
    return true;
}

static bool read_close(struct source *s, struct err *err)
{
    char want[HASH_HEX] = {0}, have[HASH_HEX], extra;
    hash_finish(s->hash, have);
    s->hash = hash_new(); /* the digits themselves do not count */
    if (!get(s, want, HASH_HEX - 1, err))
        return false;
    if (strcmp(want, have) != 0 || read(s->fd, &extra, 1) != 0)
        return err_set(err, ERR_INPUT, "%s: film is damaged", s->path);
    return true;
}

static bool get_spans(struct source *s, const struct span *spans, size_t count, struct err *err)
{
    for (size_t i = 0; i < count; i++)
        if (!get(s, spans[i].data, spans[i].bytes, err))
            return false;
    return true;
}

/* What version 3 has in between follows from spp. */
static bool read_merged(struct source *s, const struct checkpoint *c, struct err *err)
{
    uint32_t merged;
    for (uint32_t i = 0; s->version == VERSION_UNIFORM && i < c->tile_count; i++)
        if (!get(s, &merged, sizeof merged, err))
            return false;
    return true;
}

static bool read_records(struct source *s, struct checkpoint *c, struct err *err)
{
    struct span all[RECORDS];
    if (s->version == VERSION_UNIFORM)
        return true;
    records_of(c, all);
    if (!get_spans(s, all, 2, err))
        return false;
    const uint32_t rounds = c->adaptive.rounds;
    if (rounds > ADAPTIVE_MAX_ROUNDS) {
        c->adaptive.rounds = 0;
        return err_set(err, ERR_INPUT, "%s: %u rounds: expected at most %d", s->path, rounds,
                       ADAPTIVE_MAX_ROUNDS);
    }
    adaptive_resize(&c->adaptive, rounds);
    records_of(c, all);
    return get_spans(s, all + 2, RECORDS - 2, err);
}

/* What film_merge asserts: blocks of equally many samples, whole passes of the job. */
static bool block_agrees(const struct checkpoint *c, size_t block)
{
    const struct tile_rect w = c->row.crop, r = block_rect_of(w, block);
    const uint32_t *spp = c->film.spp, most = c->row.target.spp;
    const size_t width = w.x_end - w.x_begin;
    const uint32_t n = spp[(r.y_begin - w.y_begin) * width + (r.x_begin - w.x_begin)];
    for (uint32_t y = r.y_begin; y < r.y_end; y++)
        for (uint32_t x = r.x_begin; x < r.x_end; x++)
            if (spp[(y - w.y_begin) * width + (x - w.x_begin)] != n)
                return false;
    return n <= most && (n == 0 || tile_pass_of(tile_pass_count(n) - 1, most).s_end == n);
}

static bool check_all(const struct source *s, const struct checkpoint *c, struct err *err)
{
    if (c->film.layers != c->row.layers)
        return err_set(err, ERR_INPUT, "%s: the film's layers are not the job's", s->path);
    bool agree = c->rounds_judged <= tile_pass_count(c->row.target.spp);
    for (size_t i = 0; agree && i < block_count(c->row.crop); i++)
        agree = block_agrees(c, i);
    if (!agree)
        return err_set(err, ERR_INPUT, "%s: the film's samples are not of the job's passes",
                       s->path);
    return adaptive_check(&c->adaptive, err) || err_at(err, "%s", s->path);
}

static bool read_all(struct source *s, struct checkpoint *c, struct err *err)
{
    struct span arrays[ARRAYS];
    if (!read_head(s, c, err) || !read_keys(s, c, err))
        return false;
    arrays_of(c, arrays);
    return get_spans(s, arrays, 2, err) && read_merged(s, c, err) &&
           get_spans(s, arrays + 2, ARRAYS - 2, err) && read_records(s, c, err) &&
           read_close(s, err) && check_all(s, c, err);
}

bool checkpoint_read(struct checkpoint *c, const char *path, struct err *err)
{
    struct source s = {.fd = open(path, O_RDONLY | O_CLOEXEC), .path = path};
    if (s.fd < 0)
        return err_set(err, errno == ENOENT ? ERR_NOT_FOUND : ERR_IO, "%s: %s", path,
                       strerror(errno));
    const struct store_job expected = c->row;
    char unused[HASH_HEX];
    film_init(&c->film, c->row.crop);
    film_add_layers(&c->film, c->row.layers);
    adaptive_init(&c->adaptive, c->row.crop);
    c->rounds_judged = 0;
    s.hash = hash_new();
    const bool ok = read_all(&s, c, err);
    hash_finish(s.hash, unused);
    close(s.fd);
    if (!ok) {
        checkpoint_release(c);
        c->row = expected;
        return false;
    }
    c->row.invalid_count = c->film.invalid_count;
    c->row.key_count = c->film.key_count;
    memcpy(c->row.keys, c->film.keys, sizeof c->row.keys);
    return true;
}

void checkpoint_release(struct checkpoint *c)
{
    film_release(&c->film);
    adaptive_release(&c->adaptive);
}
