/* The coordinator with jobs whose blocks stop, and with workers that only pretend to trace: killed,
 * or asked for less error by and by, it ends with the same image, and leases that have become too
 * large are taken back. SPDX-License-Identifier: MIT */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <jansson.h>

#include "common/clock.h"
#include "tests/pretend.h"
#include "tests/tap.h"

enum { SIDE = 32 };

static struct daemon d;

static bool start(const char *tile)
{
    const char *const flags[] = {"--checkpoint", "0.05",  "--tile", tile, "--image-interval", "0",
                                 "--log",        "error", NULL};
    return daemon_start(&d, flags);
}

/* What has ended with an error target, so that it can be told apart: its digest, samples, stopped
 * share. */
struct ending {
    char digest[65];
    json_int_t samples;
    double stopped;
};

static struct ending ending_of(const char *id)
{
    struct ending e;
    json_t *root = pretend_job(&d, id), *report = json_object_get(root, "report");
    snprintf(e.digest, sizeof e.digest, "%s",
             pretend_text(json_object_get(root, "image"), "digest"));
    e.samples = json_integer_value(json_object_get(root, "samples"));
    e.stopped = json_number_value(json_object_get(report, "stopped"));
    json_decref(root);
    return e;
}

static bool endings_equal(const struct ending *a, const struct ending *b)
{
    return !strcmp(a->digest, b->digest) && a->samples == b->samples && a->stopped == b->stopped;
}

/* Blocks stop, in the coordinator's memory and in what it has written; the target may be moved. */
static void whatever_happens(void)
{
    static const char at_once[] = "{\"error\": 0.00203}";
    char id[17], target[64];
    int status;
    pretend_submit(&d, id, SIDE, at_once);
    ok(pretend_work_until(&d, id, "done"), "a job whose blocks stop is done");
    const struct ending want = ending_of(id);
    ok(want.stopped > .2 && want.stopped < 1, "%.0f %% of its pixels have stopped",
       100 * want.stopped);
    srand(11);
    pretend_submit(&d, id, SIDE, at_once);
    int restarts = 0;
    for (; restarts < 12 && !pretend_job_is(&d, id, "done"); restarts++) {
        pretend_work(&d, rand() % 20);
        clock_sleep_ms(rand() % 60);
        daemon_kill(&d);
        if (!start("8"))
            return;
    }
    bool same = pretend_work_until(&d, id, "done");
    struct ending e = ending_of(id);
    ok(same && endings_equal(&e, &want), "after %d times kill -9 it ends the same", restarts);
    pretend_submit(&d, id, SIDE, "{\"error\": 0.02}");
    same = pretend_work_until(&d, id, "done");
    snprintf(target, sizeof target, "/v1/jobs/%s", id);
    json_decref(pretend_ask(&d, &status, "PATCH", target, "{\"target\": {\"error\": 0.005}}"));
    same &= status == 200 && pretend_work_until(&d, id, "done");
    json_decref(pretend_ask(&d, &status, "PATCH", target, "{\"target\": {\"error\": 0.00203}}"));
    pretend_work(&d, 9);
    clock_sleep_ms(100);
    daemon_kill(&d);
    if (!start("8"))
        return;
    same &= status == 200 && pretend_work_until(&d, id, "done");
    e = ending_of(id);
    ok(same && endings_equal(&e, &want), "so it does when it was first asked for .02 and .005");
}

/* ---- leases ahead of a judgement ---- */

/* Takes all there is: delivers what is of the lowest pass, keeps the others. */
static void deliver_round(json_t *kept)
{
    json_t *root = pretend_lease(&d, "w", 64, 0), *list = json_object_get(root, "leases");
    json_int_t least = INT32_MAX;
    char result[16];
    for (size_t i = 0; i < json_array_size(list); i++) {
        const json_int_t pass =
            json_integer_value(json_object_get(json_array_get(list, i), "pass"));
        least = pass < least ? pass : least;
    }
    for (size_t i = 0; i < json_array_size(list); i++) {
        json_t *lease = json_array_get(list, i);
        if (json_integer_value(json_object_get(lease, "pass")) > least)
            json_array_append(kept, lease);
        else
            pretend_deliver(&d, lease, result);
    }
    json_decref(root);
}

/* Until one of them is no longer held: its place in the list; or -1. */
static int taken_back(const json_t *kept)
{
    for (const int64_t until = clock_ms() + 500; clock_ms() < until; clock_sleep_ms(10))
        for (size_t i = 0; i < json_array_size(kept); i++) {
            char target[80];
            int status;
            snprintf(target, sizeof target, "/v1/leases/%s/renew",
                     pretend_text(json_array_get(kept, i), "lease"));
            json_decref(pretend_ask(&d, &status, "POST", target, NULL));
            if (status == 404)
                return (int)i;
        }
    return -1;
}

static void deliver_all(const json_t *kept)
{
    char result[16];
    for (size_t i = 0; i < json_array_size(kept); i++)
        pretend_deliver(&d, json_array_get(kept, i), result);
}

/* tile: of 8 px, a lease is for all or nothing; of 16, for some of its blocks. */
static void too_large(const char *tile, const char *want)
{
    char id[17], result[16] = "";
    daemon_stop(&d);
    if (!start(tile))
        return;
    pretend_submit(&d, id, SIDE, "{\"error\": 0.00203}");
    json_t *kept = json_array();
    int at = -1;
    for (int round = 0; at < 0 && round < 12; round++) {
        deliver_round(kept);
        at = taken_back(kept);
        if (at < 0) {
            deliver_all(kept);
            json_array_clear(kept);
        }
    }
    ok(at >= 0, "tiles of %s px: a lease for blocks that have stopped is no longer held", tile);
    const int status = at < 0 ? -1 : pretend_deliver(&d, json_array_get(kept, (size_t)at), result);
    ok(status == 200 && !strcmp(result, want), "and what comes of it is %s: %d %s", want, status,
       result);
    deliver_all(kept);
    ok(pretend_work_until(&d, id, "done"), "the job goes on to its end");
    json_decref(kept);
}

int main(void)
{
    if (!ok(start("8"), "a coordinator starts"))
        return tap_done();
    whatever_happens();
    too_large("8", "duplicate");
    too_large("16", "stale");
    ok(daemon_stop(&d) == 0, "it stops with status 0");
    daemon_remove(&d);
    return tap_done();
}
