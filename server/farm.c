/* SPDX-License-Identifier: MIT */
#include "server/farm.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/arena.h"

enum { LEAST_PATIENCE_MS = 40000 /* a poll may take 25 s */, DAY_MS = 24 * 3600 * 1000 };

void farm_init(struct farm *f, int64_t lease_ttl_ms)
{
    *f = (struct farm){.patience_ms = max_i64(2 * lease_ttl_ms, LEAST_PATIENCE_MS)};
}

void farm_release(struct farm *f)
{
    for (size_t i = 0; i < f->count; i++)
        free(f->workers[i]);
    free(f->workers);
}

bool farm_name_is_sane(const char *name)
{
    const size_t n = strspn(name, "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789._-");
    return n >= 1 && n < FARM_NAME && name[n] == '\0';
}

static size_t place_of(const struct farm *f, const char *name) /* the first one not before it */
{
    size_t begin = 0, end = f->count;
    while (begin < end) {
        const size_t mid = (begin + end) / 2;
        if (strcmp(f->workers[mid]->name, name) < 0)
            begin = mid + 1;
        else
            end = mid;
    }
    return begin;
}

struct worker *farm_find(const struct farm *f, const char *name)
{
    const size_t at = place_of(f, name);
    return at < f->count && !strcmp(f->workers[at]->name, name) ? f->workers[at] : NULL;
}

struct worker *farm_call(struct farm *f, const char *name, int64_t now_ms)
{
    struct worker *w = farm_find(f, name);
    if (!w && f->count == FARM_MAX_WORKERS)
        return NULL;
    if (!w) {
        if (f->count == f->capacity) {
            f->capacity = f->capacity ? 2 * f->capacity : 16;
            f->workers = arena_realloc(f->workers, f->capacity, sizeof *f->workers);
        }
        const size_t at = place_of(f, name);
        memmove(f->workers + at + 1, f->workers + at, (f->count - at) * sizeof *f->workers);
        w = f->workers[at] = arena_malloc(1, sizeof *w);
        f->count++;
        snprintf(w->name, sizeof w->name, "%s", name);
        w->threads = 1;
        w->number = ++f->last_number;
    }
    w->seen_ms = now_ms;
    return w;
}

bool farm_is_lost(const struct farm *f, const struct worker *w, int64_t now_ms)
{
    return !w->parked && now_ms - w->seen_ms > f->patience_ms;
}

size_t farm_present(const struct farm *f, int64_t now_ms)
{
    size_t n = 0;
    for (size_t i = 0; i < f->count; i++)
        n += !farm_is_lost(f, f->workers[i], now_ms);
    return n;
}

void farm_forget(struct farm *f, int64_t now_ms)
{
    size_t kept = 0;
    for (size_t i = 0; i < f->count; i++) {
        struct worker *w = f->workers[i];
        if (w->leases || w->parked || now_ms - w->seen_ms < DAY_MS)
            f->workers[kept++] = w;
        else
            free(w);
    }
    f->count = kept;
}
