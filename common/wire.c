/* SPDX-License-Identifier: MIT */
#include "common/wire.h"

#include <assert.h>
#include <math.h>
#include <string.h>

#include <zlib.h>

enum { VERSION_BARE = 1, VERSION_LAYERS, VERSION_BLOCKS }; /* of old */
enum { TYPE_SAMPLES = 1, FLAG_DEFLATED = 1, PROBE_BYTES = 4096 };

static const char magic[4] = {'S', 'M', 'L', 'T'};

_Static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__,
               "floats are copied as they lie in memory");

static void write_double(struct buf *out, double v)
{
    uint64_t bits;
    memcpy(&bits, &v, sizeof bits);
    buf_u64(out, bits);
}

static double read_double(struct buf_reader *r)
{
    const uint64_t bits = buf_read_u64(r);
    double v;
    memcpy(&v, &bits, sizeof v);
    return v;
}

static size_t active_bytes(const struct film_samples *s)
{
    return (block_count(s->rect) + 7) / 8;
}

static void write_active(const struct film_samples *s, struct buf *out)
{
    const struct block_set all = block_set_all(block_count(s->rect));
    const struct block_set *active = s->partial ? &s->active : &all;
    for (size_t i = 0; i < active_bytes(s); i++) {
        const unsigned char byte = (unsigned char)(active->bits[i / 8] >> 8 * (i % 8));
        buf_append(out, &byte, 1);
    }
}

/* Of the pixels that are sampled, so many floats of each. */
static void write_floats(const struct film_samples *s, const float *sums, size_t channels,
                         struct buf *out)
{
    const struct tile_rect r = s->rect;
    for (uint32_t y = r.y_begin; y < r.y_end; y++)
        for (uint32_t x = r.x_begin, end; film_samples_run(s, y, &x, &end); x = end) {
            const size_t at = (size_t)(y - r.y_begin) * (r.x_end - r.x_begin) + (x - r.x_begin);
            buf_append(out, sums + at * channels, (end - x) * channels * sizeof *sums);
        }
}

static void write_blocks(const struct film_samples *s, struct buf *out)
{
    for (size_t i = 0; i < block_count(s->rect); i++) {
        const struct block *b = &s->blocks[i];
        if (!film_samples_has(s, i))
            continue;
        write_double(out, b->sum);
        write_double(out, b->square);
        write_double(out, b->clamped);
        write_double(out, b->cut);
        buf_u64(out, b->met);
        buf_append(out, b->top, sizeof b->top);
    }
}

static void write_facts(const struct film_samples *s, struct buf *out)
{
    const struct film_work *w = &s->work;
    buf_u32(out, s->layers);
    buf_u32(out, s->dropped.degenerate);
    buf_u32(out, s->dropped.nonfinite);
    buf_u64(out, w->camera_rays);
    buf_u64(out, w->bounce_rays);
    buf_u64(out, w->shadow_rays);
    buf_u64(out, w->plain_vertices);
    buf_u64(out, w->other_vertices);
    buf_u64(out, w->units);
}

static void write_body(const struct wire_samples *w, struct buf *out)
{
    const struct film_samples *s = &w->samples;
    buf_u64(out, w->job);
    buf_u32(out, w->frame);
    buf_u32(out, w->tile);
    buf_u32(out, w->pass);
    buf_u32(out, s->rect.x_begin);
    buf_u32(out, s->rect.y_begin);
    buf_u32(out, s->rect.x_end);
    buf_u32(out, s->rect.y_end);
    buf_u32(out, s->pass.s_begin);
    buf_u32(out, s->pass.s_end);
    buf_u64(out, w->cpu_us);
    buf_u64(out, s->invalid_count);
    buf_u32(out, s->key_count);
    write_facts(s, out);
    write_active(s, out);
    for (uint32_t i = 0; i < s->key_count; i++) {
        buf_u32(out, s->keys[i].x_px);
        buf_u32(out, s->keys[i].y_px);
        buf_u32(out, s->keys[i].sample);
    }
    write_floats(s, s->sums, FILM_CHANNELS, out);
    if (s->layers)
        write_floats(s, s->layer_sums, layers_channels(s->layers), out);
    write_blocks(s, out);
}

static size_t deflate_into(unsigned char *out, size_t room, const unsigned char *data, size_t bytes)
{
    uLongf n = room;
    return compress2(out, &n, data, bytes, Z_BEST_SPEED) == Z_OK ? n : 0;
}

/* Worth compressing? A piece from the middle tells: noise stays, flat areas collapse. */
static bool shrinks(const unsigned char *body, size_t bytes)
{
    unsigned char piece[PROBE_BYTES * 2];
    if (bytes < 2 * PROBE_BYTES)
        return false;
    const size_t n = deflate_into(piece, sizeof piece, body + bytes / 2, PROBE_BYTES);
    return n && n < PROBE_BYTES / 2;
}

void wire_encode(const struct wire_samples *w, struct buf *out)
{
    struct buf raw = {0}, packed = {0};
    write_body(w, &raw);
    const struct buf *body = &raw;
    if (shrinks(raw.data, raw.size)) {
        void *room = buf_grow(&packed, compressBound(raw.size));
        packed.size = deflate_into(room, packed.size, raw.data, raw.size);
        if (packed.size && packed.size < raw.size)
            body = &packed;
    }
    buf_append(out, magic, sizeof magic);
    buf_u32(out, WIRE_VERSION | TYPE_SAMPLES << 16);
    buf_u32(out, body == &packed ? FLAG_DEFLATED : 0);
    buf_u64(out, raw.size);
    buf_u64(out, body->size);
    buf_u32(out, (uint32_t)crc32_z(0, body->data, body->size));
    buf_append(out, body->data, body->size);
    buf_release(&raw);
    buf_release(&packed);
}

struct frame {
    uint32_t version;
    size_t body_bytes;
};

/* The body, inflated when need be; NULL with `err` set when the frame is wrong. */
static const unsigned char *open_frame(const void *data, size_t bytes, struct frame *frame,
                                       struct arena *arena, struct err *err)
{
    struct buf_reader r = buf_reader_make(data, bytes);
    const void *word = buf_read(&r, sizeof magic);
    const uint32_t kind = buf_read_u32(&r), flags = buf_read_u32(&r);
    const uint64_t raw = buf_read_u64(&r), sent = buf_read_u64(&r);
    const uint32_t crc = buf_read_u32(&r);
    const size_t rest = (size_t)(r.end - r.at);
    bool ok = false;
    frame->version = kind & 0xffff;
    if (r.failed || bytes > WIRE_MAX_BYTES)
        err_set(err, ERR_PROTOCOL, "payload of %zu bytes: expected %d to %d", bytes,
                WIRE_HEADER_BYTES, WIRE_MAX_BYTES);
    else if (memcmp(word, magic, sizeof magic) != 0)
        err_set(err, ERR_PROTOCOL, "payload does not begin with SMLT");
    else if (kind >> 16 != TYPE_SAMPLES || frame->version < VERSION_BARE ||
             frame->version > WIRE_VERSION)
        err_set(err, ERR_PROTOCOL,
                "payload version %u, type %u: expected version %d to %d, type %d", frame->version,
                kind >> 16, VERSION_BARE, WIRE_VERSION, TYPE_SAMPLES);
    else if (flags & ~(uint32_t)FLAG_DEFLATED)
        err_set(err, ERR_PROTOCOL, "payload flags 0x%x: expected 0 or 1", flags);
    else if (sent != rest || raw > WIRE_MAX_BYTES - WIRE_HEADER_BYTES ||
             (!(flags & FLAG_DEFLATED) && raw != sent))
        err_set(err, ERR_PROTOCOL, "payload body of %zu bytes contradicts its header", rest);
    else if (crc != crc32_z(0, r.at, rest))
        err_set(err, ERR_PROTOCOL, "payload checksum is wrong");
    else
        ok = true;
    if (!ok)
        return NULL;

    frame->body_bytes = (size_t)raw;
    if (!(flags & FLAG_DEFLATED))
        return r.at;
    unsigned char *body = arena_new(arena, unsigned char, (size_t)raw);
    uLongf n = raw;
    if (uncompress(body, &n, r.at, rest) != Z_OK || n != raw) {
        err_set(err, ERR_PROTOCOL, "payload does not inflate to %llu bytes",
                (unsigned long long)raw);
        return NULL;
    }
    return body;
}

static bool rect_is_sane(struct tile_rect r)
{
    return r.x_begin < r.x_end && r.y_begin < r.y_end && r.x_end - r.x_begin <= TILE_MAX_PX &&
           r.y_end - r.y_begin <= TILE_MAX_PX;
}

static void read_facts(struct buf_reader *r, struct film_samples *s)
{
    struct film_work *w = &s->work;
    s->dropped.degenerate = buf_read_u32(r);
    s->dropped.nonfinite = buf_read_u32(r);
    w->camera_rays = buf_read_u64(r);
    w->bounce_rays = buf_read_u64(r);
    w->shadow_rays = buf_read_u64(r);
    w->plain_vertices = buf_read_u64(r);
    w->other_vertices = buf_read_u64(r);
    w->units = buf_read_u64(r);
}

static void read_fixed(struct buf_reader *r, uint32_t version, struct wire_samples *w)
{
    struct film_samples *s = &w->samples;
    w->job = buf_read_u64(r);
    w->frame = buf_read_u32(r);
    w->tile = buf_read_u32(r);
    w->pass = buf_read_u32(r);
    s->rect.x_begin = buf_read_u32(r);
    s->rect.y_begin = buf_read_u32(r);
    s->rect.x_end = buf_read_u32(r);
    s->rect.y_end = buf_read_u32(r);
    s->pass.s_begin = buf_read_u32(r);
    s->pass.s_end = buf_read_u32(r);
    w->cpu_us = buf_read_u64(r);
    s->invalid_count = buf_read_u64(r);
    s->key_count = buf_read_u32(r);
    s->layers = version >= VERSION_LAYERS ? buf_read_u32(r) : 0;
    if (version >= VERSION_BLOCKS)
        read_facts(r, s);
}

/* Which blocks follow; before version 4 all do. */
static bool read_active(struct buf_reader *r, uint32_t version, struct film_samples *s,
                        struct err *err)
{
    if (version < WIRE_VERSION)
        return true;
    struct block_set active = {0};
    const struct block_set all = block_set_all(block_count(s->rect));
    const unsigned char *bytes = buf_read(r, active_bytes(s));
    for (size_t i = 0; !r->failed && i < active_bytes(s); i++)
        active.bits[i / 8] |= (uint64_t)bytes[i] << 8 * (i % 8);
    if (!block_set_count(&active) || !block_set_within(&active, &all))
        return err_set(err, ERR_PROTOCOL, "payload set of blocks: expected some of %zu",
                       block_count(s->rect));
    film_samples_restrict(s, &active);
    return true;
}

static bool check_fixed(const struct film_samples *s, uint32_t version, struct err *err)
{
    if (!layers_are_known(s->layers) || (version == VERSION_LAYERS && !s->layers))
        return err_set(err, ERR_PROTOCOL, "payload layers 0x%x: expected a set of layers",
                       s->layers);
    if (!rect_is_sane(s->rect))
        return err_set(err, ERR_PROTOCOL, "payload rectangle is empty or larger than %d px",
                       TILE_MAX_PX);
    if (s->pass.s_begin >= s->pass.s_end)
        return err_set(err, ERR_PROTOCOL, "payload sample range [%u, %u) is empty", s->pass.s_begin,
                       s->pass.s_end);
    return true;
}

static bool check_counts(const struct film_samples *s, struct err *err)
{
    const uint64_t samples = (uint64_t)film_samples_pixels(s) * (s->pass.s_end - s->pass.s_begin);
    if (s->invalid_count > samples || s->key_count > FILM_MAX_KEYS ||
        s->key_count > s->invalid_count)
        return err_set(err, ERR_PROTOCOL, "payload counts %llu invalid samples of %llu, %u keys",
                       (unsigned long long)s->invalid_count, (unsigned long long)samples,
                       s->key_count);
    return true;
}

static bool key_inside(const struct film_samples *s, struct film_key k)
{
    const struct tile_rect r = s->rect;
    return k.x_px >= r.x_begin && k.x_px < r.x_end && k.y_px >= r.y_begin && k.y_px < r.y_end &&
           k.sample >= s->pass.s_begin && k.sample < s->pass.s_end &&
           film_samples_has(s, (size_t)(k.y_px - r.y_begin) / BLOCK_PX * block_columns(r) +
                                   (k.x_px - r.x_begin) / BLOCK_PX);
}

static bool read_keys(struct buf_reader *r, struct film_samples *s, struct err *err)
{
    for (uint32_t i = 0; i < s->key_count; i++) {
        s->keys[i].x_px = buf_read_u32(r);
        s->keys[i].y_px = buf_read_u32(r);
        s->keys[i].sample = buf_read_u32(r);
        if (!r->failed && !key_inside(s, s->keys[i]))
            return err_set(err, ERR_PROTOCOL,
                           "payload key %u lies outside its tile, blocks and pass", i);
    }
    return true;
}

/* So many floats of each pixel that is sampled, all finite; *out is memory of the arena, with zeros
 * for the others. */
static bool read_floats(struct buf_reader *in, const struct film_samples *s, size_t channels,
                        struct arena *arena, float **out)
{
    const struct tile_rect r = s->rect;
    bool finite = true;
    *out = arena_new(arena, float, tile_rect_pixels(r) * channels);
    for (uint32_t y = r.y_begin; y < r.y_end; y++)
        for (uint32_t x = r.x_begin, end; film_samples_run(s, y, &x, &end); x = end) {
            const size_t at = (size_t)(y - r.y_begin) * (r.x_end - r.x_begin) + (x - r.x_begin);
            const size_t count = (end - x) * channels;
            float *to = *out + at * channels;
            memcpy(to, buf_read(in, count * sizeof *to), count * sizeof *to);
            for (size_t i = 0; i < count;
                 i++) /* negative they may be, by the pixel filter's sign */
                finite &= isfinite(to[i]) != 0;
        }
    return finite;
}

/* x and its sums are never negative, the largest fall, and a NaN is nothing of it. 2^24 samples of
 * 64 pixels, each below 2^102, stay far below these bounds; sums of what is below them are finite.
 */
static bool block_is_sane(const struct block *b, uint64_t samples)
{
    const double most = 0x1p+200, most_square = 0x1p+400;
    bool ok = b->sum >= 0 && b->sum <= most && b->square >= 0 && b->square <= most_square &&
              fabs(b->clamped) <= most && fabs(b->cut) <= most && b->met <= samples &&
              isfinite(b->top[0]);
    for (uint32_t i = 0; ok && i < BLOCK_TOP; i++)
        ok = i + 1 < BLOCK_TOP ? b->top[i] >= b->top[i + 1] : b->top[i] >= 0;
    return ok;
}

static bool read_blocks(struct buf_reader *r, struct film_samples *s, struct arena *arena,
                        struct err *err)
{
    const size_t count = block_count(s->rect);
    const uint64_t samples = s->pass.s_end - s->pass.s_begin;
    s->blocks = arena_new(arena, struct block, count);
    for (size_t i = 0; i < count; i++) {
        struct block *b = &s->blocks[i];
        if (!film_samples_has(s, i))
            continue;
        b->sum = read_double(r);
        b->square = read_double(r);
        b->clamped = read_double(r);
        b->cut = read_double(r);
        b->met = buf_read_u64(r);
        const void *top = buf_read(r, sizeof b->top);
        if (r->failed)
            return err_set(err, ERR_PROTOCOL, "payload blocks are cut short");
        memcpy(b->top, top, sizeof b->top);
        if (!block_is_sane(b, samples * tile_rect_pixels(block_rect_of(s->rect, i))))
            return err_set(err, ERR_PROTOCOL, "payload block %zu is none of %llu samples a pixel",
                           i, (unsigned long long)samples);
    }
    return true;
}

static bool read_sums(struct buf_reader *r, uint32_t version, struct film_samples *s,
                      struct arena *arena, struct err *err)
{
    const size_t pixels = film_samples_pixels(s), rest = (size_t)(r->end - r->at);
    const size_t layers = layers_channels(s->layers);
    const size_t count = s->partial ? block_set_count(&s->active) : block_count(s->rect);
    const size_t blocks = version < VERSION_BLOCKS ? 0 : count * WIRE_BLOCK_BYTES;
    const size_t want = pixels * (FILM_CHANNELS + layers) * sizeof(float) + blocks;
    if (r->failed || rest != want)
        return err_set(err, ERR_PROTOCOL, "payload sums: %zu bytes, expected %zu", rest, want);
    if (!read_floats(r, s, FILM_CHANNELS, arena, &s->sums))
        return err_set(err, ERR_PROTOCOL, "payload sums: one is not finite");
    if (layers && !read_floats(r, s, layers, arena, &s->layer_sums))
        return err_set(err, ERR_PROTOCOL, "payload layers: a sum is not finite");
    return true;
}

static int fixed_bytes(uint32_t version)
{
    return version == VERSION_BARE ? 64 : version == VERSION_LAYERS ? 68 : WIRE_BODY_FIXED_BYTES;
}

bool wire_decode(struct wire_samples *w, const void *data, size_t bytes, struct arena *arena,
                 struct err *err)
{
    *w = (struct wire_samples){0};
    struct frame frame = {0};
    const unsigned char *body = open_frame(data, bytes, &frame, arena, err);
    if (!body)
        return false;
    struct buf_reader r = buf_reader_make(body, frame.body_bytes);
    read_fixed(&r, frame.version, w);
    if (r.failed)
        return err_set(err, ERR_PROTOCOL, "payload body of %zu bytes: expected at least %d",
                       frame.body_bytes, fixed_bytes(frame.version));
    struct film_samples *s = &w->samples;
    return check_fixed(s, frame.version, err) && read_active(&r, frame.version, s, err) &&
           check_counts(s, err) && read_keys(&r, s, err) &&
           read_sums(&r, frame.version, s, arena, err) &&
           (frame.version < VERSION_BLOCKS || read_blocks(&r, s, arena, err));
}
