/* Each task runs once, whatever the number of threads; the stage is the same bytes.
 * SPDX-License-Identifier: MIT */
#include "worker/team.h"

#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

#include "common/trace/prep.h"
#include "tests/soup.h"
#include "tests/stat/stat.h"
#include "tests/tap.h"

enum { TASKS = 1000 };

static void count(void *arg, uint32_t i)
{
    atomic_fetch_add((atomic_uint *)arg + i, 1);
}

static void test_once(uint32_t threads)
{
    static atomic_uint runs[TASKS];
    struct team team = {.threads = threads, .what = "test"};
    const struct crew crew = team_crew(&team);
    for (int i = 0; i < TASKS; i++)
        atomic_store(&runs[i], 0);
    crew_run(&crew, count, runs, TASKS);
    crew_run(&crew, count, runs, 0);
    int wrong = 0;
    for (int i = 0; i < TASKS; i++)
        wrong += atomic_load(&runs[i]) != 1;
    ok(wrong == 0, "%u threads run each of %d tasks once", threads, TASKS);
}

static const struct stage *prepare(struct scenes *s, uint32_t threads, struct arena *arena)
{
    struct team team = {.threads = threads, .what = "test"};
    const struct crew crew = team_crew(&team);
    struct arena scratch = {0};
    const struct stage *stage = NULL;
    struct err err;
    if (!prep_stage(&s->scene, &crew, arena, &scratch, &stage, &err))
        abort();
    arena_release(&scratch);
    return stage;
}

/* Enough triangles for a plan of many parts. */
static void test_same_stage(void)
{
    enum { COUNT = 300000 };
    struct scenes s;
    scenes_init(&s, 1, 1);
    struct dice d = dice_make(3);
    float(*v)[3] = soup_vertices(&s, COUNT);
    for (uint32_t i = 0; i < COUNT; i++) {
        const vec3 at = soup_point(&d, 1);
        for (uint32_t k = 0; k < 3; k++)
            vec3_store(v[3 * i + k], at + soup_point(&d, 0.01));
    }
    soup_mesh(&s, scenes_diffuse(&s, rgb_gray(0.5f)), v, COUNT);
    const struct stage *alone = scenes_stage(&s);
    for (uint32_t threads = 1; threads <= 3; threads++) {
        struct arena arena = {0};
        const struct stage *stage = prepare(&s, threads, &arena);
        ok(stage->bytes == alone->bytes && memcmp(stage, alone, alone->bytes) == 0,
           "%u threads prepare the same bytes", threads);
        arena_release(&arena);
    }
    scenes_release(&s);
}

int main(void)
{
    for (uint32_t threads = 1; threads <= 4; threads++)
        test_once(threads);
    test_same_stage();
    return tap_done();
}
