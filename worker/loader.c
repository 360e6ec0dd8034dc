/* SPDX-License-Identifier: MIT */
#include "worker/loader.h"

#include <malloc.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/clock.h"
#include "common/http_client.h"
#include "common/http_problem.h"
#include "common/log.h"
#include "common/scene_fill.h"
#include "common/trace/prep.h"
#include "worker/team.h"

enum {
    RETRY_FIRST_MS = 100,
    RETRY_MOST_MS = 5000,
    NAP_MS = 50,         /* how soon a stop is noticed between tries */
    PATIENCE_MS = 30000, /* with a worker that prepares our scene and shows no life */
};

struct loader {
    pthread_t thread;
    struct http_client *http;
    const struct cache *cache;
    uint32_t threads; /* to prepare with, as many as render */
    struct mailbox *todo, *done;
    atomic_bool stopped; /* the owner sets it */
    atomic_bool ended;   /* the thread sets it, last */
};

static bool download_once(struct loader *l, const char *hex, size_t max_bytes, struct buf *out,
                          struct err *err)
{
    char path[96], found[HASH_HEX];
    snprintf(path, sizeof path, "/v1/assets/%s", hex);
    const struct http_client_request r = {.method = "GET", .path = path, .max_bytes = max_bytes};
    struct http_client_reply reply;
    if (!http_client_run(l->http, &r, &reply, err))
        return false;
    bool good = reply.status == 200;
    if (!good) {
        char text[256];
        http_problem_text(reply.status, &reply.body, text, sizeof text);
        err_set(err, reply.status / 100 == 5 ? ERR_IO : ERR_NOT_FOUND, "%s", text);
    } else {
        hash_hex(reply.body.data ? reply.body.data : (const unsigned char *)"", reply.body.size,
                 found);
        good = !strcmp(found, hex) ||
               err_set(err, ERR_PROTOCOL, "the bytes that came have the SHA-256 %s", found);
    }
    if (good) {
        *out = reply.body;
        return true;
    }
    buf_release(&reply.body);
    return false;
}

static void nap(struct loader *l, int64_t ms)
{
    const int64_t until = clock_ms() + ms;
    while (!atomic_load(&l->stopped) && clock_ms() < until)
        clock_sleep_ms(NAP_MS);
}

/* `out` is empty and becomes the asset. */
static bool get_asset(struct loader *l, const char *hex, size_t max_bytes, struct buf *out,
                      struct err *err)
{
    if (cache_get(l->cache, hex, max_bytes, out))
        return true;
    buf_release(out);
    for (int64_t delay = RETRY_FIRST_MS;; delay = min_i64(2 * delay, RETRY_MOST_MS)) {
        if (download_once(l, hex, max_bytes, out, err)) {
            cache_put(l->cache, hex, out->data, out->size);
            return true;
        }
        if (err->code != ERR_IO || atomic_load(&l->stopped))
            return false;
        log_debug("asset_retry asset=%s reason=\"%s\"", hex, err->text);
        nap(l, delay);
    }
}

/* What a load needs on the way, all of it gone when the stage is there. */
struct workshop {
    struct arena scene, scratch;
    struct buf bytes;
};

static bool fault(struct load *load, const char *kind)
{
    load->fault_kind = kind;
    return false;
}

static bool load_document(struct loader *l, struct load *load, struct workshop *w,
                          struct scene *scene)
{
    if (!get_asset(l, load->document, SCENE_MAX_BYTES, &w->bytes, &load->err)) {
        err_at(&load->err, "document %s", load->document);
        return fault(load, "worker");
    }
    struct scene_errors errors = {0};
    if (scene_parse(scene, (const char *)w->bytes.data, w->bytes.size, SCENE_FROM_NET, &w->scene,
                    &errors))
        return true;
    err_set(&load->err, errors.list[0].code, "%s: %s", errors.list[0].where, errors.list[0].what);
    return fault(load, "input");
}

static bool get_for_scene(void *loader, const char *hex, size_t max_bytes, struct buf *out,
                          struct err *err)
{
    return get_asset(loader, hex, max_bytes, out, err);
}

static bool load_assets(struct loader *l, struct load *load, struct workshop *w,
                        struct scene *scene)
{
    const struct scene_fill from = {get_for_scene, l};
    switch (scene_fill(scene, &from, &w->scene, &load->err)) {
    case SCENE_FILL_DONE:
        return true;
    case SCENE_FILL_NOT_GOT:
        return fault(load, "worker");
    case SCENE_FILL_FAULTY:
        return fault(load, "input");
    }
    __builtin_unreachable();
}

/* Where the time went, and how the scene came to be here. */
struct story {
    const char *how; /* "mapped": it was in the cache; "prepared": now it is; "private" */
    int64_t wait_ms, load_ms, prepare_ms, share_ms;
};

static int64_t lap(int64_t *last_ms)
{
    const int64_t now_ms = clock_ms(), lap_ms = now_ms - *last_ms;
    *last_ms = now_ms;
    return lap_ms;
}

/* What preparing took and gave back, the system gets, too: glibc else keeps a hundred megabytes of
 * it, in pieces, for each worker that prepares a large scene. */
static void give_back_memory(void)
{
#ifdef __GLIBC__
    malloc_trim(0);
#endif
}

static bool prepare(struct loader *l, struct load *load, struct story *story, int64_t *last_ms)
{
    struct workshop w = {0};
    struct scene scene;
    if (atomic_load(&l->stopped)) {
        err_set(&load->err, ERR_IO, "the worker stops");
        return fault(load, "worker");
    }
    bool good = load_document(l, load, &w, &scene) && load_assets(l, load, &w, &scene);
    buf_release(&w.bytes);
    story->load_ms = lap(last_ms);
    struct team team = {.threads = l->threads};
    memcpy(team.what, load->document, sizeof team.what);
    const struct crew crew = team_crew(&team);
    if (good && !prep_stage(&scene, &crew, &load->arena, &w.scratch, &load->stage, &load->err))
        good = fault(load, "input");
    arena_release(&w.scene);
    arena_release(&w.scratch);
    story->prepare_ms = lap(last_ms);
    return good;
}

/* From our own memory into the file that all map, we too. */
static void share(struct load *load, struct stagefile_claim *claim, struct story *story)
{
    struct err err;
    if (!stagefile_publish(claim, load->stage, &load->file, &err)) {
        log_warn("scene_not_shared document=%.12s reason=\"%s\"", load->document, err.text);
        return;
    }
    load->stage = load->file.stage;
    arena_release(&load->arena);
    story->how = "prepared";
}

static void run_load(struct loader *l, struct load *load)
{
    const struct stagefile_ask ask = {l->cache, load->document, &l->stopped, PATIENCE_MS};
    struct stagefile_claim claim;
    struct story story = {.how = "private"};
    const int64_t begin_ms = clock_ms();
    int64_t last_ms = begin_ms;
    const enum stagefile_answer answer = stagefile_get(&ask, &load->file, &claim);
    story.wait_ms = lap(&last_ms);
    if (answer == STAGEFILE_MAPPED) {
        load->stage = load->file.stage;
        load->done = true;
        story.how = "mapped";
    } else {
        load->done = prepare(l, load, &story, &last_ms);
        give_back_memory();
        if (answer == STAGEFILE_CLAIMED && load->done)
            share(load, &claim, &story);
        else if (answer == STAGEFILE_CLAIMED)
            stagefile_unclaim(&claim);
        story.share_ms = lap(&last_ms);
    }
    if (load->done)
        log_info("scene_ready document=%.12s how=%s prims=%llu bytes=%llu ms=%lld wait_ms=%lld "
                 "load_ms=%lld prepare_ms=%lld share_ms=%lld",
                 load->document, story.how, (unsigned long long)load->stage->prim_count,
                 (unsigned long long)load->stage->bytes, (long long)(last_ms - begin_ms),
                 (long long)story.wait_ms, (long long)story.load_ms, (long long)story.prepare_ms,
                 (long long)story.share_ms);
}

uint64_t loader_bytes(const struct load *load)
{
    return load->file.map_bytes + load->arena.used_bytes;
}

void loader_release(struct load *load)
{
    stagefile_close(&load->file);
    arena_release(&load->arena);
    load->stage = NULL;
}

static void *run(void *user)
{
    struct loader *l = user;
    for (struct load *load; (load = mailbox_pop(l->todo));) {
        run_load(l, load);
        mailbox_push(l->done, load);
    }
    atomic_store(&l->ended, true);
    return NULL;
}

struct loader *loader_new(const struct args *args, const struct cache *cache, size_t room,
                          struct mailbox *done, struct err *err)
{
    struct http_client *http = http_client_new(args->server, err);
    if (!http)
        return NULL;
    struct loader *l = arena_malloc(1, sizeof *l);
    l->http = http;
    l->cache = cache;
    l->threads = args->threads;
    l->todo = mailbox_new(room, -1);
    l->done = done;
    atomic_init(&l->stopped, false);
    atomic_init(&l->ended, false);
    if (pthread_create(&l->thread, NULL, run, l))
        abort(); /* no thread: the machine is full */
    return l;
}

void loader_submit(struct loader *l, struct load *load)
{
    mailbox_push(l->todo, load);
}

bool loader_stop(struct loader *l, int64_t within_ms)
{
    atomic_store(&l->stopped, true);
    http_client_stop(l->http);
    mailbox_close(l->todo);
    const int64_t until = clock_ms() + within_ms;
    while (!atomic_load(&l->ended)) {
        if (clock_ms() > until)
            return false;
        clock_sleep_ms(5);
    }
    pthread_join(l->thread, NULL);
    for (struct load *load; (load = mailbox_try_pop(l->todo));)
        mailbox_push(l->done, load); /* never begun */
    mailbox_free(l->todo);
    http_client_free(l->http);
    free(l);
    return true;
}
