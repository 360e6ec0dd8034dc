/* wire.c: round trips, golden messages, truncation and damage.
 * SPDX-License-Identifier: MIT */
#include "common/wire.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <zlib.h>

#include "tests/tap.h"

/* Of 3 x 2 blocks, the last column and row cut: all, or these. */
static const struct block_set every = {{0x3f}}, some = {{0x2a}};

static struct wire_samples message(struct arena *arena, bool flat, uint32_t layers)
{
    const struct tile_rect r = {64, 32, 64 + 20, 32 + 10};
    struct wire_samples w = {
        .job = 0x0123456789abcdef,
        .tile = 5,
        .pass = 2,
        .cpu_us = 123456,
        .samples = film_samples_make(r, (struct tile_pass){16, 32}, arena),
    };
    film_samples_note_invalid(&w.samples, (struct film_key){64, 32, 16});
    film_samples_note_invalid(&w.samples, (struct film_key){83, 41, 31});
    for (uint32_t i = 0; i < tile_rect_pixels(r) * FILM_CHANNELS; i++)
        w.samples.sums[i] = flat ? 0.25f : (float)(i * 2654435761u >> 8) * 0x1p-20f;
    for (size_t i = 0; i < block_count(r); i++) {
        struct block *b = &w.samples.blocks[i];
        *b = (struct block){.clamped = 1.5, .cut = flat ? 0 : 2.5, .met = i};
        for (uint32_t k = 0; k < 40; k++)
            block_add(b, flat ? .25f : (float)((i + k) * 2654435761u % 1024));
    }
    w.samples.dropped = (struct film_dropped){3, 4};
    w.samples.work = (struct film_work){1, 2, 3, 4, (uint64_t)5 << 32, (uint64_t)1 << 40};
    film_samples_add_layers(&w.samples, layers, arena);
    for (uint32_t i = 0; i < tile_rect_pixels(r) * layers_channels(layers); i++)
        w.samples.layer_sums[i] = (float)i - 100;
    return w;
}

/* Zeros where no samples are, as a renderer leaves it. */
static struct wire_samples partial_message(struct arena *arena, uint32_t layers)
{
    struct wire_samples w = message(arena, false, layers);
    struct film_samples *s = &w.samples;
    const struct film_samples full = *s;
    const size_t channels = layers_channels(layers);
    *s = film_samples_make(s->rect, s->pass, arena);
    film_samples_add_layers(s, layers, arena);
    film_samples_restrict(s, &some);
    film_samples_note_invalid(s, (struct film_key){72, 32, 16});
    s->dropped = full.dropped;
    s->work = full.work;
    for (size_t i = 0; i < 6; i++) {
        const struct tile_rect b = block_rect_of(s->rect, i);
        if (!block_set_has(&some, i))
            continue;
        s->blocks[i] = full.blocks[i];
        for (uint32_t y = b.y_begin; y < b.y_end; y++)
            for (uint32_t x = b.x_begin; x < b.x_end; x++) {
                const size_t at = (y - 32) * 20 + (x - 64);
                memcpy(s->sums + at * FILM_CHANNELS, full.sums + at * FILM_CHANNELS,
                       FILM_CHANNELS * sizeof *s->sums);
                if (layers)
                    memcpy(s->layer_sums + at * channels, full.layer_sums + at * channels,
                           channels * sizeof *s->sums);
            }
    }
    return w;
}

/* Messages of older versions have none. */
static bool same_evidence(const struct film_samples *s, const struct film_samples *t)
{
    return !t->blocks || (!memcmp(s->blocks, t->blocks, block_count(s->rect) * sizeof *s->blocks) &&
                          !memcmp(&s->work, &t->work, sizeof s->work) &&
                          !memcmp(&s->dropped, &t->dropped, sizeof s->dropped));
}

static bool same(const struct wire_samples *a, const struct wire_samples *b)
{
    const struct film_samples *s = &a->samples, *t = &b->samples;
    return a->job == b->job && a->frame == b->frame && a->tile == b->tile && a->pass == b->pass &&
           a->cpu_us == b->cpu_us && !memcmp(&s->rect, &t->rect, sizeof s->rect) &&
           !memcmp(&s->pass, &t->pass, sizeof s->pass) && s->invalid_count == t->invalid_count &&
           s->key_count == t->key_count && !memcmp(s->keys, t->keys, sizeof s->keys) &&
           s->layers == t->layers && same_evidence(s, t) && s->partial == t->partial &&
           block_set_equal(&s->active, &t->active) &&
           !memcmp(s->sums, t->sums, tile_rect_pixels(s->rect) * FILM_CHANNELS * sizeof *s->sums) &&
           (!s->layers ||
            !memcmp(s->layer_sums, t->layer_sums,
                    tile_rect_pixels(s->rect) * layers_channels(s->layers) * sizeof(float)));
}

static const uint32_t some_layers = LAYER_NORMAL | LAYER_DEPTH | 2 << 8;

static void round_trip(bool flat, uint32_t layers)
{
    struct arena arena = {0};
    struct buf b = {0};
    struct err err;
    const struct wire_samples w = message(&arena, flat, layers);
    struct wire_samples back;
    wire_encode(&w, &b);
    ok(wire_decode(&back, b.data, b.size, &arena, &err) && back.samples.blocks && same(&w, &back),
       "%s samples%s come back as they were", flat ? "flat" : "noisy",
       layers ? " with layers" : "");
    const size_t raw = WIRE_HEADER_BYTES + WIRE_BODY_FIXED_BYTES + 1 + 2 * 12 + 3 * 2 * 104 +
                       20 * 10 * (96 + 4 * layers_channels(layers));
    ok(flat ? b.size < raw / 10 : b.size == raw, "%s samples take %zu bytes",
       flat ? "flat" : "noisy", b.size);
    buf_release(&b);
    arena_release(&arena);
}

static void round_trip_of_some(uint32_t layers)
{
    struct arena arena = {0};
    struct buf b = {0};
    struct err err;
    const struct wire_samples w = partial_message(&arena, layers);
    struct wire_samples back;
    wire_encode(&w, &b);
    ok(wire_decode(&back, b.data, b.size, &arena, &err) && same(&w, &back),
       "samples of some blocks%s come back, with zeros between them", layers ? " with layers" : "");
    const size_t pixels = 8 * 8 + 8 * 2 + 4 * 2;
    const size_t raw = WIRE_HEADER_BYTES + WIRE_BODY_FIXED_BYTES + 1 + 12 + 3 * 104 +
                       pixels * (96 + 4 * layers_channels(layers));
    ok(film_samples_pixels(&w.samples) == pixels && b.size == raw, "they take %zu bytes", b.size);
    buf_release(&b);
    arena_release(&arena);
}

/* tests/golden/NAME, made once by the first version that spoke it. SMALTI_WRITE_GOLDEN=1 makes a
 * missing one; an existing one is never touched. */
static void golden(const char *name, bool flat, uint32_t layers, const struct block_set *active)
{
    char path[200];
    snprintf(path, sizeof path, "tests/golden/%s", name);
    struct arena arena = {0};
    struct buf b = {0}, file = {0};
    struct err err;
    const struct wire_samples w = block_set_equal(active, &every) ? message(&arena, flat, layers)
                                                                  : partial_message(&arena, layers);
    if (getenv("SMALTI_WRITE_GOLDEN")) {
        wire_encode(&w, &b);
        FILE *f = fopen(path, "wxb");
        if (f) {
            fwrite(b.data, 1, b.size, f);
            fclose(f);
        }
    }
    struct wire_samples back;
    if (!ok(buf_read_file(&file, path, WIRE_MAX_BYTES, &err), "%s is there", path)) {
        diag("%s", err.text);
    } else {
        ok(wire_decode(&back, file.data, file.size, &arena, &err) && same(&w, &back),
           "%s says what it always said", name);
        size_t refused = 0;
        for (size_t n = 0; n < file.size; n++) {
            struct arena one = {0};
            refused += !wire_decode(&back, file.data, n, &one, &err) && err.code == ERR_PROTOCOL;
            arena_release(&one);
        }
        ok(refused == file.size, "cut at any of its %zu bytes it is refused", file.size);
        size_t caught = 0;
        for (size_t n = 0; n < file.size; n++) {
            struct arena one = {0};
            file.data[n] ^= 0x10;
            caught += !wire_decode(&back, file.data, file.size, &one, &err);
            file.data[n] ^= 0x10;
            arena_release(&one);
        }
        ok(caught == file.size, "with any byte damaged it is refused");
    }
    buf_release(&b);
    buf_release(&file);
    arena_release(&arena);
}

/* Lies a peer with a right checksum can tell. */
static void refuses(const char *what, struct wire_samples w)
{
    struct arena arena = {0};
    struct buf b = {0};
    struct err err = {0};
    struct wire_samples back;
    wire_encode(&w, &b);
    ok(!wire_decode(&back, b.data, b.size, &arena, &err) && err.code == ERR_PROTOCOL && err.text[0],
       "refuses %s", what);
    buf_release(&b);
    arena_release(&arena);
}

static void refuses_block(const char *what, struct wire_samples w, const struct block *bad)
{
    w.samples.blocks[5] = *bad;
    refuses(what, w);
}

static void refuses_blocks(struct arena *arena)
{
    const struct wire_samples good = message(arena, false, 0);
    const struct block fine = good.samples.blocks[5]; /* of 4 x 2 pixels */
    struct block b = fine;
    b.sum = -1;
    refuses_block("a block's negative sum", good, &b);
    b = fine;
    b.sum = 0x1p+201;
    refuses_block("a sum that no samples have", good, &b);
    b = fine;
    b.square = (double)NAN;
    refuses_block("a block's sum of squares that is no number", good, &b);
    b = fine;
    b.clamped = (double)INFINITY;
    refuses_block("an infinite clamped light", good, &b);
    b = fine;
    b.cut = (double)NAN;
    refuses_block("a cut light that is no number", good, &b);
    b = fine;
    b.met = 4 * 2 * 16 + 1;
    refuses_block("more samples that met something than there are", good, &b);
    b = fine;
    b.top[3] = b.top[2] + 1;
    refuses_block("largest values that rise", good, &b);
    b = fine;
    b.top[15] = -1;
    refuses_block("a negative one", good, &b);
    b = fine;
    b.top[7] = NAN;
    refuses_block("one that is no number", good, &b);
    b = fine;
    b.top[0] = INFINITY;
    refuses_block("an infinite one", good, &b);
}

static void refuses_set(const char *what, unsigned char set, struct arena *arena)
{
    struct buf b = {0};
    struct wire_samples back;
    struct err err = {0};
    const struct wire_samples w = partial_message(arena, 0);
    wire_encode(&w, &b);
    b.data[WIRE_HEADER_BYTES + WIRE_BODY_FIXED_BYTES] = set;
    const uint32_t crc =
        (uint32_t)crc32_z(0, b.data + WIRE_HEADER_BYTES, b.size - WIRE_HEADER_BYTES);
    memcpy(b.data + 28, &crc, sizeof crc);
    ok(!wire_decode(&back, b.data, b.size, arena, &err) && err.code == ERR_PROTOCOL && err.text[0],
       "refuses %s: %s", what, err.text);
    buf_release(&b);
}

static void refuses_sets(struct arena *arena)
{
    refuses_set("a set of no blocks", 0, arena);
    refuses_set("a set with a block too many", 0x2b, arena);
    refuses_set("a set with a block too few", 0x22, arena);
    refuses_set("a set with other blocks than were sent", 0x16, arena);
    refuses_set("a set with a block beyond the tile", 0x6a, arena);
    struct wire_samples w = partial_message(arena, 0);
    w.samples.keys[0] = (struct film_key){64, 32, 16};
    refuses("a key in a block that is not there", w);
    w = partial_message(arena, 0);
    w.samples.invalid_count = 88 * 16 + 1;
    refuses("more invalid samples than the blocks have", w);
}

static void refuses_lies(void)
{
    struct arena arena = {0};
    const struct wire_samples good = message(&arena, false, 0);
    struct wire_samples w = good;
    w.samples.pass = (struct tile_pass){32, 32};
    refuses("an empty sample range", w);
    w = good;
    w.samples.invalid_count = 1;
    refuses("more keys than invalid samples", w);
    w = good;
    w.samples.invalid_count = UINT64_MAX;
    refuses("more invalid samples than samples", w);
    w = good;
    w.samples.keys[1].x_px = 84;
    refuses("a key outside the tile", w);
    w = good;
    w.samples.keys[0].sample = 32;
    refuses("a key outside the pass", w);
    static const float bad[] = {NAN, INFINITY, -INFINITY};
    for (size_t i = 0; i < countof(bad); i++) {
        w = message(&arena, false, 0);
        w.samples.sums[4799] = bad[i];
        refuses(i == 0 ? "NaN" : i == 1 ? "infinity" : "minus infinity", w);
    }
    w = message(&arena, false, some_layers);
    w.samples.layer_sums[1] = NAN;
    refuses("a layer that is not a number", w);
    w = message(&arena, false, some_layers);
    w.samples.layers = some_layers | 1 << 6;
    refuses("a layer that nobody knows", w);
    refuses_blocks(&arena);
    refuses_sets(&arena);
    arena_release(&arena);
}

int main(void)
{
    round_trip(false, 0);
    round_trip(true, 0);
    round_trip(false, some_layers);
    round_trip_of_some(0);
    round_trip_of_some(some_layers);
    golden("samples-v1-raw.bin", false, 0, &every);
    golden("samples-v1-deflated.bin", true, 0, &every);
    golden("samples-v2-raw.bin", false, some_layers, &every);
    golden("samples-v3-raw.bin", false, some_layers, &every);
    golden("samples-v3-deflated.bin", true, 0, &every);
    golden("samples-v4-raw.bin", false, some_layers, &some);
    golden("samples-v4-deflated.bin", true, 0, &every);
    refuses_lies();
    return tap_done();
}
