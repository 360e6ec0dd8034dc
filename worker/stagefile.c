/* SPDX-License-Identifier: MIT */
#include "worker/stagefile.h"

#include <errno.h>
#include <poll.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/eventfd.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <xxhash.h>

#include "common/clock.h"
#include "common/log.h"
#include "common/trace/study.h"

enum {
    NAP_MS = 25,    /* between two looks at what another process prepares */
    PULSE_MS = 500, /* between two signs of life of who prepares */
};

/* ------------------------------------------------------------- the format */

static const char magic[8] = "SMSCENE";

enum { CHECKED = STAGEFILE_HEAD - 8 }; /* bytes of the head that its own checksum covers */

/* The Makefile makes it of the sources that have a part in the block: whatever is changed in them
 * makes another key, whether or not somebody thought of a version. */
#ifndef STAGEFILE_RECIPE
#error "STAGEFILE_RECIPE: a hash of common/ and common/trace/ (Makefile)"
#endif

void stagefile_name(char name[CACHE_NAME], const char document[HASH_HEX])
{
    char recipe[160], key[HASH_HEX];
    const int n = snprintf(recipe, sizeof recipe, "%d %d %zu %s", STAGEFILE_VERSION, STAGE_VERSION,
                           sizeof(struct stage), STAGEFILE_RECIPE);
    hash_hex(recipe, (size_t)n, key);
    cache_name(name, document, key);
}

void stagefile_head(struct buf *out, const char *name, const struct stage *block)
{
    const size_t begin = out->size;
    char padded[CACHE_NAME] = "";
    snprintf(padded, sizeof padded, "%s", name);
    buf_append(out, magic, sizeof magic);
    buf_u32(out, STAGEFILE_VERSION);
    buf_u32(out, STAGEFILE_HEAD);
    buf_u64(out, block->bytes);
    buf_u64(out, XXH3_64bits(block, block->bytes));
    buf_append(out, padded, sizeof padded);
    const size_t rest = CHECKED - (out->size - begin);
    memset(buf_grow(out, rest), 0, rest);
    buf_u64(out, XXH3_64bits(out->data + begin, CHECKED));
}

static bool check_sum(const unsigned char *bytes, size_t size, uint64_t want, const char *what,
                      struct err *err)
{
    return XXH3_64bits(bytes, size) == want || err_set(err, ERR_INPUT, "checksum of the %s", what);
}

bool stagefile_check(const void *file, size_t bytes, const char *name, const struct stage **stage,
                     struct err *err)
{
    const unsigned char *head = file;
    if (bytes <= STAGEFILE_HEAD || memcmp(head, magic, sizeof magic) != 0)
        return err_set(err, ERR_INPUT, "no file of a prepared scene");
    struct buf_reader r = buf_reader_make(head + sizeof magic, STAGEFILE_HEAD - sizeof magic);
    const uint32_t version = buf_read_u32(&r), head_bytes = buf_read_u32(&r);
    if (version != STAGEFILE_VERSION || head_bytes != STAGEFILE_HEAD)
        return err_set(err, ERR_INPUT, "version %u, expected %d", version, STAGEFILE_VERSION);
    const uint64_t block_bytes = buf_read_u64(&r), block_sum = buf_read_u64(&r);
    const char *its_name = buf_read(&r, CACHE_NAME);
    struct buf_reader sum = buf_reader_make(head + CHECKED, 8);
    if (!check_sum(head, CHECKED, buf_read_u64(&sum), "head", err))
        return false;
    if (strncmp(its_name, name, CACHE_NAME) != 0)
        return err_set(err, ERR_INPUT, "it was written as %.*s", CACHE_NAME - 1, its_name);
    if (block_bytes != bytes - STAGEFILE_HEAD)
        return err_set(err, ERR_INPUT, "%zu bytes, the head says %llu", bytes - STAGEFILE_HEAD,
                       (unsigned long long)block_bytes);
    const unsigned char *block = head + STAGEFILE_HEAD;
    if (!check_sum(block, block_bytes, block_sum, "block", err) ||
        !stage_check(block, block_bytes, err))
        return false;
    *stage = (const struct stage *)(const void *)block;
    return true;
}

/* ---------------------------------------------------------------- mapping */

/* ERR_NOT_FOUND: not here. ERR_INPUT: damaged. ERR_IO: it cannot be mapped now. */
static bool map_file(const struct cache *cache, const char *name, struct stagefile *f,
                     struct err *err)
{
    struct stat st;
    *f = (struct stagefile){.fd = cache_open(cache, name)};
    if (f->fd < 0)
        return err_set(err, ERR_NOT_FOUND, "not here");
    /* Nobody writes into a file that has its name, so it stays as long as it is now. */
    if (fstat(f->fd, &st))
        err_set(err, ERR_IO, "%s", strerror(errno));
    else if (st.st_size <= STAGEFILE_HEAD)
        err_set(err, ERR_INPUT, "%lld bytes", (long long)st.st_size);
    else
        f->map_bytes = (size_t)st.st_size;
    if (f->map_bytes) {
        f->map = mmap(NULL, f->map_bytes, PROT_READ, MAP_SHARED, f->fd, 0);
        if (f->map == MAP_FAILED) {
            f->map = NULL;
            err_set(err, ERR_IO, "%s", strerror(errno));
        }
    }
    if (f->map && stagefile_check(f->map, f->map_bytes, name, &f->stage, err)) {
        cache_keep(f->fd);
        return true;
    }
    stagefile_close(f);
    return false;
}

void stagefile_close(struct stagefile *f)
{
    if (f->map)
        munmap(f->map, f->map_bytes);
    if (f->map || f->fd > 0)
        close(f->fd);
    *f = (struct stagefile){0};
}

bool stagefile_set_method(struct stagefile *f, struct plan_method m, struct err *err)
{
    unsigned char *at = (unsigned char *)f->map + STAGEFILE_HEAD;
    const size_t page = (size_t)sysconf(_SC_PAGESIZE);
    const size_t bytes = (sizeof(struct stage) + page - 1) / page * page;
    if (STAGEFILE_HEAD % page || f->map_bytes < STAGEFILE_HEAD + sizeof(struct stage))
        return err_set(err, ERR_IO, "pages of %zu bytes", page);
    if (mmap(at, bytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_FIXED, f->fd, STAGEFILE_HEAD) ==
        MAP_FAILED)
        return err_set(err, ERR_IO, "%s", strerror(errno));
    struct stage *own = (struct stage *)(void *)at;
    study_set_method(own, own, m);
    if (mprotect(at, bytes, PROT_READ))
        return err_set(err, ERR_IO, "%s", strerror(errno));
    return true;
}

/* ----------------------------------------------------------------- claims */

/* The draft's time of change is the pulse that others feel. */
static void *run_pulse(void *user)
{
    const struct stagefile_claim *c = user;
    struct pollfd stop = {.fd = c->stop_fd, .events = POLLIN};
    while (poll(&stop, 1, PULSE_MS) <= 0)
        futimens(c->draft.fd, NULL);
    return NULL;
}

static void start_pulse(struct stagefile_claim *c)
{
    c->stop_fd = eventfd(0, EFD_CLOEXEC);
    if (c->stop_fd < 0 || pthread_create(&c->pulse, NULL, run_pulse, c))
        abort(); /* no thread: the machine is full */
}

static void stop_pulse(struct stagefile_claim *c)
{
    eventfd_write(c->stop_fd, 1);
    pthread_join(c->pulse, NULL);
    close(c->stop_fd);
}

/* The draft is ours. Meanwhile another process may have finished it, though. */
static enum stagefile_answer settle(struct stagefile_claim *c, struct stagefile *f)
{
    struct err err;
    if (map_file(c->cache, c->name, f, &err)) {
        cache_drop(&c->draft);
        return STAGEFILE_MAPPED;
    }
    if (err.code == ERR_INPUT) {
        log_warn("cache_damaged file=%s reason=\"%s\"", c->draft.path, err.text);
        unlink(c->draft.path); /* under the claim, so it is not the next one already */
    }
    start_pulse(c);
    return STAGEFILE_CLAIMED;
}

/* How long the process that prepares has shown no life, by our clock alone. */
struct silence {
    struct timespec pulse; /* its last, by the clock of the file system */
    int64_t since_ms;
};

static int64_t silence_ms(struct silence *s, const char *temp)
{
    struct stat st = {0};
    const int64_t now_ms = clock_ms();
    const bool alive = stat(temp, &st) || st.st_mtim.tv_sec != s->pulse.tv_sec ||
                       st.st_mtim.tv_nsec != s->pulse.tv_nsec;
    if (alive) {
        s->pulse = st.st_mtim;
        s->since_ms = now_ms;
    }
    return now_ms - s->since_ms;
}

enum stagefile_answer stagefile_get(const struct stagefile_ask *ask, struct stagefile *f,
                                    struct stagefile_claim *c)
{
    struct err err;
    struct silence silence = {.since_ms = clock_ms()};
    *c = (struct stagefile_claim){.cache = ask->cache};
    stagefile_name(c->name, ask->document);
    if (map_file(ask->cache, c->name, f, &err))
        return STAGEFILE_MAPPED;
    while (!atomic_load(ask->stopped)) {
        switch (cache_begin(ask->cache, c->name, &c->draft)) {
        case CACHE_BEGUN:
            return settle(c, f);
        case CACHE_OFF:
            return STAGEFILE_ALONE;
        case CACHE_BUSY:
            break;
        }
        if (silence_ms(&silence, c->draft.temp) > ask->patience_ms) {
            log_warn("scene_preparer_silent file=%s", c->draft.temp);
            return STAGEFILE_ALONE;
        }
        clock_sleep_ms(NAP_MS);
    }
    return STAGEFILE_ALONE;
}

void stagefile_unclaim(struct stagefile_claim *c)
{
    stop_pulse(c);
    cache_drop(&c->draft);
}

static bool write_block(struct stagefile_claim *c, const struct stage *stage, struct err *err)
{
    struct buf head = {0};
    stagefile_head(&head, c->name, stage);
    const bool good = cache_reserve(c->cache, &c->draft, head.size + stage->bytes, err) &&
                      cache_write(&c->draft, head.data, head.size, err) &&
                      cache_write(&c->draft, stage, stage->bytes, err);
    buf_release(&head);
    return good;
}

bool stagefile_publish(struct stagefile_claim *c, const struct stage *stage, struct stagefile *f,
                       struct err *err)
{
    if (!write_block(c, stage, err)) {
        stagefile_unclaim(c);
        return false;
    }
    stop_pulse(c);
    return cache_finish(&c->draft, err) && map_file(c->cache, c->name, f, err);
}
