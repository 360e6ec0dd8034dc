/* convergence.c: which points are kept, that they outlast the coordinator, and what a lost film
 * does. SPDX-License-Identifier: MIT */
#include "server/convergence.h"

#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

#include "tests/fake_job.h"
#include "tests/tap.h"

static bool note(struct convergence *c, struct store *s, struct store_job *row, uint64_t samples,
                 double error)
{
    struct err err;
    row->samples = samples;
    row->error = error;
    return convergence_note(c, s, row, &err);
}

static void points(struct store *s, struct store_job *row)
{
    struct convergence c = {0}, again = {0};
    struct err err;
    ok(note(&c, s, row, 800, .5) && note(&c, s, row, 820, .49) && note(&c, s, row, 1600, .35) &&
           c.count == 2,
       "a point needs a twentieth more samples than the last");
    ok(note(&c, s, row, 1700, -1) && c.count == 2, "and a known error");
    row->state = JOB_DONE;
    ok(note(&c, s, row, 1601, .34) && c.count == 3, "but the last one is always kept");
    row->state = JOB_RUNNING;
    ok(convergence_load(&again, s, row->number, &err) && again.count == 3 &&
           again.points[2].samples == 1601 && again.points[1].error == .35,
       "they are read back in order");
    struct forecast f;
    ok(convergence_forecast(&again, .17, &f) && f.samples > 4000 && f.samples < 10000 &&
           f.low < f.samples && f.samples < f.high,
       "and say what half the error takes: %g samples", f.samples);
    ok(note(&again, s, row, 850, .5) && again.count == 2, "where a film was lost,");
    convergence_release(&again);
    ok(convergence_load(&again, s, row->number, &err) && again.count == 2,
       "what lies ahead of it is no longer true");
    convergence_release(&again);
    convergence_release(&c);
}

int main(void)
{
    char dir[] = "/tmp/smalti-test-curve-XXXXXX", path[64];
    struct err err = {.text = ""};
    struct store_job row = fake_job_row(10, 10, (struct scene_target){.spp = 64});
    if (!mkdtemp(dir))
        return 1;
    snprintf(path, sizeof path, "%s/a.db", dir);
    struct store *s = store_open(path, &err);
    struct convergence none;
    if (ok(s && store_job_add(s, &row, &err), "a store with a job %s", err.text)) {
        ok(convergence_load(&none, s, row.number, &err) && none.count == 0 &&
               !convergence_forecast(&none, .1, &(struct forecast){0}),
           "which has no points yet");
        points(s, &row);
    }
    store_close(s);
    unlink(path);
    rmdir(dir);
    return tap_done();
}
