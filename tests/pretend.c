/* SPDX-License-Identifier: MIT */
#include "tests/pretend.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <jansson.h>

#include "common/clock.h"
#include "tests/fake_job.h"
#include "tests/tap.h"

/* ---- requests; the caller owns what is returned ---- */

json_t *pretend_ask(const struct daemon *d, int *status, const char *method, const char *target,
                    const char *body)
{
    struct answer a = daemon_call(d, method, target, body ? "application/json" : NULL, body,
                                  body ? strlen(body) : 0);
    json_t *root = a.body ? json_loads(a.body, 0, NULL) : NULL;
    *status = a.status;
    buf_release(&a.text);
    return root ? root : json_object();
}

const char *pretend_text(const json_t *root, const char *key)
{
    const char *text = json_string_value(json_object_get(root, key));
    return text ? text : "";
}

void pretend_submit(const struct daemon *d, char id[17], uint32_t side, const char *target)
{
    int status;
    json_t *root = pretend_ask(d, &status, "POST", "/v1/jobs", daemon_scene(side, target));
    if (status != 201) {
        char *text = json_dumps(root, 0);
        diag("submit: %d %s", status, text);
        free(text);
    }
    snprintf(id, 17, "%s", pretend_text(root, "id"));
    json_decref(root);
}

json_t *pretend_job(const struct daemon *d, const char *id)
{
    char target[64];
    int status;
    snprintf(target, sizeof target, "/v1/jobs/%s", id);
    return pretend_ask(d, &status, "GET", target, NULL);
}

bool pretend_job_is(const struct daemon *d, const char *id, const char *state)
{
    json_t *root = pretend_job(d, id);
    const bool same = !strcmp(pretend_text(root, "state"), state);
    json_decref(root);
    return same;
}

int64_t pretend_count(const struct daemon *d, const char *id, const char *group, const char *key)
{
    json_t *root = pretend_job(d, id);
    const json_t *at = group ? json_object_get(root, group) : root;
    const int64_t n = json_integer_value(json_object_get(at, key));
    json_decref(root);
    return n;
}

/* ---- a worker that pretends ---- */

json_t *pretend_lease(const struct daemon *d, const char *worker, int want, int wait_ms)
{
    char body[256];
    int status;
    snprintf(body, sizeof body,
             "{\"worker\": \"%s\", \"threads\": 1, \"version\": \"" SMALTI_VERSION
             "\", \"want\": %d, \"wait_ms\": %d}",
             worker, want, wait_ms);
    return pretend_ask(d, &status, "POST", "/v1/leases", body);
}

int pretend_deliver_with(const struct daemon *d, const json_t *lease, const char *worker,
                         float noise, char result[16])
{
    struct arena arena = {0};
    struct buf payload = {0};
    struct wire_samples w = {.job = strtoull(pretend_text(lease, "job"), NULL, 16), .cpu_us = 500};
    json_int_t tile, pass, x0, y0, x1, y1, s0, s1;
    json_t *copy = json_deep_copy(lease);
    const int bad = json_unpack(copy, "{s:I, s:I, s:[I,I,I,I], s:[I,I]}", "tile", &tile, "pass",
                                &pass, "rect", &x0, &y0, &x1, &y1, "samples", &s0, &s1);
    json_decref(copy);
    if (bad)
        return -1;
    w.tile = (uint32_t)tile;
    w.pass = (uint32_t)pass;
    w.samples = film_samples_make(
        (struct tile_rect){(uint32_t)x0, (uint32_t)y0, (uint32_t)x1, (uint32_t)y1},
        (struct tile_pass){(uint32_t)s0, (uint32_t)s1}, &arena);
    const json_t *blocks = json_object_get(lease, "blocks");
    struct block_set active;
    if (blocks && !block_set_parse(&active, block_count(w.samples.rect), json_string_value(blocks)))
        return -1;
    if (blocks)
        film_samples_restrict(&w.samples, &active);
    fake_job_fill(&w.samples, noise);
    wire_encode(&w, &payload);
    char target[128];
    snprintf(target, sizeof target, "/v1/leases/%s?worker=%s&want=0", pretend_text(lease, "lease"),
             worker);
    struct answer a =
        daemon_call(d, "PUT", target, "application/octet-stream", payload.data, payload.size);
    json_t *root = a.body ? json_loads(a.body, 0, NULL) : NULL;
    snprintf(result, 16, "%s", root ? pretend_text(root, "result") : "");
    const int status = a.status;
    json_decref(root);
    buf_release(&a.text);
    buf_release(&payload);
    arena_release(&arena);
    return status;
}

int pretend_deliver(const struct daemon *d, const json_t *lease, char result[16])
{
    return pretend_deliver_with(d, lease, "w", .5f, result);
}

/* Takes up to `most` leases in fours and delivers them, last first. How many were delivered. */
int pretend_work(const struct daemon *d, int most)
{
    int done = 0;
    while (done < most) {
        json_t *root = pretend_lease(d, "w", most - done < 4 ? most - done : 4, 0);
        json_t *list = json_object_get(root, "leases");
        const size_t n = json_array_size(list);
        for (size_t i = n; i-- > 0; done++) {
            char result[16];
            pretend_deliver(d, json_array_get(list, i), result);
        }
        json_decref(root);
        if (!n)
            break;
    }
    return done;
}

bool pretend_work_until(const struct daemon *d, const char *id, const char *state)
{
    for (const int64_t until = clock_ms() + 20000; clock_ms() < until; clock_sleep_ms(5)) {
        pretend_work(d, 1000);
        if (pretend_job_is(d, id, state))
            return true;
    }
    return false;
}
