/* SPDX-License-Identifier: MIT */
#include "common/buf.h"

#include <errno.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/arena.h"
#include "common/err.h"

void buf_release(struct buf *b)
{
    free(b->data);
    *b = (struct buf){0};
}

void *buf_grow(struct buf *b, size_t bytes)
{
    if (b->capacity - b->size < bytes) {
        size_t want = b->capacity ? b->capacity * 2 : 256;
        if (want < b->size + bytes)
            want = b->size + bytes;
        b->data = arena_realloc(b->data, want, 1);
        b->capacity = want;
    }
    void *at = b->data + b->size;
    b->size += bytes;
    return at;
}

void buf_append(struct buf *b, const void *data, size_t bytes)
{
    if (bytes)
        memcpy(buf_grow(b, bytes), data, bytes);
}

static void put_le(struct buf *b, uint64_t v, size_t bytes)
{
    unsigned char *at = buf_grow(b, bytes);
    for (size_t i = 0; i < bytes; i++)
        at[i] = (unsigned char)(v >> (8 * i));
}

void buf_text(struct buf *b, const char *fmt, ...)
{
    va_list args, again;
    va_start(args, fmt);
    va_copy(again, args);
    const int n = vsnprintf(NULL, 0, fmt, args);
    va_end(args);
    if (n > 0) {
        buf_grow(b, (size_t)n + 1);
        vsnprintf((char *)b->data + b->size - n - 1, (size_t)n + 1, fmt, again);
        b->size--;
    }
    va_end(again);
}

void buf_u32(struct buf *b, uint32_t v)
{
    put_le(b, v, 4);
}

void buf_u64(struct buf *b, uint64_t v)
{
    put_le(b, v, 8);
}

struct buf_reader buf_reader_make(const void *data, size_t bytes)
{
    const unsigned char *at = data;
    return (struct buf_reader){.at = at, .end = at + bytes};
}

const void *buf_read(struct buf_reader *r, size_t bytes)
{
    if (r->failed || (size_t)(r->end - r->at) < bytes) {
        r->failed = true;
        return NULL;
    }
    const void *at = r->at;
    r->at += bytes;
    return at;
}

static uint64_t get_le(struct buf_reader *r, size_t bytes)
{
    const unsigned char *at = buf_read(r, bytes);
    uint64_t v = 0;
    for (size_t i = 0; at && i < bytes; i++)
        v |= (uint64_t)at[i] << (8 * i);
    return v;
}

uint32_t buf_read_u32(struct buf_reader *r)
{
    return (uint32_t)get_le(r, 4);
}

uint64_t buf_read_u64(struct buf_reader *r)
{
    return get_le(r, 8);
}

bool buf_read_file(struct buf *out, const char *path, size_t max_bytes, struct err *err)
{
    FILE *f = fopen(path, "rb");
    if (!f)
        return err_set(err, errno == ENOENT ? ERR_NOT_FOUND : ERR_IO, "%s: %s", path,
                       strerror(errno));
    const size_t begin = out->size;
    bool ok = true;
    for (;;) {
        const size_t step = 256 * 1024;
        const size_t n = fread(buf_grow(out, step), 1, step, f);
        out->size -= step - n;
        if (out->size - begin > max_bytes)
            ok = err_set(err, ERR_LIMIT, "%s: larger than %zu bytes", path, max_bytes);
        if (n < step || !ok)
            break;
    }
    if (ok && ferror(f))
        ok = err_set(err, ERR_IO, "%s: %s", path, strerror(errno));
    fclose(f);
    return ok;
}
