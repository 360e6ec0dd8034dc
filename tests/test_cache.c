/* cache.c: what comes out is what was put in or nothing; one process writes a file at a time; the
 * bound holds; other files are left alone.
 * SPDX-License-Identifier: MIT */
#include "worker/cache.h"

#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "common/clock.h"
#include "common/log.h"
#include "tests/tap.h"

static char dir[64];

static const char *file_in(const char *name)
{
    static char path[256];
    snprintf(path, sizeof path, "%s/%s", dir, name);
    return path;
}

static bool is_there(const char *name)
{
    return access(file_in(name), F_OK) == 0;
}

static void set_age(const char *name, time_t seconds)
{
    const struct timespec times[2] = {{.tv_sec = seconds}, {.tv_sec = seconds}};
    utimensat(AT_FDCWD, file_in(name), times, 0);
}

static void write_file(const char *name, const char *text)
{
    FILE *f = fopen(file_in(name), "wb");
    fputs(text, f);
    fclose(f);
}

static bool gives(const struct cache *c, const char *hex, const char *text)
{
    struct buf out = {0};
    const bool found = cache_get(c, hex, 1000, &out);
    const bool same = found && out.size == strlen(text) && !memcmp(out.data, text, out.size);
    const bool clean = found || out.size == 0;
    buf_release(&out);
    return same && clean;
}

static void out_comes_what_went_in(const struct cache *c)
{
    char hex[HASH_HEX];
    struct buf out = {0};
    hash_hex("tile", 4, hex);
    ok(!cache_get(c, hex, 1000, &out) && !out.size, "what was never put in is not there");
    cache_put(c, hex, "tile", 4);
    ok(gives(c, hex, "tile"), "an asset comes back");
    ok(!cache_get(c, hex, 3, &out), "not when it is larger than allowed");
    buf_release(&out);
    write_file(hex, "till");
    ok(!gives(c, hex, "till") && !is_there(hex), "a damaged file is not used, and deleted");
    cache_put(c, hex, "tile", 4);
    ok(gives(c, hex, "tile"), "and can be put in again");
}

static void bound_holds(void)
{
    struct cache c;
    char hex[3][HASH_HEX];
    static const char *const texts[] = {"aaaaaaaaaa", "bbbbbbbbbb", "cccccccccc"};
    cache_init(&c, dir, 25);
    for (int i = 0; i < 3; i++)
        hash_hex(texts[i], 10, hex[i]);
    write_file("someone-elses", "a file that has nothing to do with us");
    write_file(".tmp-someone-elses", "likewise");
    char dead[HASH_HEX], temp[CACHE_NAME];
    hash_hex("dead", 4, dead);
    snprintf(temp, sizeof temp, ".tmp-%s", dead);
    write_file(temp, "of a process that died");
    cache_put(&c, hex[0], texts[0], 10);
    cache_put(&c, hex[1], texts[1], 10);
    set_age(hex[0], 2000);
    set_age(hex[1], 1000);
    ok(gives(&c, hex[1], texts[1]), "reading makes an old asset young");
    cache_put(&c, hex[2], texts[2], 10);
    ok(!is_there(hex[0]), "the one unused for longest goes");
    ok(gives(&c, hex[1], texts[1]) && gives(&c, hex[2], texts[2]), "the others stay");
    ok(is_there("someone-elses") && is_there(".tmp-someone-elses"),
       "files that are not ours are left alone");
    ok(!is_there(temp), "but what a dead process left is removed");
    char large[64];
    memset(large, 'x', sizeof large);
    hash_hex(large, sizeof large, hex[0]);
    cache_put(&c, hex[0], large, sizeof large);
    ok(!is_there(hex[0]) && is_there(hex[2]), "what is larger than the bound pushes nothing out");
}

static bool write_made(const struct cache *c, const char *name, const char *text)
{
    struct cache_draft d;
    struct err err;
    if (cache_begin(c, name, &d) != CACHE_BEGUN)
        return false;
    if (cache_reserve(c, &d, strlen(text), &err) && cache_write(&d, text, strlen(text), &err))
        return cache_finish(&d, &err);
    cache_drop(&d);
    return false;
}

static void drafts_are_ours_alone(void)
{
    struct cache c;
    struct cache_draft mine, other;
    struct err err;
    char hex[HASH_HEX], name[CACHE_NAME], temp[CACHE_NAME + 8];
    cache_init(&c, dir, 1000);
    hash_hex("document", 8, hex);
    cache_name(name, hex, "0123456789abcdef");
    snprintf(temp, sizeof temp, ".tmp-%s", name);
    ok(cache_begin(&c, name, &mine) == CACHE_BEGUN, "what is not there can be begun");
    ok(cache_begin(&c, name, &other) == CACHE_BUSY && !strcmp(other.temp, mine.temp),
       "not twice at once");
    cache_put(&c, hex, "document", 8);
    ok(is_there(temp), "it is left alone by who makes room");
    ok(cache_write(&mine, "half", 4, &err) && cache_open(&c, name) < 0,
       "nobody sees it before it is finished");
    cache_drop(&mine);
    ok(!is_there(temp) && !is_there(name), "and nobody ever does when it is dropped");
    ok(write_made(&c, name, "whole"), "then it can be begun again");
    const int fd = cache_open(&c, name);
    char text[8] = "";
    ok(fd >= 0 && read(fd, text, sizeof text) == 5 && !strcmp(text, "whole"), "and is there whole");
    close(fd);
    ok(symlink("/dev/null", file_in(temp)) == 0 && cache_begin(&c, name, &mine) == CACHE_OFF,
       "a link in its place is not followed");
    unlink(file_in(temp));
    unlink(file_in(name));
    unlink(file_in(hex));
}

static void kept_files_go_last(void)
{
    struct cache c;
    char hex[HASH_HEX], name[3][CACHE_NAME];
    static const char *const keys[] = {"0000000000000000", "1111111111111111", "2222222222222222"};
    cache_init(&c, dir, 25);
    hash_hex("document", 8, hex);
    for (int i = 0; i < 3; i++)
        cache_name(name[i], hex, keys[i]);
    write_made(&c, name[0], "aaaaaaaaaa");
    write_made(&c, name[1], "bbbbbbbbbb");
    const int fd = cache_open(&c, name[0]);
    cache_keep(fd);
    set_age(name[0], clock_unix_ms() / 1000 - 2000);
    set_age(name[1], clock_unix_ms() / 1000 - 1000);
    ok(write_made(&c, name[2], "cccccccccc") && is_there(name[0]) && !is_there(name[1]),
       "a file in use is spared");
    set_age(name[0], 1000);
    set_age(name[2], 1000);
    ok(write_made(&c, name[1], "b") && is_there(name[0]) && !is_there(name[2]),
       "what was not used for a month goes without need, but for one in use");
    ok(write_made(&c, name[2], "cccccccccccccccccccc") && !is_there(name[0]),
       "that goes when there is no other room");
    close(fd);
}

int main(void)
{
    log_init("test_cache", LOG_ERROR);
    strcpy(dir, "/tmp/smalti-cache-XXXXXX");
    if (!mkdtemp(dir))
        return 1;
    struct cache c;
    char nested[128];
    snprintf(nested, sizeof nested, "%s/a/b", dir);
    cache_init(&c, nested, 1000);
    ok(c.usable, "the directory is made, with those above it");
    cache_init(&c, dir, 1000);
    out_comes_what_went_in(&c);
    bound_holds();
    drafts_are_ours_alone();
    kept_files_go_last();
    cache_init(&c, "/proc/nowhere", 1000);
    ok(!c.usable && !gives(&c, "00", ""), "without a directory the worker goes on without a cache");
    char command[128];
    snprintf(command, sizeof command, "rm -rf %s", dir);
    return system(command) | tap_done();
}
