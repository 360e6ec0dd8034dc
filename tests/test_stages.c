/* stages.c with a real loader, which finds all it needs in the cache: what is held stays, the rest
 * as far as there is room, in bytes and in number; mapped scenes count.
 * SPDX-License-Identifier: MIT */
#include "worker/stages.h"

#include <signal.h>
#include <stdlib.h>
#include <string.h>

#include "common/log.h"
#include "tests/shelf.h"
#include "tests/tap.h"

enum { SCENES = STAGES_MOST + 20 };

static struct shelf shelf;
static struct mailbox *done;

static struct stages_entry *hold(struct stages *s, int n)
{
    struct stages_entry *e = stages_hold(s, shelf_document(n), PLAN_REAL);
    if (e->loading)
        stages_loaded(s, mailbox_pop(done));
    return e;
}

static bool has(const struct stages *s, int n)
{
    const struct stages_entry *e = s->entries;
    while (e && strcmp(e->load->document, shelf_document(n)) != 0)
        e = e->next;
    return e;
}

static uint64_t count(const struct stages *s, uint64_t *bytes)
{
    uint64_t n = 0;
    *bytes = 0;
    for (const struct stages_entry *e = s->entries; e; e = e->next, n++)
        *bytes += loader_bytes(e->load);
    return n;
}

static void what_is_held_stays(struct stages *s)
{
    const uint64_t each = STAGEFILE_HEAD + shelf.stage->bytes;
    uint64_t bytes;
    s->most_bytes = 3 * each + each / 2;
    struct stages_entry *held = hold(s, 0);
    ok(held->load->done && held->load->stage == held->load->file.stage &&
           shelf_same(&shelf, &held->load->file) && held->load->arena.used_bytes == 0,
       "a scene that is in the cache is mapped, and takes no memory of ours");
    for (int n = 1; n < 10; n++)
        stages_drop(s, hold(s, n));
    ok(count(s, &bytes) == 3 && bytes == 3 * each, "mapped scenes count: there is room for three");
    ok(has(s, 0) && !has(s, 1) && has(s, 8) && has(s, 9), "those in use or used last are there");
    ok(hold(s, 0) == held, "one that is there is not loaded again");
    stages_drop(s, held);
    stages_drop(s, held);
    s->most_bytes = 0;
    stages_drop(s, hold(s, 1));
    ok(count(s, &bytes) == 0, "without room nothing is kept that is not held");
}

static void not_too_many(struct stages *s)
{
    uint64_t bytes;
    s->most_bytes = (uint64_t)1 << 40;
    for (int n = 0; n < SCENES; n++)
        stages_drop(s, hold(s, n));
    ok(count(s, &bytes) == STAGES_MOST, "small scenes are not kept without end");
}

int main(void)
{
    log_init("test_stages", LOG_ERROR);
    signal(SIGPIPE, SIG_IGN);
    shelf_init(&shelf);
    struct cache cache = shelf_cache(&shelf, (uint64_t)1 << 30);
    for (int n = 0; n < SCENES; n++) {
        struct stagefile f;
        if (!shelf_fill(&shelf, &cache, n, &f))
            abort();
        stagefile_close(&f);
    }
    const struct args args = {.server = "http://127.0.0.1:1"};
    struct err err;
    done = mailbox_new(SCENES, -1);
    struct stages stages = {.loader = loader_new(&args, &cache, SCENES, done, &err)};
    if (!stages.loader)
        abort();
    what_is_held_stays(&stages);
    not_too_many(&stages);
    ok(loader_stop(stages.loader, SHELF_LONG_MS), "the loader ends");
    stages_release(&stages);
    mailbox_free(done);
    shelf_release(&shelf);
    return tap_done();
}
