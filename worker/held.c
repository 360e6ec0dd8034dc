/* SPDX-License-Identifier: MIT */
#include "worker/held.h"

#include <assert.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

struct pass *held_find(const struct held *h, const char *id)
{
    struct pass *p = h->first;
    while (p && strcmp(p->lease.id, id) != 0)
        p = p->next;
    return p;
}

uint32_t held_count(const struct held *h, enum pass_state from, enum pass_state to)
{
    uint32_t n = 0;
    for (const struct pass *p = h->first; p; p = p->next)
        n += p->state >= from && p->state <= to;
    return n;
}

void held_remove(struct held *h, struct pass *pass)
{
    assert(pass->state != PASS_POOLED);
    struct pass **at = &h->first;
    while (*at != pass)
        at = &(*at)->next;
    *at = pass->next;
    if (pass->held)
        stages_drop(&h->stages, pass->held);
    buf_release(&pass->payload);
    free(pass);
}

void held_return(struct pass *p, const char *kind, const char *reason)
{
    p->state = PASS_RETURN;
    p->fault_kind = kind;
    snprintf(p->fault, sizeof p->fault, "%s", reason);
}

static bool inside(struct tile_rect r, const struct scene_film *f)
{
    return r.x_begin >= f->crop_x_begin && r.x_end <= f->crop_x_end &&
           r.y_begin >= f->crop_y_begin && r.y_end <= f->crop_y_end;
}

/* A WAITING pass, whose scene may have become ready. */
static void advance(struct held *h, struct pass *p)
{
    const struct load *load = p->held->load;
    if (p->held->loading)
        return;
    if (!load->done) {
        held_return(p, load->fault_kind, load->err.text);
        return;
    }
    if (!p->lease.plan && !inside(p->lease.rect, &load->stage->film)) {
        held_return(p, "worker", "the lease's rectangle is outside the document's crop window");
        return;
    }
    p->stage = load->stage;
    p->state = PASS_POOLED;
    pool_submit(h->pool, p);
}

static struct pass *append(struct held *h, const struct link_lease *lease)
{
    struct pass *p = arena_malloc(1, sizeof *p);
    p->lease = *lease;
    p->state = PASS_WAITING;
    atomic_init(&p->abandon, false);
    struct pass **last = &h->first;
    while (*last)
        last = &(*last)->next;
    *last = p;
    return p;
}

void held_accept(struct held *h, const struct link_lease *lease, int64_t now_ms)
{
    if (held_find(h, lease->id))
        return; /* granted twice: one is enough */
    struct pass *p = append(h, lease);
    p->renew_ms = now_ms + lease->ttl_ms / 3;
    p->held = stages_hold(&h->stages, lease->document, lease->method);
    advance(h, p);
}

void held_decline(struct held *h, const struct link_lease *lease)
{
    if (!held_find(h, lease->id))
        held_return(append(h, lease), NULL, "");
}

void held_loaded(struct held *h, struct load *load)
{
    stages_loaded(&h->stages, load);
    for (struct pass *p = h->first; p; p = p->next)
        if (p->state == PASS_WAITING)
            advance(h, p);
}

void held_rendered(struct held *h, struct pass *p)
{
    h->cpu_us += p->cpu_us;
    p->state = PASS_DONE;
    if (p->forget)
        held_remove(h, p);
    else if (!p->finished)
        held_return(p, NULL, "");
}

void held_forget(struct held *h, struct pass *p)
{
    assert(p->state == PASS_WAITING || p->state == PASS_POOLED);
    if (p->state == PASS_WAITING) {
        held_remove(h, p);
        return;
    }
    p->forget = true;
    atomic_store(&p->abandon, true);
}

void held_abandon(struct pass *p)
{
    if (p->state == PASS_POOLED)
        atomic_store(&p->abandon, true);
    else if (p->state == PASS_WAITING)
        held_return(p, NULL, "");
}

void held_abandon_unbegun(struct held *h)
{
    for (struct pass *p; (p = pool_take_back(h->pool));)
        held_rendered(h, p);
    for (struct pass *p = h->first; p; p = p->next)
        if (p->state == PASS_WAITING)
            held_return(p, NULL, "");
}
