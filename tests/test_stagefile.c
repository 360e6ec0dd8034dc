/* stagefile.c: a scene comes back from the cache as it was prepared or not at all; a full disk
 * costs the sharing, no more. What several processes do to each other is in test_claims.c.
 * SPDX-License-Identifier: MIT */
#include "worker/stagefile.h"

#include <fcntl.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include "common/clock.h"
#include "common/log.h"
#include "tests/shelf.h"
#include "tests/tap.h"

static struct shelf shelf;

/* ------------------------------------------------------------- the format */

/* What stagefile_check says of bytes at an address as mmap gives them; sanitizers see a byte too
 * far. */
static bool passes(const struct buf *file, size_t bytes, const char *name)
{
    const struct stage *found;
    struct err err;
    unsigned char *copy = NULL;
    if (posix_memalign((void **)&copy, 64, bytes ? bytes : 1))
        abort();
    memcpy(copy, file->data, bytes);
    const bool good = stagefile_check(copy, bytes, name, &found, &err);
    free(copy);
    return good;
}

static void bytes_are_checked(void)
{
    char name[CACHE_NAME], other[CACHE_NAME];
    stagefile_name(name, shelf_document(1));
    stagefile_name(other, shelf_document(2));
    struct buf file = shelf_file(shelf.stage, name);
    ok(passes(&file, file.size, name), "a file as it is written passes");
    ok(!passes(&file, file.size, other), "not as another scene's");
    int wrong = 0;
    for (size_t n = 0; n < file.size; n++)
        wrong += passes(&file, n, name);
    ok(wrong == 0, "cut off at any byte (of %zu) it is refused", file.size);
    buf_append(&file, "", 1);
    ok(!passes(&file, file.size, name), "with a byte more, too");
    file.size--;
    for (size_t n = 0; n < file.size; n++)
        for (unsigned bit = 1; bit < 256; bit <<= 7) {
            file.data[n] ^= (unsigned char)bit;
            wrong += passes(&file, file.size, name);
            file.data[n] ^= (unsigned char)bit;
        }
    ok(wrong == 0, "with any byte changed it is refused");
    buf_release(&file);
}

/* A block that is wrong in itself, in a file whose checksums are right. */
static bool block_passes(const unsigned char *block)
{
    char name[CACHE_NAME];
    stagefile_name(name, shelf_document(1));
    struct buf file = shelf_file((const struct stage *)(const void *)block, name);
    const bool good = passes(&file, file.size, name);
    buf_release(&file);
    return good;
}

static void blocks_are_checked(void)
{
    unsigned char *block = NULL;
    if (posix_memalign((void **)&block, 64, shelf.stage->bytes))
        abort();
    memcpy(block, shelf.stage, shelf.stage->bytes);
    struct stage *head = (struct stage *)(void *)block;
    ok(block_passes(block), "a block passes");
    head->version++;
    ok(!block_passes(block), "another version does not");
    head->version--;
    head->struct_bytes += 8;
    ok(!block_passes(block), "nor another struct stage");
    head->struct_bytes -= 8;
    head->magic[3] = 'X';
    ok(!block_passes(block), "nor another magic");
    memcpy(block, shelf.stage, shelf.stage->bytes);
    int wrong = 0, spans = 0;
    for (size_t at = offsetof(struct stage, shapes); at + sizeof(struct stage_span) <= sizeof *head;
         at += sizeof(struct stage_span), spans++) {
        struct stage_span span, bad;
        memcpy(&span, block + at, sizeof span);
        const struct stage_span all_bad[] = {{shelf.stage->bytes + 64, 0},
                                             {(uint64_t)-64, 1},
                                             {span.offset + 8, 0},
                                             {span.offset, shelf.stage->bytes},
                                             {span.offset, (uint64_t)1 << 62}};
        for (size_t i = 0; i < countof(all_bad); i++) {
            bad = all_bad[i];
            memcpy(block + at, &bad, sizeof bad);
            wrong += block_passes(block);
        }
        memcpy(block + at, &span, sizeof span);
    }
    ok(wrong == 0 && spans > 5, "each of its %d arrays must lie inside it, aligned", spans);
    free(block);
}

/* ---------------------------------------------------------------- one process */

static void comes_back(void)
{
    struct cache c = shelf_cache(&shelf, 1 << 20);
    struct stagefile f, again;
    struct stagefile_claim claim;
    struct err err;
    ok(shelf_get(&c, 1, SHELF_LONG_MS, &f, &claim) == STAGEFILE_CLAIMED,
       "who comes first is to prepare it");
    ok(stagefile_publish(&claim, shelf.stage, &f, &err) && shelf_same(&shelf, &f),
       "and gets it back mapped");
    ok(shelf_get(&c, 1, SHELF_LONG_MS, &again, &claim) == STAGEFILE_MAPPED &&
           shelf_same(&shelf, &again),
       "who comes next maps it");
    unlink(shelf_path(&shelf, 1));
    ok(shelf_same(&shelf, &again), "it stays when its file is deleted");
    stagefile_close(&f);
    stagefile_close(&again);
    ok(shelf_get(&c, 1, SHELF_LONG_MS, &f, &claim) == STAGEFILE_CLAIMED, "and is prepared again");
    stagefile_unclaim(&claim);
    ok(shelf_get(&c, 1, SHELF_LONG_MS, &f, &claim) == STAGEFILE_CLAIMED,
       "by the next when one cannot");
    stagefile_unclaim(&claim);
    ok(shelf_count(&shelf, ".") == 0, "nothing is left behind");
}

static bool maps_same(const struct cache *c, int n)
{
    struct stagefile f;
    struct stagefile_claim claim;
    const enum stagefile_answer answer = shelf_get(c, n, SHELF_LONG_MS, &f, &claim);
    const bool same = answer == STAGEFILE_MAPPED && shelf_same(&shelf, &f);
    if (answer == STAGEFILE_CLAIMED)
        stagefile_unclaim(&claim);
    stagefile_close(&f);
    return same;
}

static void write_at(int n, off_t at, const char *bytes)
{
    const int fd = open(shelf_path(&shelf, n), O_WRONLY);
    if (pwrite(fd, bytes, strlen(bytes), at) < 0)
        abort();
    close(fd);
}

static void damage_is_found(void)
{
    struct cache c = shelf_cache(&shelf, 1 << 20);
    struct stagefile f;
    const off_t whole = (off_t)(STAGEFILE_HEAD + shelf.stage->bytes);
    const off_t cuts[] = {0, 1, STAGEFILE_HEAD, STAGEFILE_HEAD + 1, whole - 1};
    int good = 0;
    for (size_t i = 0; i < countof(cuts); i++) {
        good += shelf_fill(&shelf, &c, 1, &f);
        stagefile_close(&f);
        good +=
            !truncate(shelf_path(&shelf, 1), cuts[i]) && !maps_same(&c, 1) && !shelf_has(&shelf, 1);
    }
    ok(good == 2 * countof(cuts), "a file that was cut off is deleted, not used");
    const off_t places[] = {0, 40, 200, STAGEFILE_HEAD + 40, whole - 9};
    good = 0;
    for (size_t i = 0; i < countof(places); i++) {
        good += shelf_fill(&shelf, &c, 1, &f);
        stagefile_close(&f);
        write_at(1, places[i], "damaged");
        good += !maps_same(&c, 1) && !shelf_has(&shelf, 1);
    }
    ok(good == 2 * countof(places), "nor one with other bytes in it");
    ok(shelf_fill(&shelf, &c, 1, &f) && maps_same(&c, 1), "and prepared again");
    stagefile_close(&f);
    chmod(shelf_path(&shelf, 1), 0620);
    ok(!maps_same(&c, 1), "a file that others can write is not used");
    unlink(shelf_path(&shelf, 1));
}

static void needs_a_cache(void)
{
    struct cache off = shelf_cache(&shelf, 0), none, small = shelf_cache(&shelf, STAGEFILE_HEAD);
    struct stagefile f;
    struct stagefile_claim claim;
    struct err err;
    ok(shelf_get(&off, 1, SHELF_LONG_MS, &f, &claim) == STAGEFILE_ALONE,
       "a cache of no bytes shares nothing");
    cache_init(&none, "/proc/nowhere", 1 << 20);
    ok(shelf_get(&none, 1, SHELF_LONG_MS, &f, &claim) == STAGEFILE_ALONE,
       "nor one without a directory");
    ok(shelf_get(&small, 1, SHELF_LONG_MS, &f, &claim) == STAGEFILE_CLAIMED &&
           !stagefile_publish(&claim, shelf.stage, &f, &err) && !f.stage && err.code == ERR_LIMIT,
       "nor is a block put into one that it does not fit in");
    ok(shelf_count(&shelf, ".") == 0, "nothing is left behind");
}

static void full_disk(void)
{
    struct cache c = shelf_cache(&shelf, 1 << 20);
    struct stagefile f;
    struct stagefile_claim claim;
    struct err err = {0};
    struct rlimit before, tight;
    getrlimit(RLIMIT_FSIZE, &before);
    tight = before;
    tight.rlim_cur = STAGEFILE_HEAD + 100;
    const enum stagefile_answer answer = shelf_get(&c, 1, SHELF_LONG_MS, &f, &claim);
    setrlimit(RLIMIT_FSIZE, &tight);
    const bool published = stagefile_publish(&claim, shelf.stage, &f, &err);
    setrlimit(RLIMIT_FSIZE, &before);
    ok(answer == STAGEFILE_CLAIMED && !published && !f.stage && err.code == ERR_IO,
       "a file that cannot be written whole is an error (%s)", err.text);
    ok(shelf_count(&shelf, ".") == 0, "of which nothing is left");
    ok(shelf_fill(&shelf, &c, 1, &f) && shelf_same(&shelf, &f), "later there may be room");
    stagefile_close(&f);
    unlink(shelf_path(&shelf, 1));
}

static void bound_holds(void)
{
    const uint64_t each = STAGEFILE_HEAD + shelf.stage->bytes;
    struct cache c = shelf_cache(&shelf, 3 * each + each / 2);
    struct stagefile f[5];
    char hex[HASH_HEX];
    for (int i = 0; i < 3; i++) {
        if (!shelf_fill(&shelf, &c, i, &f[i]))
            abort();
        const struct timespec times[2] = {{.tv_sec = clock_unix_ms() / 1000 - 1000 + i},
                                          {.tv_sec = clock_unix_ms() / 1000 - 1000 + i}};
        utimensat(AT_FDCWD, shelf_path(&shelf, i), times, 0);
    }
    stagefile_close(&f[1]);
    stagefile_close(&f[2]);
    ok(shelf_fill(&shelf, &c, 3, &f[3]) && shelf_has(&shelf, 0) && !shelf_has(&shelf, 1) &&
           shelf_has(&shelf, 2) && shelf_has(&shelf, 3),
       "the longest unused goes, but for one that is in use");
    stagefile_close(&f[0]);
    ok(shelf_fill(&shelf, &c, 4, &f[4]) && !shelf_has(&shelf, 0) && shelf_has(&shelf, 2),
       "which then goes first");
    hash_hex("tile", 4, hex);
    c.most_bytes = each;
    cache_put(&c, hex, "tile", 4);
    ok(shelf_count(&shelf, ".") == 1 && shelf_same(&shelf, &f[3]) && shelf_same(&shelf, &f[4]),
       "with no other way to make room those in use go, too, and stay mapped");
    stagefile_close(&f[3]);
    stagefile_close(&f[4]);
    c.most_bytes = 1 << 20;
    if (!shelf_fill(&shelf, &c, 5, &f[0]) || !shelf_fill(&shelf, &c, 6, &f[1]))
        abort();
    stagefile_close(&f[0]);
    stagefile_close(&f[1]);
    const struct timespec times[2] = {{.tv_sec = 1000}, {.tv_sec = 1000}};
    utimensat(AT_FDCWD, shelf_path(&shelf, 5), times, 0);
    cache_put(&c, hex, "tile", 4);
    ok(!shelf_has(&shelf, 5) && shelf_has(&shelf, 6),
       "what was not used for a month goes without need");
    unlink(shelf_path(&shelf, 6));
    char path[256];
    snprintf(path, sizeof path, "%s/%s", shelf.dir, hex);
    unlink(path);
}

int main(void)
{
    log_init("test_stagefile", LOG_ERROR);
    signal(SIGXFSZ, SIG_IGN);
    shelf_init(&shelf);
    bytes_are_checked();
    blocks_are_checked();
    comes_back();
    damage_is_found();
    needs_a_cache();
    full_disk();
    bound_holds();
    shelf_release(&shelf);
    return tap_done();
}
