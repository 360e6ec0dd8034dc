/* SPDX-License-Identifier: MIT */
#include "worker/loader.h"

#include <pthread.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/clock.h"
#include "common/http_client.h"
#include "common/log.h"
#include "common/mesh.h"
#include "common/http_problem.h"
#include "common/trace/prep.h"

enum {
    RETRY_FIRST_MS = 100,
    RETRY_MOST_MS = 5000,
    NAP_MS = 50, /* how soon a stop is noticed between tries */
};

#define ASSET_MAX_BYTES ((size_t)2 << 30)

struct loader {
    pthread_t thread;
    struct http_client *http;
    const struct cache *cache;
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
            return err_at(err, "asset %s", hex);
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
    if (!get_asset(l, load->document, SCENE_MAX_BYTES, &w->bytes, &load->err))
        return fault(load, "worker");
    struct scene_errors errors = {0};
    if (scene_parse(scene, (const char *)w->bytes.data, w->bytes.size, SCENE_FROM_NET, &w->scene,
                    &errors))
        return true;
    err_set(&load->err, errors.list[0].code, "%s: %s", errors.list[0].where, errors.list[0].what);
    return fault(load, "input");
}

static bool load_meshes(struct loader *l, struct load *load, struct workshop *w,
                        struct scene *scene)
{
    for (uint32_t i = 0; i < scene->mesh_count; i++) {
        struct mesh *mesh = &scene->meshes[i];
        if (mesh->format == MESH_INLINE)
            continue;
        buf_release(&w->bytes);
        if (!get_asset(l, mesh->asset, ASSET_MAX_BYTES, &w->bytes, &load->err))
            return fault(load, "worker");
        if (!mesh_read(mesh, w->bytes.data, w->bytes.size, &w->scene, &load->err)) {
            err_at(&load->err, "asset %s", mesh->asset);
            return fault(load, "input");
        }
    }
    return true;
}

static void run_load(struct loader *l, struct load *load)
{
    struct workshop w = {0};
    struct scene scene;
    const int64_t begin_ms = clock_ms();
    bool good = load_document(l, load, &w, &scene) && load_meshes(l, load, &w, &scene);
    buf_release(&w.bytes);
    const int64_t loaded_ms = clock_ms();
    if (good && !prep_stage(&scene, NULL, &load->arena, &w.scratch, &load->stage, &load->err))
        good = fault(load, "input");
    load->done = good;
    arena_release(&w.scene);
    arena_release(&w.scratch);
    if (good)
        log_info("scene_ready document=%.12s prims=%llu bytes=%llu load_ms=%lld prepare_ms=%lld",
                 load->document, (unsigned long long)load->stage->prim_count,
                 (unsigned long long)load->stage->bytes, (long long)(loaded_ms - begin_ms),
                 (long long)(clock_ms() - loaded_ms));
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
