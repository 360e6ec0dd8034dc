/* One thread or several, in whatever order: the same bytes. SPDX-License-Identifier: MIT */
#include "common/trace/prep.h"

#include <string.h>

#include "bench/meshes.h"
#include "tests/crowd.h"
#include "tests/stat/stat.h"
#include "tests/tap.h"
#include "tests/gang.h"

/* The arena owns it. */
static const struct stage *stage_of(const struct scene *scene, struct gang *team,
                                    struct arena *arena)
{
    struct arena scratch = {0};
    const struct stage *stage = NULL;
    struct err err;
    const struct crew crew = gang_crew(team);
    if (!prep_stage(scene, team->threads ? &crew : NULL, arena, &scratch, &stage, &err)) {
        diag("%s", err.text);
        stage = NULL;
    }
    arena_release(&scratch);
    return stage;
}

static void same_bytes(const struct scene *scene, const char *what)
{
    struct arena first_arena = {0}, arena = {0};
    struct gang alone = {0};
    const struct stage *first = stage_of(scene, &alone, &first_arena);
    for (uint32_t threads = 1; first && threads <= 3; threads++) {
        struct gang team = {.threads = threads, .seed = threads};
        const struct stage *s = stage_of(scene, &team, &arena);
        ok(s && s->bytes == first->bytes && memcmp(s, first, s->bytes) == 0 && team.tasks > 1,
           "%s: %u threads, %u tasks shuffled, the %.0f MB of none", what, threads, team.tasks,
           (double)first->bytes * 1e-6);
        arena_release(&arena);
    }
    ok(first != NULL, "%s: prepared", what);
    arena_release(&first_arena);
}

int main(void)
{
    static const enum meshes_kind kinds[] = {MESHES_INTERIOR, MESHES_TERRAIN, MESHES_SOUP};
    for (size_t i = 0; i < (stat_is_long() ? countof(kinds) : 1); i++) {
        struct meshes m;
        struct err err;
        /* Not fewer in the quick tier: parts begin at 262 144 items (bvh_build.c). */
        if (!meshes_init(&m, kinds[i], stat_is_long() ? 1000000 : 600000, ".", &err)) {
            ok(false, "%s", err.text);
            continue;
        }
        same_bytes(&m.scenes.scene, m.what);
        meshes_release(&m);
    }
    struct scenes s;
    scenes_init(&s, 1, 1);
    const uint32_t m = scenes_diffuse(&s, rgb_gray(0.5f));
    crowd_add_others(&s, m, 1);
    crowd_add(&s, m, &(struct crowd){.seed = 1, .uses = 5, .rings = 280, .reach = 10});
    same_bytes(&s.scene, "instances of a large mesh, and a copy");
    scenes_release(&s);
    return tap_done();
}
