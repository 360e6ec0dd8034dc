/* err, arena, buf, hash: what everything stands on.
 * SPDX-License-Identifier: MIT */
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/arena.h"
#include "common/buf.h"
#include "common/err.h"
#include "common/hash.h"
#include "tests/tap.h"

static void errors_nest_and_never_overflow(void)
{
    struct err e;
    ok(!err_set(&e, ERR_INPUT, "ior must be > 0, got %g", -1.0), "err_set returns false");
    ok(!err_at(&e, "materials[%d]", 3) && !strcmp(e.text, "materials[3]: ior must be > 0, got -1"),
       "err_at puts the place in front");
    for (int i = 0; i < 200; i++)
        err_at(&e, "%0100d", i);
    ok(strlen(e.text) == sizeof e.text - 1, "a text that is too long is cut, not overrun");
}

static void arena_gives_zeroed_aligned_memory(void)
{
    struct arena a = {0};
    bool zero = true, aligned = true;
    for (size_t i = 1; i < 4000; i += 7) {
        unsigned char *p = arena_alloc(&a, i, 1, 64);
        aligned &= (uintptr_t)p % 64 == 0;
        for (size_t k = 0; k < i; k++)
            zero &= p[k] == 0;
        memset(p, 0xab, i);
    }
    ok(zero && aligned, "arena memory is zeroed and aligned");
    double *big = arena_new(&a, double, 10u << 20);
    big[(10u << 20) - 1] = 1;
    arena_reset(&a);
    ok(*arena_new(&a, int, 1) == 0, "memory is zero again after a reset");
    ok(!strcmp(arena_printf(&a, "%s-%d", "tile", 7), "tile-7"), "arena_printf formats");
    arena_release(&a);
    ok(!a.head && a.used_bytes == 0, "release leaves a valid empty arena");
}

static void reader_stops_at_its_end(void)
{
    struct buf b = {0};
    buf_u32(&b, 0x01020304);
    buf_u64(&b, 0x1122334455667788);
    struct buf_reader r = buf_reader_make(b.data, b.size);
    ok(b.data[0] == 4 && buf_read_u32(&r) == 0x01020304 &&
           buf_read_u64(&r) == 0x1122334455667788 && !r.failed,
       "integers are little-endian and come back");
    ok(buf_read_u32(&r) == 0 && r.failed, "reading past the end gives zero and is remembered");
    r = buf_reader_make(b.data, b.size);
    ok(!buf_read(&r, SIZE_MAX) && r.failed && buf_read_u32(&r) == 0,
       "a length from hell is refused, and so is everything after it");
    buf_release(&b);
}

static void files_are_read_up_to_a_limit(void)
{
    char path[] = "/tmp/smalti-test-XXXXXX";
    const int fd = mkstemp(path);
    FILE *f = fdopen(fd, "wb");
    for (int i = 0; i < 300000; i++)
        fputc(i & 255, f);
    fclose(f);
    struct buf b = {0};
    struct err e;
    ok(buf_read_file(&b, path, 300000, &e) && b.size == 300000 && b.data[257] == 1,
       "a file comes back whole");
    ok(!buf_read_file(&b, path, 299999, &e) && e.code == ERR_LIMIT, "one byte too many is refused");
    remove(path);
    ok(!buf_read_file(&b, path, 1, &e) && e.code == ERR_NOT_FOUND && strstr(e.text, path),
       "a missing file is named");
    buf_release(&b);
}

static void sha256_matches_fips_180_4(void)
{
    char hex[HASH_HEX];
    hash_hex("abc", 3, hex);
    ok(!strcmp(hex, "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad"),
       "SHA-256 of abc");
    struct hash *h = hash_new();
    hash_add(h, "a", 1);
    hash_add(h, "bc", 2);
    char again[HASH_HEX];
    hash_finish(h, again);
    ok(!strcmp(hex, again), "in pieces it is the same");
    ok(hash_is_hex(hex) && !hash_is_hex("ba78") && !hash_is_hex("") &&
           !hash_is_hex("BA7816BF8F01CFEA414140DE5DAE2223B00361A396177A9CB410FF61F20015AD"),
       "a name of an asset is 64 lower-case hex digits");
}

int main(void)
{
    errors_nest_and_never_overflow();
    arena_gives_zeroed_aligned_memory();
    reader_stops_at_its_end();
    files_are_read_up_to_a_limit();
    sha256_matches_fips_180_4();
    return tap_done();
}
