/* SPDX-License-Identifier: MIT */
#include "bench/race.h"

#include <math.h>
#include <stdlib.h>

#include "bench/ours.h"
#include "common/arena.h"
#include "common/clock.h"

/* Long enough that the caches another kernel left behind do not count, short enough that the
 * machine is the same for all. */
enum { SLICE = 1 << 17 };

static const double none = (double)NAN; /* a figure there is not */

const char *race_name(enum race_kernel k)
{
    static const char *const names[] = {"embree", "robust", "ours", "eights", "packets", "stream"};
    _Static_assert(countof(names) == RACE_KERNELS, "a name for each");
    return names[k];
}

static int compare(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return x < y ? -1 : x > y;
}

static double median(double *v, size_t n)
{
    qsort(v, n, sizeof *v, compare);
    return (v[(n - 1) / 2] + v[n / 2]) / 2;
}

/* --- building --- */

static void build_in_turn(struct race *race, double us[3][RACE_MOST_ROUNDS])
{
    for (uint32_t i = 0; i < race->builds; i++) {
        for (int k = 0; k < EMBREE_KINDS; k++)
            us[k][i] = race->embree[k] ? (double)embree_build(race->embree[k]) : none;
        us[RACE_OURS][i] = (double)ours_build(race->stage);
    }
}

void race_build(struct race *race, struct race_trees *trees)
{
    *trees = (struct race_trees){.sah = none};
    if (embree_version())
        for (int k = 0; k < EMBREE_KINDS; k++)
            race->embree[k] = embree_new(race->scene, (enum embree_kind)k);
    double us[3][RACE_MOST_ROUNDS], ratio[RACE_MOST_ROUNDS];
    build_in_turn(race, us);
    for (int k = 0; k < EMBREE_KINDS; k++) {
        for (uint32_t i = 0; i < race->builds; i++)
            ratio[i] = us[k][i] / us[RACE_OURS][i];
        trees->ratio[k] = median(ratio, race->builds);
    }
    for (int k = 0; k < 3; k++) {
        trees->seconds[k] = (double)INFINITY;
        for (uint32_t i = 0; i < race->builds; i++)
            trees->seconds[k] = us[k][i] < trees->seconds[k] ? us[k][i] : trees->seconds[k];
        trees->seconds[k] *= 1e-6;
    }
    const struct ours_tree ours = ours_tree(race->stage);
    const double triangles = (double)race->stage->prim_count;
    trees->sah_ours = ours.sah;
    trees->bytes[RACE_OURS] = (double)ours.bytes / triangles;
    for (int k = 0; k < EMBREE_KINDS; k++)
        trees->bytes[k] =
            race->embree[k] ? (double)embree_bytes(race->embree[k]) / triangles : none;
    if (embree_version() && race->sah)
        trees->sah = embree_sah(race->scene);
}

void race_release(struct race *race)
{
    for (int k = 0; k < EMBREE_KINDS; k++)
        if (race->embree[k])
            embree_free(race->embree[k]);
}

/* --- rays --- */

static void run(const struct race *race, enum race_kernel kernel, const struct shots *shots,
                struct shot_hit *hits)
{
    switch (kernel) {
    case RACE_EMBREE:
        embree_trace(race->embree[EMBREE_DEFAULT], EMBREE_SINGLE, shots, hits);
        return;
    case RACE_ROBUST:
        embree_trace(race->embree[EMBREE_ROBUST], EMBREE_SINGLE, shots, hits);
        return;
    case RACE_OURS:
        ours_trace(race->stage, shots, hits);
        return;
    case RACE_EIGHTS:
        ours_trace_eights(race->stage, shots, hits);
        return;
    case RACE_PACKETS:
        embree_trace(race->embree[EMBREE_DEFAULT], EMBREE_PACKETS, shots, hits);
        return;
    case RACE_STREAM:
        embree_trace(race->embree[EMBREE_DEFAULT], EMBREE_STREAM, shots, hits);
        return;
    case RACE_KERNELS:
        break;
    }
    __builtin_unreachable();
}

static bool takes_part(const struct race *race, int kernel, uint32_t round)
{
    return kernel == RACE_OURS || kernel == RACE_EIGHTS ||
           (race->embree[0] && round < (kernel < RACE_PACKETS ? race->rounds : race->info_rounds));
}

/* CPU us of each kernel in one round. */
static void run_round(const struct race *race, uint32_t round, const struct shots *shots,
                      struct shot_hit *hits[RACE_KERNELS], int64_t us[RACE_KERNELS])
{
    for (int k = 0; k < RACE_KERNELS; k++)
        us[k] = 0;
    uint32_t first = round;
    for (size_t at = 0; at < shots->count; at += SLICE, first++) {
        const struct shots slice = shots_slice(shots, at, at + SLICE);
        for (uint32_t i = 0; i < RACE_KERNELS; i++) {
            const int k = (int)((first + i) % RACE_KERNELS);
            if (!takes_part(race, k, round))
                continue;
            const int64_t begin = clock_thread_cpu_us();
            run(race, (enum race_kernel)k, &slice, hits[k] + at);
            us[k] += clock_thread_cpu_us() - begin;
        }
    }
}

static void compare_hits(const struct shot_hit *reference, const struct shot_hit *hits,
                         size_t count, double *other_hit, double *other_t)
{
    size_t different = 0, apart = 0;
    for (size_t i = 0; i < count; i++) {
        const bool a = reference[i].prim != SHOTS_MISS, b = hits[i].prim != SHOTS_MISS;
        different += a != b;
        apart += a && b && fabsf(hits[i].t - reference[i].t) > 1e-3f * reference[i].t;
    }
    *other_hit = (double)different / (double)count;
    *other_t = (double)apart / (double)count;
}

void race_run(const struct race *race, const struct shots *shots, struct race_rays *out)
{
    struct arena arena = {0};
    struct shot_hit *hits[RACE_KERNELS];
    for (int k = 0; k < RACE_KERNELS; k++)
        hits[k] = arena_new(&arena, struct shot_hit, shots->count);
    double ratio[2][RACE_MOST_ROUNDS], eights[2][RACE_MOST_ROUNDS];
    for (int k = 0; k < RACE_KERNELS; k++)
        out->rate[k] = out->other_hit[k] = out->other_t[k] = none;
    for (uint32_t round = 0; round < race->rounds; round++) {
        int64_t us[RACE_KERNELS];
        run_round(race, round, shots, hits, us);
        for (int k = 0; k < RACE_KERNELS; k++)
            if (us[k])
                out->rate[k] = fmax(out->rate[k], (double)shots->count / (double)us[k]);
        for (int k = 0; k < 2; k++) {
            ratio[k][round] = race->embree[k] ? (double)us[k] / (double)us[RACE_OURS] : none;
            eights[k][round] = race->embree[k] ? (double)us[k] / (double)us[RACE_EIGHTS] : none;
        }
    }
    for (int k = 0; k < 2; k++) {
        out->ratio[k] = median(ratio[k], race->rounds);
        out->eights[k] = median(eights[k], race->rounds);
    }
    for (int k = 0; k < RACE_KERNELS; k++)
        if (race->embree[0])
            compare_hits(hits[RACE_EMBREE], hits[k], shots->count, &out->other_hit[k],
                         &out->other_t[k]);
    arena_release(&arena);
}
