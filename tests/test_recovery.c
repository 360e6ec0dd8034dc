/* The coordinator with workers that only pretend to trace: whatever is killed, lapses, comes late
 * or twice, the image is the same, and states go where docs/http.md says.
 * SPDX-License-Identifier: MIT */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <jansson.h>

#include "common/clock.h"
#include "tests/daemon.h"
#include "tests/fake_job.h"
#include "tests/tap.h"

#define J "application/json"

static struct daemon d;
static char digest[65]; /* of the reference */

/* ---- requests; the caller owns what is returned ---- */

static json_t *ask(int *status, const char *method, const char *target, const char *body)
{
    struct answer a =
        daemon_call(&d, method, target, body ? J : NULL, body, body ? strlen(body) : 0);
    json_t *root = a.body ? json_loads(a.body, 0, NULL) : NULL;
    *status = a.status;
    buf_release(&a.text);
    return root ? root : json_object();
}

static const char *text_of(const json_t *root, const char *key)
{
    const char *text = json_string_value(json_object_get(root, key));
    return text ? text : "";
}

static void submit(char id[17], uint32_t side, const char *target)
{
    int status;
    json_t *root = ask(&status, "POST", "/v1/jobs", daemon_scene(side, target));
    if (status != 201) {
        char *text = json_dumps(root, 0);
        diag("submit: %d %s", status, text);
        free(text);
    }
    snprintf(id, 17, "%s", text_of(root, "id"));
    json_decref(root);
}

static json_t *job_of(const char *id)
{
    char target[64];
    int status;
    snprintf(target, sizeof target, "/v1/jobs/%s", id);
    return ask(&status, "GET", target, NULL);
}

static bool job_is(const char *id, const char *state)
{
    json_t *root = job_of(id);
    const bool same = !strcmp(text_of(root, "state"), state);
    json_decref(root);
    return same;
}

static int64_t count_of(const char *id, const char *group, const char *key)
{
    json_t *root = job_of(id);
    const json_t *at = group ? json_object_get(root, group) : root;
    const int64_t n = json_integer_value(json_object_get(at, key));
    json_decref(root);
    return n;
}

/* ---- a worker that pretends ---- */

static json_t *lease_call(const char *worker, int want, int wait_ms)
{
    char body[256];
    int status;
    snprintf(body, sizeof body,
             "{\"worker\": \"%s\", \"threads\": 1, \"version\": \"" SMALTI_VERSION
             "\", \"want\": %d, \"wait_ms\": %d}",
             worker, want, wait_ms);
    return ask(&status, "POST", "/v1/leases", body);
}

static int deliver_with(const json_t *lease, const char *worker, float noise, char result[16])
{
    struct arena arena = {0};
    struct buf payload = {0};
    struct wire_samples w = {.job = strtoull(text_of(lease, "job"), NULL, 16), .cpu_us = 500};
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
    fake_job_fill(&w.samples, noise);
    wire_encode(&w, &payload);
    char target[128];
    snprintf(target, sizeof target, "/v1/leases/%s?worker=%s&want=0", text_of(lease, "lease"),
             worker);
    struct answer a =
        daemon_call(&d, "PUT", target, "application/octet-stream", payload.data, payload.size);
    json_t *root = a.body ? json_loads(a.body, 0, NULL) : NULL;
    snprintf(result, 16, "%s", root ? text_of(root, "result") : "");
    const int status = a.status;
    json_decref(root);
    buf_release(&a.text);
    buf_release(&payload);
    arena_release(&arena);
    return status;
}

static int deliver(const json_t *lease, char result[16])
{
    return deliver_with(lease, "w", .5f, result);
}

/* Takes up to `most` leases in fours and delivers them, last first. How many were delivered. */
static int work(int most)
{
    int done = 0;
    while (done < most) {
        json_t *root = lease_call("w", most - done < 4 ? most - done : 4, 0);
        json_t *list = json_object_get(root, "leases");
        const size_t n = json_array_size(list);
        for (size_t i = n; i-- > 0; done++) {
            char result[16];
            deliver(json_array_get(list, i), result);
        }
        json_decref(root);
        if (!n)
            break;
    }
    return done;
}

static bool work_until(const char *id, const char *state)
{
    for (const int64_t until = clock_ms() + 20000; clock_ms() < until; clock_sleep_ms(5)) {
        work(1000);
        if (job_is(id, state))
            return true;
    }
    return false;
}

static bool start(const char *ttl)
{
    const char *const flags[] = {"--lease-ttl",      ttl, "--checkpoint", "0.05",  "--tile", "8",
                                 "--image-interval", "0", "--log",        "error", NULL};
    return daemon_start(&d, flags);
}

/* ---- the tests ---- */

enum { SIDE = 32, SPP = 64 };
static const char to_64[] = "{\"spp\": 64}";

static void reference(void)
{
    char id[17];
    submit(id, SIDE, to_64);
    ok(job_is(id, "queued"), "a new job is queued");
    ok(work_until(id, "done"), "and is done when all its passes are delivered");
    json_t *root = job_of(id);
    snprintf(digest, sizeof digest, "%s", text_of(json_object_get(root, "image"), "digest"));
    ok(strlen(digest) == 64, "the finished image has a digest");
    ok(json_integer_value(json_object_get(root, "samples")) == SIDE * SIDE * SPP &&
           json_integer_value(json_object_get(root, "spp")) == SPP &&
           json_number_value(json_object_get(root, "progress")) == 1 &&
           json_is_number(json_object_get(root, "error")),
       "status: all samples, all of the progress, an error");
    json_decref(root);
    char target[64];
    snprintf(target, sizeof target, "/v1/jobs/%s/document", id);
    struct answer a = daemon_call(&d, "GET", target, NULL, NULL, 0);
    ok(a.status == 200 && !strcmp(a.body, daemon_scene(SIDE, to_64)),
       "the document is the very bytes that came");
    buf_release(&a.text);
    snprintf(target, sizeof target, "/v1/jobs/%s/image.exr", id);
    a = daemon_call(&d, "GET", target, NULL, NULL, 0);
    ok(a.status == 200 && !memcmp(a.body, "\x76\x2f\x31\x01", 4), "the EXR is there");
    buf_release(&a.text);
    snprintf(target, sizeof target, "/v1/jobs/%s/preview.png", id);
    a = daemon_call(&d, "GET", target, NULL, NULL, 0);
    ok(a.status == 200 && !memcmp(a.body, "\x89PNG", 4), "and the PNG");
    buf_release(&a.text);
    snprintf(target, sizeof target, "/v1/jobs/%s", id);
    a = daemon_call(&d, "DELETE", target, NULL, NULL, 0);
    ok(a.status == 409, "a job that is done cannot be cancelled");
    buf_release(&a.text);
}

static bool same_image(const char *id)
{
    json_t *root = job_of(id);
    const bool same = !strcmp(text_of(json_object_get(root, "image"), "digest"), digest) &&
                      json_integer_value(json_object_get(root, "samples")) == SIDE * SIDE * SPP;
    json_decref(root);
    return same;
}

static void killed(int times)
{
    char id[17];
    int restarts = 0;
    srand(7);
    submit(id, SIDE, to_64);
    for (; restarts < times && !job_is(id, "done"); restarts++) {
        work(rand() % 12);
        clock_sleep_ms(rand() % 60);
        daemon_kill(&d);
        if (!start("30")) {
            ok(false, "the coordinator comes back after kill -9");
            return;
        }
    }
    ok(count_of(id, NULL, "samples") > 0 || job_is(id, "queued") || restarts == times,
       "after %d times kill -9 the job goes on", restarts);
    ok(work_until(id, "done") && same_image(id), "and ends with the same image");
}

static void stopped(void)
{
    char id[17];
    submit(id, SIDE, to_64);
    work(21);
    const int64_t before = count_of(id, NULL, "samples");
    ok(daemon_stop(&d) == 0 && start("30"), "SIGTERM ends it with status 0");
    ok(count_of(id, NULL, "samples") == before && before > 0, "and no sample is lost: %lld",
       (long long)before);
    ok(work_until(id, "done") && same_image(id), "the image is the same");
}

static void late(void)
{
    char id[17], result[16];
    submit(id, SIDE, to_64);
    json_t *root = lease_call("w", 2, 0), *list = json_object_get(root, "leases");
    work(40); /* others go on meanwhile */
    daemon_kill(&d);
    if (!start("30"))
        return;
    work(6);
    const int status = deliver(json_array_get(list, 0), result);
    ok(status == 200, "a result from before a restart is taken: %s", result);
    ok(deliver(json_array_get(list, 0), result) == 200 && !strcmp(result, "duplicate"),
       "once: then it is a duplicate");
    ok(work_until(id, "done") && same_image(id), "the image is the same");
    ok(deliver(json_array_get(list, 1), result) == 409, "a result of an ended job is dropped");
    json_decref(root);
}

static void lapsed(void)
{
    char id[17], result[16], target[80];
    int status;
    daemon_stop(&d);
    if (!start("0.2"))
        return;
    submit(id, SIDE, to_64);
    json_t *root = lease_call("gone", 3, 0), *list = json_object_get(root, "leases");
    json_t *parked = lease_call("w", 64, 0);
    for (const int64_t until = clock_ms() + 5000; clock_ms() < until; clock_sleep_ms(10))
        if (count_of(id, "leases", "expired") >= 3)
            break;
    ok(count_of(id, "leases", "expired") >= 3, "leases that are not renewed lapse");
    snprintf(target, sizeof target, "/v1/leases/%s/renew",
             text_of(json_array_get(list, 0), "lease"));
    json_t *renewed = ask(&status, "POST", target, NULL);
    ok(status == 404, "a lapsed lease cannot be renewed");
    json_decref(renewed);
    ok(deliver(json_array_get(list, 0), result) == 200 && !strcmp(result, "merged"),
       "but its result is taken when the pass is still missing");
    ok(work_until(id, "done") && same_image(id), "the image is the same");
    json_decref(root);
    json_decref(parked);
    daemon_stop(&d);
    start("30");
}

static void renewed(void)
{
    char id[17], target[80];
    int status = 0;
    daemon_stop(&d);
    if (!start("0.3"))
        return;
    submit(id, 8, "{\"spp\": 8}");
    json_t *root = lease_call("w", 1, 0);
    const json_t *lease = json_array_get(json_object_get(root, "leases"), 0);
    snprintf(target, sizeof target, "/v1/leases/%s/renew", text_of(lease, "lease"));
    for (int i = 0; i < 10; i++) {
        clock_sleep_ms(100);
        json_decref(ask(&status, "POST", target, NULL));
    }
    ok(status == 200 && count_of(id, "leases", "expired") == 0, "a renewed lease does not lapse");
    snprintf(target, sizeof target, "/v1/leases/%s", text_of(lease, "lease"));
    json_decref(ask(&status, "DELETE", target, NULL));
    ok(status == 204 && count_of(id, "leases", "returned") == 1, "a lease is handed back");
    ok(work_until(id, "done"), "and another worker has it at once");
    json_decref(root);
    daemon_stop(&d);
    start("30");
}

static void failing(void)
{
    char id[17], target[80];
    int status = 0;
    submit(id, 8, "{\"spp\": 8}");
    for (int i = 0; i < 3; i++) {
        char name[16];
        snprintf(name, sizeof name, "bad%d", i);
        json_t *root = lease_call(name, 1, 0);
        snprintf(target, sizeof target, "/v1/leases/%s",
                 text_of(json_array_get(json_object_get(root, "leases"), 0), "lease"));
        json_decref(
            ask(&status, "DELETE", target, "{\"reason\": \"disk full\", \"kind\": \"worker\"}"));
        json_decref(root);
    }
    json_t *root = job_of(id);
    const json_t *failure = json_object_get(root, "failure");
    ok(status == 204 && !strcmp(text_of(root, "state"), "failed") &&
           strstr(text_of(failure, "reason"), "disk full") &&
           json_integer_value(json_object_get(failure, "pass")) == 0 &&
           json_array_size(json_object_get(failure, "rect")) == 4,
       "a pass that fails on three workers fails its job: %s", text_of(failure, "reason"));
    json_decref(root);
    submit(id, 8, "{\"spp\": 8}");
    root = lease_call("w", 1, 0);
    snprintf(target, sizeof target, "/v1/leases/%s",
             text_of(json_array_get(json_object_get(root, "leases"), 0), "lease"));
    json_decref(
        ask(&status, "DELETE", target, "{\"reason\": \"mesh is empty\", \"kind\": \"input\"}"));
    ok(status == 204 && job_is(id, "failed"), "a scene that cannot be prepared fails at once");
    json_decref(root);
}

static void states(void)
{
    char id[17], target[80], result[16];
    int status;
    submit(id, SIDE, to_64);
    snprintf(target, sizeof target, "/v1/jobs/%s", id);
    json_t *root = lease_call("w", 1, 0);
    json_decref(ask(&status, "PATCH", target, "{\"state\": \"paused\"}"));
    ok(status == 200 && job_is(id, "paused") && work(1) == 0, "a paused job gives no leases");
    ok(deliver(json_array_get(json_object_get(root, "leases"), 0), result) == 200 &&
           !strcmp(result, "merged"),
       "but takes what was out");
    json_decref(root);
    daemon_kill(&d);
    start("30");
    ok(job_is(id, "paused"), "it is paused after a restart too");
    json_decref(ask(&status, "PATCH", target, "{\"state\": \"running\", \"priority\": 7}"));
    ok(status == 200 && job_is(id, "running") && count_of(id, NULL, "priority") == 7,
       "and runs when told to");
    json_decref(ask(&status, "PATCH", target, "{\"state\": \"done\"}"));
    ok(status == 400, "other states cannot be set");
    work(20);
    for (const int64_t until = clock_ms() + 5000; clock_ms() < until; clock_sleep_ms(10))
        if (count_of(id, "image", "version") > 0)
            break;
    json_decref(ask(&status, "DELETE", target, NULL));
    ok(status == 200 && job_is(id, "cancelled") && work(1) == 0, "a cancelled job gives no leases");
    json_decref(ask(&status, "DELETE", target, NULL));
    ok(status == 200, "cancelling it again changes nothing");
    json_decref(ask(&status, "PATCH", target, "{\"state\": \"running\"}"));
    ok(status == 409, "and it stays cancelled");
    snprintf(target, sizeof target, "/v1/jobs/%s/image.exr", id);
    struct answer a = daemon_call(&d, "GET", target, NULL, NULL, 0);
    ok(a.status == 200, "its image so far stays");
    buf_release(&a.text);
}

static void targets(void)
{
    char id[17], first[65] = "";
    bool same = true;
    for (int i = 0; i < 2; i++) {
        submit(id, SIDE, "{\"error\": 0.02}");
        same &= work_until(id, "done");
        json_t *root = job_of(id);
        const char *hex = text_of(json_object_get(root, "image"), "digest");
        same &=
            json_number_value(json_object_get(root, "error")) <= .02 && (!i || !strcmp(first, hex));
        snprintf(first, sizeof first, "%s", hex);
        json_decref(root);
    }
    ok(same, "an error target is met, and stops at the same place every time");
    submit(id, SIDE, "{\"seconds\": 1}");
    const int64_t begin_ms = clock_ms();
    ok(work_until(id, "done"), "a seconds target ends the job");
    const int64_t took_ms = clock_ms() - begin_ms;
    json_t *root = job_of(id);
    const json_int_t spp =
        json_integer_value(json_object_get(json_object_get(root, "target"), "spp"));
    ok(spp >= 8 && spp % 8 == 0 && spp == json_integer_value(json_object_get(root, "spp")),
       "with a multiple of 8 samples: %lld, after %lld ms", (long long)spp, (long long)took_ms);
    char target[40], hex[65];
    snprintf(hex, sizeof hex, "%s", text_of(json_object_get(root, "image"), "digest"));
    json_decref(root);
    snprintf(target, sizeof target, "{\"spp\": %lld}", (long long)spp);
    submit(id, SIDE, target);
    work_until(id, "done");
    root = job_of(id);
    ok(!strcmp(text_of(json_object_get(root, "image"), "digest"), hex),
       "and a job that asks for that many gives the same bytes");
    json_decref(root);
}

static void draining(void)
{
    int status;
    json_t *root = ask(&status, "PATCH", "/v1/workers/w", "{\"state\": \"draining\"}");
    ok(status == 200 && !strcmp(text_of(root, "state"), "draining"), "a worker is told to drain");
    json_decref(root);
    root = lease_call("w", 1, 5000);
    ok(json_is_true(json_object_get(root, "drain")), "its next call says so at once");
    json_decref(root);
    json_decref(ask(&status, "PATCH", "/v1/workers/w", "{\"state\": \"active\"}"));
    ok(status == 200, "and it may come back");
}

static void damaged_film(void)
{
    char id[17], path[400];
    submit(id, SIDE, to_64);
    work(20);
    daemon_stop(&d);
    snprintf(path, sizeof path, "%s/state/jobs/%s/film", d.dir, id);
    ok(truncate(path, 1000) == 0, "a film is cut short");
    ok(start("30") && count_of(id, NULL, "samples") == 0, "the job starts from zero");
    ok(work_until(id, "done") && same_image(id), "and ends with the same image");
}

static void list(void)
{
    int status;
    json_t *root = ask(&status, "GET", "/v1/jobs?limit=2", NULL);
    const char *next = text_of(root, "next");
    char target[80];
    snprintf(target, sizeof target, "/v1/jobs?limit=200&after=%s", next);
    json_t *rest = ask(&status, "GET", target, NULL);
    ok(json_array_size(json_object_get(root, "jobs")) == 2 && strlen(next) == 16 &&
           json_array_size(json_object_get(rest, "jobs")) >= 5 &&
           json_is_null(json_object_get(rest, "next")),
       "the list of jobs comes in pages");
    json_decref(rest);
    json_decref(root);
}

static void two_daemons(void)
{
    struct daemon second = d;
    const char *const flags[] = {"--log", "error", NULL};
    ok(!daemon_start(&second, flags), "a second coordinator does not share the state directory");
    daemon_kill(&second);
    ok(daemon_lives(&d), "and the first one lives");
}

int main(void)
{
    if (!ok(start("30"), "a coordinator starts"))
        return tap_done();
    reference();
    killed(20);
    stopped();
    late();
    lapsed();
    renewed();
    failing();
    states();
    targets();
    draining();
    damaged_film();
    list();
    two_daemons();
    ok(daemon_stop(&d) == 0, "it stops with status 0");
    daemon_remove(&d);
    return tap_done();
}
