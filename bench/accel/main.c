/* bench-accel: the textbooks' structures beside smalti's: build time, memory, rays per second.
 *
 * Each on two kinds of scene (model.h) of 10^2 to 10^6 triangles (or up to the number given), the
 * same rays for all, half of them from the camera, half bounced; every hit compared with smalti's
 * to the last bit. One thread, CPU time, the best of ROUNDS. A structure that takes more than its
 * limits of memory and time gives up, with the reason. Writes CSV to stdout (docs/accel.md says
 * what the columns are) and how it goes to stderr; exits 1 when hits differ.
 * SPDX-License-Identifier: MIT */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "bench/accel/model.h"
#include "common/clock.h"

enum {
    ROUNDS = 3,
    PASSES = 128,
    SECOND = 1000000,       /* in us */
    BUILD_US = 20 * SECOND, /* of CPU time: the limit */
    PASS_US = 5 * SECOND,   /* the first pass must be done by then */
    ROUND_US = SECOND / 4,  /* no new pass after that */
    LOOK = 32,              /* rays between looks at the clock in the first pass */
};

#define BYTES_MAX ((uint64_t)1 << 30)

struct row {
    double build_s, mrays_s; /* 0: it gave up */
    uint64_t bytes;
    uint32_t rays, differ;
    char reason[64]; /* "" or why it gave up */
};

struct truth { /* what smalti finds */
    const struct ray *rays;
    const struct ray_hit *hits; /* all 0: nothing */
};

static uint32_t trace(const struct accel *a, const struct ray *rays, struct ray_hit *hits,
                      int64_t until_us)
{
    for (uint32_t i = 0; i < MODEL_PASS; i++) {
        hits[i] = (struct ray_hit){0};
        if (!accel_hit(a, &rays[i], &hits[i]))
            hits[i] = (struct ray_hit){0};
        if (i % LOOK == 0 && clock_thread_cpu_us() > until_us)
            return i;
    }
    return MODEL_PASS;
}

/* Rays per microsecond of one round. */
static double round_of(const struct accel *a, const struct truth *truth, struct row *row)
{
    struct ray_hit hits[MODEL_PASS];
    int64_t spent_us = 0;
    uint32_t rays = 0;
    for (uint32_t pass = 0; pass < PASSES && spent_us < ROUND_US; pass++) {
        const size_t at = (size_t)pass * MODEL_PASS;
        const int64_t begin_us = clock_thread_cpu_us();
        if (trace(a, truth->rays + at, hits, pass ? INT64_MAX : begin_us + PASS_US) < MODEL_PASS) {
            snprintf(row->reason, sizeof row->reason, "fewer than %d rays in %d s", MODEL_PASS,
                     PASS_US / SECOND);
            return 0;
        }
        spent_us += clock_thread_cpu_us() - begin_us;
        rays += MODEL_PASS;
        for (size_t i = 0; truth->hits && i < MODEL_PASS; i++)
            row->differ +=
                memcmp(&hits[i], &truth->hits[at + i], offsetof(struct ray_hit, place)) != 0;
    }
    row->rays += rays;
    return (double)rays / (double)(spent_us ? spent_us : 1);
}

/* The best of ROUNDS, too, unless that takes long. */
static bool build(struct accel *a, enum accel_kind kind, struct accel_mesh mesh, struct row *row)
{
    int64_t spent_us = 0;
    for (int i = 0; i < ROUNDS && spent_us < SECOND; i++) {
        const int64_t begin_us = clock_thread_cpu_us();
        const struct accel_limits limits = {BYTES_MAX, begin_us + BUILD_US};
        struct err err;
        if (i > 0)
            accel_release(a);
        if (!accel_build(a, kind, mesh, &limits, &err)) {
            snprintf(row->reason, sizeof row->reason, "build: %.50s", err.text);
            return false;
        }
        const int64_t took_us = clock_thread_cpu_us() - begin_us;
        row->build_s =
            i && row->build_s * 1e6 < (double)took_us ? row->build_s : (double)took_us * 1e-6;
        spent_us += took_us;
    }
    row->bytes = accel_bytes(a);
    return true;
}

static void measure(const struct accel *a, const struct truth *truth, struct row *row)
{
    for (int i = 0; i < ROUNDS && !row->reason[0]; i++) {
        const double rate = round_of(a, truth, row);
        row->mrays_s = rate > row->mrays_s ? rate : row->mrays_s;
    }
}

static void print_row(enum model_kind model, enum accel_kind kind, uint32_t triangles,
                      const struct row *row)
{
    printf("%s,%s,%u,", model_name(model), accel_name(kind), triangles);
    if (row->build_s > 0)
        printf("%.6f,%.1f,", row->build_s, (double)row->bytes / triangles);
    else
        printf(",,");
    if (row->mrays_s > 0)
        printf("%.6f", row->mrays_s);
    printf(",%u,%u,%s\n", row->rays, row->differ, row->reason);
    fflush(stdout);
    fprintf(stderr, "%-8s %-10s %8u triangles: build %8.3f s, %7.1f bytes each, %9.5f Mrays/s %s\n",
            model_name(model), accel_name(kind), triangles, row->build_s,
            (double)row->bytes / triangles, row->mrays_s, row->reason);
}

/* smalti's hits, which the others are held against. */
static const struct ray_hit *trace_all(const struct accel *ours, const struct ray *rays,
                                       struct arena *arena)
{
    struct ray_hit *hits = arena_new(arena, struct ray_hit, (size_t)PASSES * MODEL_PASS);
    for (size_t at = 0; at < (size_t)PASSES * MODEL_PASS; at += MODEL_PASS)
        trace(ours, rays + at, hits + at, INT64_MAX);
    return hits;
}

/* gave_up[k]: structure k did at a smaller size and is not tried again; without smalti's hits none
 * is. Returns hits that differ.
 */
static uint32_t compare(enum model_kind model, uint32_t triangles, bool gave_up[ACCEL_KINDS])
{
    struct arena arena = {0};
    struct truth truth = {0};
    const struct accel_mesh mesh = model_make(model, triangles, &arena);
    uint32_t differ = 0;
    for (int kind = 0; kind < ACCEL_KINDS; kind++) {
        struct accel a;
        struct row row = {0};
        if (gave_up[kind] || gave_up[ACCEL_OURS])
            continue;
        if (build(&a, (enum accel_kind)kind, mesh, &row)) {
            if (kind == ACCEL_OURS) {
                truth.rays = model_rays(model, &a, PASSES, &arena);
                truth.hits = trace_all(&a, truth.rays, &arena);
            }
            measure(&a, &truth, &row);
            accel_release(&a);
        }
        print_row(model, (enum accel_kind)kind, mesh.count, &row);
        gave_up[kind] = row.reason[0] != 0;
        differ += row.differ;
    }
    arena_release(&arena);
    return differ;
}

int main(int argc, char **argv)
{
    const unsigned long most = argc > 1 ? strtoul(argv[1], NULL, 10) : 1000000;
    uint32_t differ = 0;
    if (argc > 2 || most < 100 || most > 10000000) {
        fprintf(stderr, "usage: %s [TRIANGLES]: the largest size, 100 to 10000000\n", argv[0]);
        return 2;
    }
    puts("scene,structure,triangles,build_s,bytes_per_triangle,mrays_per_s,rays,differ,gave_up");
    for (int model = 0; model < MODEL_KINDS; model++) {
        bool gave_up[ACCEL_KINDS] = {false};
        for (uint32_t size = 100; size <= most; size *= 10)
            differ += compare((enum model_kind)model, size, gave_up);
    }
    if (differ)
        fprintf(stderr, "bench-accel: %u hits differ from smalti's\n", differ);
    return differ != 0;
}
