/* cache.c: what comes out is what was put in or nothing; the bound holds; other files are left
 * alone.
 * SPDX-License-Identifier: MIT */
#include "worker/cache.h"

#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

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
    write_file(".tmp-1-00", "of a process that died");
    set_age(".tmp-1-00", 1000);
    cache_put(&c, hex[0], texts[0], 10);
    cache_put(&c, hex[1], texts[1], 10);
    set_age(hex[0], 2000);
    set_age(hex[1], 1000);
    ok(gives(&c, hex[1], texts[1]), "reading makes an old asset young");
    cache_put(&c, hex[2], texts[2], 10);
    ok(!is_there(hex[0]), "the one unused for longest goes");
    ok(gives(&c, hex[1], texts[1]) && gives(&c, hex[2], texts[2]), "the others stay");
    ok(is_there("someone-elses"), "files that are not assets are left alone");
    ok(!is_there(".tmp-1-00"), "but what a dead process left is removed");
    char large[64];
    memset(large, 'x', sizeof large);
    hash_hex(large, sizeof large, hex[0]);
    cache_put(&c, hex[0], large, sizeof large);
    ok(!is_there(hex[0]) && is_there(hex[2]), "what is larger than the bound pushes nothing out");
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
    cache_init(&c, "/proc/nowhere", 1000);
    ok(!c.usable && !gives(&c, "00", ""), "without a directory the worker goes on without a cache");
    char command[128];
    snprintf(command, sizeof command, "rm -rf %s", dir);
    return system(command) | tap_done();
}
