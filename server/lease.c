/* SPDX-License-Identifier: MIT */
#include "server/lease.h"

#include <assert.h>
#include <stdlib.h>

#include "common/arena.h"

enum { SLOTS_MIN = 64 };

struct lease_table {
    uint64_t nonce; /* in the upper 32 bits */
    uint32_t last;  /* counter of the newest id */
    struct lease **heap;
    size_t count, capacity;
    struct lease **slots; /* open addressing, linear probing; a power of two, at most half full */
    size_t slot_count;
};

struct lease_table *lease_table_new(uint32_t nonce)
{
    struct lease_table *t = arena_malloc(1, sizeof *t);
    t->nonce = (uint64_t)nonce << 32;
    t->slot_count = SLOTS_MIN;
    t->slots = arena_malloc(t->slot_count, sizeof *t->slots);
    return t;
}

void lease_table_free(struct lease_table *t)
{
    for (size_t i = 0; i < t->count; i++)
        free(t->heap[i]);
    free(t->heap);
    free(t->slots);
    free(t);
}

size_t lease_count(const struct lease_table *t)
{
    return t->count;
}

struct lease *lease_at(const struct lease_table *t, size_t at)
{
    assert(at < t->count);
    return t->heap[at];
}

/* ---- the hash ---- */

/* Fibonacci hashing: D. Knuth, The Art of Computer Programming 3, 6.4. */
static size_t home_of(const struct lease_table *t, uint64_t id)
{
    return (size_t)(id * 0x9e3779b97f4a7c15u >> 32) & (t->slot_count - 1);
}

static size_t slot_of(const struct lease_table *t, uint64_t id) /* its slot, or the free one */
{
    size_t i = home_of(t, id);
    while (t->slots[i] && t->slots[i]->id != id)
        i = (i + 1) & (t->slot_count - 1);
    return i;
}

static void slots_grow(struct lease_table *t)
{
    free(t->slots);
    t->slot_count *= 2;
    t->slots = arena_malloc(t->slot_count, sizeof *t->slots);
    for (size_t i = 0; i < t->count; i++)
        t->slots[slot_of(t, t->heap[i]->id)] = t->heap[i];
}

/* Closes the gap, so that probing never stops early (Knuth 3, 6.4, algorithm R). */
static void slots_remove(struct lease_table *t, uint64_t id)
{
    const size_t mask = t->slot_count - 1;
    size_t gap = slot_of(t, id);
    assert(t->slots[gap]);
    for (size_t i = (gap + 1) & mask; t->slots[i]; i = (i + 1) & mask) {
        const size_t home = home_of(t, t->slots[i]->id);
        if (((i - home) & mask) < ((i - gap) & mask))
            continue; /* its probe begins behind the gap */
        t->slots[gap] = t->slots[i];
        gap = i;
    }
    t->slots[gap] = NULL;
}

/* ---- the heap ---- */

static void place(struct lease_table *t, struct lease *l, size_t at)
{
    t->heap[at] = l;
    l->at = at;
}

static void sift_up(struct lease_table *t, struct lease *l)
{
    size_t at = l->at;
    for (; at > 0 && t->heap[(at - 1) / 2]->deadline_ms > l->deadline_ms; at = (at - 1) / 2)
        place(t, t->heap[(at - 1) / 2], at);
    place(t, l, at);
}

static void sift_down(struct lease_table *t, struct lease *l)
{
    size_t at = l->at;
    for (size_t child; (child = 2 * at + 1) < t->count; at = child) {
        if (child + 1 < t->count &&
            t->heap[child + 1]->deadline_ms < t->heap[child]->deadline_ms)
            child++;
        if (t->heap[child]->deadline_ms >= l->deadline_ms)
            break;
        place(t, t->heap[child], at);
    }
    place(t, l, at);
}

/* ---- the table ---- */

struct lease *lease_grant(struct lease_table *t, struct job *job, uint32_t tile, uint32_t pass,
                          struct worker *worker, int64_t deadline_ms)
{
    struct lease *l = arena_malloc(1, sizeof *l);
    do
        l->id = t->nonce | ++t->last;
    while (l->id == 0 || lease_find(t, l->id)); /* after four thousand million of them */
    l->job = job;
    l->worker = worker;
    l->tile = tile;
    l->pass = pass;
    l->deadline_ms = deadline_ms;
    if (t->count == t->capacity) {
        t->capacity = t->capacity ? 2 * t->capacity : SLOTS_MIN;
        t->heap = arena_realloc(t->heap, t->capacity, sizeof *t->heap);
    }
    if (2 * (t->count + 1) > t->slot_count)
        slots_grow(t);
    t->slots[slot_of(t, l->id)] = l;
    place(t, l, t->count++);
    sift_up(t, l);
    return l;
}

struct lease *lease_find(const struct lease_table *t, uint64_t id)
{
    return t->slots[slot_of(t, id)];
}

void lease_renew(struct lease_table *t, struct lease *l, int64_t deadline_ms)
{
    l->deadline_ms = deadline_ms;
    sift_up(t, l);
    sift_down(t, l);
}

void lease_drop(struct lease_table *t, struct lease *l)
{
    slots_remove(t, l->id);
    struct lease *last = t->heap[--t->count];
    if (last != l) {
        place(t, last, l->at);
        sift_up(t, last);
        sift_down(t, last);
    }
    free(l);
}

struct lease *lease_first_due(const struct lease_table *t, int64_t now_ms)
{
    return t->count && t->heap[0]->deadline_ms <= now_ms ? t->heap[0] : NULL;
}

int64_t lease_next_deadline(const struct lease_table *t)
{
    return t->count ? t->heap[0]->deadline_ms : INT64_MAX;
}
