/* SPDX-License-Identifier: MIT */
#include "worker/stages.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "common/log.h"

static uint64_t bytes_of(const struct stages_entry *e)
{
    return e->loading ? 0 : loader_bytes(e->load);
}

static void remove_entry(struct stages *s, struct stages_entry *e)
{
    struct stages_entry **at = &s->entries;
    while (*at != e)
        at = &(*at)->next;
    *at = e->next;
    loader_release(e->load);
    free(e->load);
    free(e);
}

void stages_release(struct stages *s)
{
    while (s->entries) {
        assert(!s->entries->loading && !s->entries->holders);
        remove_entry(s, s->entries);
    }
}

/* Unused scenes go, the longest unused first, until the rest has room. */
static void evict(struct stages *s)
{
    for (;;) {
        uint64_t bytes = 0, count = 0;
        struct stages_entry *oldest = NULL;
        for (struct stages_entry *e = s->entries; e; e = e->next) {
            bytes += bytes_of(e);
            count++;
            if (!e->holders && !e->loading && (!oldest || e->used < oldest->used))
                oldest = e;
        }
        if ((bytes <= s->most_bytes && count <= STAGES_MOST) || !oldest)
            return;
        log_debug("scene_evict document=%.12s bytes=%llu", oldest->load->document,
                  (unsigned long long)bytes_of(oldest));
        remove_entry(s, oldest);
    }
}

/* As it is prepared is how this method has it. */
static enum plan_candidate_kind usual(enum plan_candidate_kind method)
{
    return method == PLAN_PATH_MIS ? PLAN_REAL : method;
}

struct stages_entry *stages_hold(struct stages *s, const char document[HASH_HEX],
                                 enum plan_candidate_kind method)
{
    struct stages_entry *e = s->entries;
    while (e && (strcmp(e->load->document, document) != 0 || e->load->method != usual(method)))
        e = e->next;
    if (!e) {
        e = arena_malloc(1, sizeof *e);
        e->load = arena_malloc(1, sizeof *e->load);
        memcpy(e->load->document, document, HASH_HEX);
        e->load->method = usual(method);
        e->loading = true;
        e->next = s->entries;
        s->entries = e;
        loader_submit(s->loader, e->load);
    }
    e->holders++;
    e->used = ++s->holds;
    return e;
}

static void settle(struct stages *s, struct stages_entry *e)
{
    if (e->holders || e->loading)
        return;
    if (!e->load->done)
        remove_entry(s, e);
    else
        evict(s);
}

void stages_drop(struct stages *s, struct stages_entry *e)
{
    assert(e->holders);
    e->holders--;
    settle(s, e);
}

void stages_loaded(struct stages *s, struct load *load)
{
    struct stages_entry *e = s->entries;
    while (e->load != load)
        e = e->next;
    e->loading = false;
    settle(s, e);
}
