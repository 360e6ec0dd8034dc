/* arena.h - memory that lives and dies together.
 *
 * Good for: everything of one job, one request, one scene, one render thread.
 * Not for: single objects with their own lifetime. A function that takes a
 * `struct arena *` returns memory of that arena; a function that does not, does
 * not allocate. Memory is zeroed and aligned. Out of memory aborts: sizes that
 * come from outside are held against limits before they get here.
 * Thread-safety: one thread at a time per arena.
 * SPDX-License-Identifier: MIT */
#ifndef COMMON_ARENA_H
#define COMMON_ARENA_H

#include <stdalign.h>

#include "common/base.h"

struct arena_chunk;

struct arena {
    struct arena_chunk *head; /* newest first; zero-initialised is a valid empty arena */
    size_t used_bytes;        /* handed out in all, for reports */
};

#define arena_new(a, T, n) ((T *)arena_alloc((a), (n), sizeof(T), alignof(T)))

/* count * size bytes, zeroed. align: a power of two, at most 64. Never NULL. */
void *arena_alloc(struct arena *, size_t count, size_t size, size_t align);
char *arena_strdup(struct arena *, const char *text);
char *arena_printf(struct arena *, const char *fmt, ...) PRINTF(2, 3);
/* A list of count things of so many bytes that has room for one more: the same, or one twice as
 * large with the same content. For lists that only grow here, from NULL. */
void *arena_grow(struct arena *, void *list, size_t count, size_t size);
void arena_reset(struct arena *);   /* forgets everything, keeps the largest chunk */
void arena_release(struct arena *); /* gives everything back */

/* Heap memory outside any arena, for the few things that grow or outlive one: zeroed (malloc) or
 * resized (realloc), given back with free(); aborts when the machine is full. */
void *arena_malloc(size_t count, size_t size);
void *arena_realloc(void *, size_t count, size_t size);

#endif
