/* The coordinator with workers that only pretend to trace: whatever is killed, lapses, comes late
 * or twice, the image is the same, and states go where docs/http.md says.
 * SPDX-License-Identifier: MIT */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <jansson.h>

#include "common/clock.h"
#include "tests/pretend.h"
#include "tests/tap.h"

static struct daemon d;
static char digest[65]; /* of the reference */

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
    pretend_submit(&d, id, SIDE, to_64);
    ok(pretend_job_is(&d, id, "queued"), "a new job is queued");
    ok(pretend_work_until(&d, id, "done"), "and is done when all its passes are delivered");
    json_t *root = pretend_job(&d, id);
    snprintf(digest, sizeof digest, "%s", pretend_text(json_object_get(root, "image"), "digest"));
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
    json_t *root = pretend_job(&d, id);
    const bool same = !strcmp(pretend_text(json_object_get(root, "image"), "digest"), digest) &&
                      json_integer_value(json_object_get(root, "samples")) == SIDE * SIDE * SPP;
    json_decref(root);
    return same;
}

static void killed(int times)
{
    char id[17];
    int restarts = 0;
    srand(7);
    pretend_submit(&d, id, SIDE, to_64);
    for (; restarts < times && !pretend_job_is(&d, id, "done"); restarts++) {
        pretend_work(&d, rand() % 12);
        clock_sleep_ms(rand() % 60);
        daemon_kill(&d);
        if (!start("30")) {
            ok(false, "the coordinator comes back after kill -9");
            return;
        }
    }
    ok(pretend_count(&d, id, NULL, "samples") > 0 || pretend_job_is(&d, id, "queued") ||
           restarts == times,
       "after %d times kill -9 the job goes on", restarts);
    ok(pretend_work_until(&d, id, "done") && same_image(id), "and ends with the same image");
}

static void stopped(void)
{
    char id[17];
    pretend_submit(&d, id, SIDE, to_64);
    pretend_work(&d, 21);
    const int64_t before = pretend_count(&d, id, NULL, "samples");
    ok(daemon_stop(&d) == 0 && start("30"), "SIGTERM ends it with status 0");
    ok(pretend_count(&d, id, NULL, "samples") == before && before > 0,
       "and no sample is lost: %lld", (long long)before);
    ok(pretend_work_until(&d, id, "done") && same_image(id), "the image is the same");
}

static void late(void)
{
    char id[17], result[16];
    pretend_submit(&d, id, SIDE, to_64);
    json_t *root = pretend_lease(&d, "w", 2, 0), *list = json_object_get(root, "leases");
    pretend_work(&d, 40); /* others go on meanwhile */
    daemon_kill(&d);
    if (!start("30"))
        return;
    pretend_work(&d, 6);
    const int status = pretend_deliver(&d, json_array_get(list, 0), result);
    ok(status == 200, "a result from before a restart is taken: %s", result);
    ok(pretend_deliver(&d, json_array_get(list, 0), result) == 200 && !strcmp(result, "duplicate"),
       "once: then it is a duplicate");
    ok(pretend_work_until(&d, id, "done") && same_image(id), "the image is the same");
    ok(pretend_deliver(&d, json_array_get(list, 1), result) == 409,
       "a result of an ended job is dropped");
    json_decref(root);
}

static void lapsed(void)
{
    char id[17], result[16], target[80];
    int status;
    daemon_stop(&d);
    if (!start("0.2"))
        return;
    pretend_submit(&d, id, SIDE, to_64);
    json_t *root = pretend_lease(&d, "gone", 3, 0), *list = json_object_get(root, "leases");
    json_t *parked = pretend_lease(&d, "w", 64, 0);
    for (const int64_t until = clock_ms() + 5000; clock_ms() < until; clock_sleep_ms(10))
        if (pretend_count(&d, id, "leases", "expired") >= 3)
            break;
    ok(pretend_count(&d, id, "leases", "expired") >= 3, "leases that are not renewed lapse");
    snprintf(target, sizeof target, "/v1/leases/%s/renew",
             pretend_text(json_array_get(list, 0), "lease"));
    json_t *renewed = pretend_ask(&d, &status, "POST", target, NULL);
    ok(status == 404, "a lapsed lease cannot be renewed");
    json_decref(renewed);
    ok(pretend_deliver(&d, json_array_get(list, 0), result) == 200 && !strcmp(result, "merged"),
       "but its result is taken when the pass is still missing");
    ok(pretend_work_until(&d, id, "done") && same_image(id), "the image is the same");
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
    pretend_submit(&d, id, 8, "{\"spp\": 8}");
    json_t *root = pretend_lease(&d, "w", 1, 0);
    const json_t *lease = json_array_get(json_object_get(root, "leases"), 0);
    snprintf(target, sizeof target, "/v1/leases/%s/renew", pretend_text(lease, "lease"));
    for (int i = 0; i < 10; i++) {
        clock_sleep_ms(100);
        json_decref(pretend_ask(&d, &status, "POST", target, NULL));
    }
    ok(status == 200 && pretend_count(&d, id, "leases", "expired") == 0,
       "a renewed lease does not lapse");
    snprintf(target, sizeof target, "/v1/leases/%s", pretend_text(lease, "lease"));
    json_decref(pretend_ask(&d, &status, "DELETE", target, NULL));
    ok(status == 204 && pretend_count(&d, id, "leases", "returned") == 1, "a lease is handed back");
    ok(pretend_work_until(&d, id, "done"), "and another worker has it at once");
    json_decref(root);
    daemon_stop(&d);
    start("30");
}

static void failing(void)
{
    char id[17], target[80];
    int status = 0;
    pretend_submit(&d, id, 8, "{\"spp\": 8}");
    for (int i = 0; i < 3; i++) {
        char name[16];
        snprintf(name, sizeof name, "bad%d", i);
        json_t *root = pretend_lease(&d, name, 1, 0);
        snprintf(target, sizeof target, "/v1/leases/%s",
                 pretend_text(json_array_get(json_object_get(root, "leases"), 0), "lease"));
        json_decref(pretend_ask(&d, &status, "DELETE", target,
                                "{\"reason\": \"disk full\", \"kind\": \"worker\"}"));
        json_decref(root);
    }
    json_t *root = pretend_job(&d, id);
    const json_t *failure = json_object_get(root, "failure");
    ok(status == 204 && !strcmp(pretend_text(root, "state"), "failed") &&
           strstr(pretend_text(failure, "reason"), "disk full") &&
           json_integer_value(json_object_get(failure, "pass")) == 0 &&
           json_array_size(json_object_get(failure, "rect")) == 4,
       "a pass that fails on three workers fails its job: %s", pretend_text(failure, "reason"));
    json_decref(root);
    pretend_submit(&d, id, 8, "{\"spp\": 8}");
    root = pretend_lease(&d, "w", 1, 0);
    snprintf(target, sizeof target, "/v1/leases/%s",
             pretend_text(json_array_get(json_object_get(root, "leases"), 0), "lease"));
    json_decref(pretend_ask(&d, &status, "DELETE", target,
                            "{\"reason\": \"mesh is empty\", \"kind\": \"input\"}"));
    ok(status == 204 && pretend_job_is(&d, id, "failed"),
       "a scene that cannot be prepared fails at once");
    json_decref(root);
}

static void states(void)
{
    char id[17], target[80], result[16];
    int status;
    pretend_submit(&d, id, SIDE, to_64);
    snprintf(target, sizeof target, "/v1/jobs/%s", id);
    json_t *root = pretend_lease(&d, "w", 1, 0);
    json_decref(pretend_ask(&d, &status, "PATCH", target, "{\"state\": \"paused\"}"));
    ok(status == 200 && pretend_job_is(&d, id, "paused") && pretend_work(&d, 1) == 0,
       "a paused job gives no leases");
    ok(pretend_deliver(&d, json_array_get(json_object_get(root, "leases"), 0), result) == 200 &&
           !strcmp(result, "merged"),
       "but takes what was out");
    json_decref(root);
    daemon_kill(&d);
    start("30");
    ok(pretend_job_is(&d, id, "paused"), "it is paused after a restart too");
    json_decref(
        pretend_ask(&d, &status, "PATCH", target, "{\"state\": \"running\", \"priority\": 7}"));
    ok(status == 200 && pretend_job_is(&d, id, "running") &&
           pretend_count(&d, id, NULL, "priority") == 7,
       "and runs when told to");
    json_decref(pretend_ask(&d, &status, "PATCH", target, "{\"state\": \"done\"}"));
    ok(status == 400, "other states cannot be set");
    pretend_work(&d, 20);
    for (const int64_t until = clock_ms() + 5000; clock_ms() < until; clock_sleep_ms(10))
        if (pretend_count(&d, id, "image", "version") > 0)
            break;
    json_decref(pretend_ask(&d, &status, "DELETE", target, NULL));
    ok(status == 200 && pretend_job_is(&d, id, "cancelled") && pretend_work(&d, 1) == 0,
       "a cancelled job gives no leases");
    json_decref(pretend_ask(&d, &status, "DELETE", target, NULL));
    ok(status == 200, "cancelling it again changes nothing");
    json_decref(pretend_ask(&d, &status, "PATCH", target, "{\"state\": \"running\"}"));
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
        pretend_submit(&d, id, SIDE, "{\"error\": 0.02}");
        same &= pretend_work_until(&d, id, "done");
        json_t *root = pretend_job(&d, id);
        const char *hex = pretend_text(json_object_get(root, "image"), "digest");
        same &=
            json_number_value(json_object_get(root, "error")) <= .02 && (!i || !strcmp(first, hex));
        snprintf(first, sizeof first, "%s", hex);
        json_decref(root);
    }
    ok(same, "an error target is met, and stops at the same place every time");
    pretend_submit(&d, id, SIDE, "{\"seconds\": 1}");
    const int64_t begin_ms = clock_ms();
    ok(pretend_work_until(&d, id, "done"), "a seconds target ends the job");
    const int64_t took_ms = clock_ms() - begin_ms;
    json_t *root = pretend_job(&d, id);
    const json_int_t spp =
        json_integer_value(json_object_get(json_object_get(root, "target"), "spp"));
    ok(spp >= 8 && spp % 8 == 0 && spp == json_integer_value(json_object_get(root, "spp")),
       "with a multiple of 8 samples: %lld, after %lld ms", (long long)spp, (long long)took_ms);
    char target[40], hex[65];
    snprintf(hex, sizeof hex, "%s", pretend_text(json_object_get(root, "image"), "digest"));
    json_decref(root);
    snprintf(target, sizeof target, "{\"spp\": %lld}", (long long)spp);
    pretend_submit(&d, id, SIDE, target);
    pretend_work_until(&d, id, "done");
    root = pretend_job(&d, id);
    ok(!strcmp(pretend_text(json_object_get(root, "image"), "digest"), hex),
       "and a job that asks for that many gives the same bytes");
    json_decref(root);
}

static void draining(void)
{
    int status;
    json_t *root = pretend_ask(&d, &status, "PATCH", "/v1/workers/w", "{\"state\": \"draining\"}");
    ok(status == 200 && !strcmp(pretend_text(root, "state"), "draining"),
       "a worker is told to drain");
    json_decref(root);
    root = pretend_lease(&d, "w", 1, 5000);
    ok(json_is_true(json_object_get(root, "drain")), "its next call says so at once");
    json_decref(root);
    json_decref(pretend_ask(&d, &status, "PATCH", "/v1/workers/w", "{\"state\": \"active\"}"));
    ok(status == 200, "and it may come back");
}

static void damaged_film(void)
{
    char id[17], path[400];
    pretend_submit(&d, id, SIDE, to_64);
    pretend_work(&d, 20);
    daemon_stop(&d);
    snprintf(path, sizeof path, "%s/state/jobs/%s/film", d.dir, id);
    ok(truncate(path, 1000) == 0, "a film is cut short");
    ok(start("30") && pretend_count(&d, id, NULL, "samples") == 0, "the job starts from zero");
    ok(pretend_work_until(&d, id, "done") && same_image(id), "and ends with the same image");
}

static void list(void)
{
    int status;
    json_t *root = pretend_ask(&d, &status, "GET", "/v1/jobs?limit=2", NULL);
    const char *next = pretend_text(root, "next");
    char target[80];
    snprintf(target, sizeof target, "/v1/jobs?limit=200&after=%s", next);
    json_t *rest = pretend_ask(&d, &status, "GET", target, NULL);
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
