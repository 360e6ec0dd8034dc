/* Large chunks come from the system itself, on pages of 2 MB where it has them: a hierarchy of
 * hundreds of megabytes, read here and there, then spends a fifth less time looking up addresses.
 * They are zero already, so arena_alloc need not write them, and the pages of what is never used
 * are never made. SPDX-License-Identifier: MIT */
#define _DEFAULT_SOURCE /* MAP_ANONYMOUS, madvise */
#include "common/arena.h"

#include <assert.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>

enum {
    CHUNK_MIN = 64 * 1024,
    ALIGN_MAX = 64,
    HUGE_PAGE = 2 * 1024 * 1024, /* chunks from this size on are mapped */
};

struct arena_chunk {
    struct arena_chunk *next;
    size_t size; /* bytes of data */
    size_t used;
    size_t dirty; /* bytes of data that may not be zero */
    alignas(ALIGN_MAX) unsigned char data[];
};

static void out_of_memory(size_t count, size_t size)
{
    fprintf(stderr, "smalti: out of memory: %zu x %zu bytes\n", count, size);
    abort();
}

static size_t checked_mul(size_t count, size_t size)
{
    size_t bytes;
    if (__builtin_mul_overflow(count, size, &bytes) || bytes > PTRDIFF_MAX / 2)
        out_of_memory(count, size);
    return bytes;
}

void *arena_malloc(size_t count, size_t size)
{
    void *p = calloc(count ? count : 1, size ? size : 1);
    if (!p)
        out_of_memory(count, size);
    return p;
}

void *arena_realloc(void *old, size_t count, size_t size)
{
    const size_t bytes = checked_mul(count, size);
    void *p = realloc(old, bytes ? bytes : 1);
    if (!p)
        out_of_memory(count, size);
    return p;
}

static size_t round_up_to(size_t bytes, size_t step)
{
    return (bytes + step - 1) & ~(step - 1);
}

static bool is_mapped(size_t bytes)
{
    return bytes >= HUGE_PAGE;
}

/* Aligned to huge pages: what lies before and behind is given back. */
static void *map_pages(size_t bytes)
{
    unsigned char *p =
        mmap(NULL, bytes + HUGE_PAGE, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (p == MAP_FAILED)
        return NULL;
    const size_t before = round_up_to((uintptr_t)p, HUGE_PAGE) - (uintptr_t)p;
    if (before)
        munmap(p, before);
    munmap(p + before + bytes, HUGE_PAGE - before);
    madvise(p + before, bytes, MADV_HUGEPAGE); /* as good as it gets: small pages do, too */
    return p + before;
}

static struct arena_chunk *chunk_new(size_t bytes)
{
    const size_t least = sizeof(struct arena_chunk) + bytes;
    const bool mapped = is_mapped(least);
    const size_t total = round_up_to(least, mapped ? HUGE_PAGE : ALIGN_MAX);
    struct arena_chunk *c = mapped ? map_pages(total) : aligned_alloc(ALIGN_MAX, total);
    if (!c)
        out_of_memory(1, total);
    c->next = NULL;
    c->size = total - sizeof(struct arena_chunk);
    c->used = 0;
    c->dirty = mapped ? 0 : c->size;
    return c;
}

static void chunk_free(struct arena_chunk *c)
{
    const size_t total = sizeof(struct arena_chunk) + c->size;
    if (is_mapped(total))
        munmap(c, total);
    else
        free(c);
}

void *arena_alloc(struct arena *a, size_t count, size_t size, size_t align)
{
    assert(align && align <= ALIGN_MAX && !(align & (align - 1)));
    const size_t bytes = checked_mul(count, size);
    struct arena_chunk *c = a->head;
    size_t at = c ? (c->used + align - 1) & ~(align - 1) : 0;
    if (!c || at > c->size || c->size - at < bytes) {
        const size_t grow = c ? c->size * 2 : CHUNK_MIN;
        const size_t cap =
            (size_t)16 * 1024 * 1024; /* beyond this, growth wastes more than it saves */
        size_t want = grow < cap ? grow : cap;
        if (want < bytes)
            want = bytes;
        c = chunk_new(want);
        c->next = a->head;
        a->head = c;
        at = 0;
    }
    c->used = at + bytes;
    a->used_bytes += bytes;
    if (at < c->dirty)
        memset(c->data + at, 0, bytes < c->dirty - at ? bytes : c->dirty - at);
    return c->data + at;
}

char *arena_strdup(struct arena *a, const char *text)
{
    const size_t n = strlen(text) + 1;
    return memcpy(arena_new(a, char, n), text, n);
}

char *arena_printf(struct arena *a, const char *fmt, ...)
{
    va_list ap, again;
    va_start(ap, fmt);
    va_copy(again, ap);
    const int n = vsnprintf(NULL, 0, fmt, ap);
    va_end(ap);
    assert(n >= 0);
    char *text = arena_new(a, char, (size_t)n + 1);
    vsnprintf(text, (size_t)n + 1, fmt, again);
    va_end(again);
    return text;
}

void *arena_grow(struct arena *a, void *list, size_t count, size_t size)
{
    if ((count & (count - 1)) != 0) /* full: 0, 1, 2, 4 ... */
        return list;
    void *more = arena_alloc(a, count ? 2 * count : 1, size, alignof(max_align_t));
    return count ? memcpy(more, list, count * size) : more;
}

static void free_chunks(struct arena_chunk *c)
{
    while (c) {
        struct arena_chunk *next = c->next;
        chunk_free(c);
        c = next;
    }
}

void arena_reset(struct arena *a)
{
    struct arena_chunk *keep = a->head;
    for (struct arena_chunk *c = a->head; c; c = c->next)
        if (c->size > keep->size)
            keep = c;
    for (struct arena_chunk **at = &a->head; *at;) {
        struct arena_chunk *c = *at;
        *at = c->next;
        if (c != keep)
            chunk_free(c);
    }
    if (keep) {
        keep->next = NULL;
        keep->dirty = keep->used > keep->dirty ? keep->used : keep->dirty;
        keep->used = 0;
    }
    a->head = keep;
    a->used_bytes = 0;
}

void arena_release(struct arena *a)
{
    free_chunks(a->head);
    *a = (struct arena){0};
}
