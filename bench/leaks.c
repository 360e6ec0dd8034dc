/* SPDX-License-Identifier: MIT */
#include "bench/leaks.h"

#include "bench/closure.h"
#include "bench/meshes.h"
#include "bench/ours.h"
#include "tests/aim.h"

enum { ORIGINS = 32, BATCH = 1 << 15 };

static const float offsets[] = {0, 1e3f, 1e5f};

static void find_inside(const struct stage *s, struct dice *d, vec3 out[ORIGINS])
{
    const vec3 lo = vec3_load(s->bounds[0]), hi = vec3_load(s->bounds[1]);
    for (int n = 0; n < ORIGINS;) {
        const vec3 t = vec3_make(dice_float(d), dice_float(d), dice_float(d));
        out[n] = lo + t * (hi - lo);
        n += aim_winding(s, out[n]) > 0.5;
    }
}

static struct shot aimed(const struct stage *s, struct dice *d, const vec3 origins[ORIGINS])
{
    const uint32_t which = dice_bits(d);
    const struct ray ray = aim_ray(d, s, origins[which % ORIGINS], which >> 31);
    struct shot shot = {.t_max = ray.t_max};
    vec3_store(shot.origin, ray.origin);
    vec3_store(shot.dir, ray.dir);
    return shot;
}

static uint64_t count_misses(const struct shot_hit *hits, size_t count)
{
    uint64_t n = 0;
    for (size_t i = 0; i < count; i++)
        n += hits[i].prim == SHOTS_MISS;
    return n;
}

static void shoot(struct scenes *s, uint64_t rays, struct leaks *row)
{
    const struct stage *stage = scenes_stage(s);
    struct embree *embree[EMBREE_KINDS] = {NULL};
    for (int k = 0; embree_version() && k < EMBREE_KINDS; k++) {
        embree[k] = embree_new(&s->scene, (enum embree_kind)k);
        embree_build(embree[k]);
    }
    struct dice d = dice_make(10);
    vec3 origins[ORIGINS];
    find_inside(stage, &d, origins);
    struct shot *list = arena_new(&s->arena, struct shot, BATCH);
    struct shot_hit *hits = arena_new(&s->arena, struct shot_hit, BATCH);
    while (row->rays < rays) {
        const struct shots shots = {list, min_size(BATCH, rays - row->rays), SHOTS_BOUNCE};
        for (size_t i = 0; i < shots.count; i++)
            list[i] = aimed(stage, &d, origins);
        for (int k = 0; k < EMBREE_KINDS; k++)
            if (embree[k]) {
                embree_trace(embree[k], EMBREE_SINGLE, &shots, hits);
                row->out[k] += count_misses(hits, shots.count);
            }
        ours_trace(stage, &shots, hits);
        row->out[RACE_OURS] += count_misses(hits, shots.count);
        row->rays += shots.count;
    }
    for (int k = 0; k < EMBREE_KINDS; k++)
        if (embree[k])
            embree_free(embree[k]);
}

static bool add_closed_bunny(struct scenes *s, const char *assets, float offset, struct err *err)
{
    const char *what;
    const float scale = 100;
    struct shape *bunny =
        meshes_add_bunny(s, scenes_diffuse(s, rgb_gray(0.5f)), assets, &what, err);
    if (!bunny)
        return false;
    closure_fill(&s->scene.meshes[bunny->mesh.mesh], &s->arena);
    bunny->to_world =
        (struct xform){{{scale, 0, 0, offset}, {0, scale, 0, -offset}, {0, 0, scale, offset}}};
    return true;
}

bool leaks_count(const char *assets, uint64_t rays, struct leaks rows[LEAKS_ROWS], struct err *err)
{
    bool good = true;
    for (size_t i = 0; i < LEAKS_ROWS && good; i++) {
        const float offset = offsets[i % countof(offsets)];
        struct scenes s;
        scenes_init(&s, 1, 1);
        rows[i] = (struct leaks){.mesh = i < countof(offsets) ? "ball" : "bunny", .offset = offset};
        if (i < countof(offsets))
            scenes_ball(&s, scenes_diffuse(&s, rgb_gray(0.5f)), vec3_make(offset, -offset, offset),
                        1, 16, 0.2f, false);
        else
            good = add_closed_bunny(&s, assets, offset, err);
        if (good)
            shoot(&s, rays, &rows[i]);
        scenes_release(&s);
    }
    return good;
}
