/* SPDX-License-Identifier: MIT */
#include "server/convergence.h"

#include <stdlib.h>

#include "common/arena.h"

enum {
    STEP = 20,
    RECENT = 32
}; /* points of the last factor of RECENT in samples tell of what comes */

void convergence_release(struct convergence *c)
{
    free(c->points);
    *c = (struct convergence){0};
}

static void add(void *context, const struct store_point *p)
{
    struct convergence *c = context;
    if (c->count == c->capacity) {
        c->capacity = c->capacity ? 2 * c->capacity : 16;
        c->points = arena_realloc(c->points, c->capacity, sizeof *c->points);
    }
    c->points[c->count++] = *p;
}

bool convergence_load(struct convergence *c, struct store *s, uint64_t number, struct err *err)
{
    *c = (struct convergence){0};
    if (store_points(s, number, add, c, err))
        return true;
    convergence_release(c);
    return false;
}

bool convergence_note(struct convergence *c, struct store *s, const struct store_job *row,
                      struct err *err)
{
    const bool last = row->state == JOB_DONE;
    /* A film that was lost begins anew, and so does its curve. */
    while (c->count && c->points[c->count - 1].samples > row->samples)
        c->count--;
    const uint64_t had = c->count ? c->points[c->count - 1].samples : 0;
    if (!(row->error >= 0) || row->samples == had || (!last && row->samples < had + had / STEP))
        return true;
    const struct store_point p = {
        .samples = row->samples,
        .spp = row->spp_done,
        .elapsed_ms = row->elapsed_ms,
        .cpu_us = row->cpu_us,
        .units = row->report.work.units,
        .error = row->error,
        .error_low = row->report.error_low,
        .error_high = row->report.error_high,
    };
    add(c, &p);
    return store_point_add(s, row->number, &p, err);
}

bool convergence_forecast(const struct convergence *c, double target, struct forecast *out)
{
    struct forecast_point recent[RECENT];
    size_t count = 0;
    if (!c->count)
        return false;
    const double all = (double)c->points[c->count - 1].samples;
    for (size_t i = c->count - min_size(c->count, RECENT); i < c->count; i++) {
        const struct store_point *p = &c->points[i];
        if (p->error > 0 && (double)p->samples * RECENT >= all)
            recent[count++] = (struct forecast_point){(double)p->samples, p->error};
    }
    if (!count)
        return false;
    *out = forecast_make(recent, count, target);
    return true;
}
