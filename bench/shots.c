/* SPDX-License-Identifier: MIT */
#include "bench/shots.h"

#include <math.h>

#include "common/trace/bvh.h"
#include "common/trace/camera.h"
#include "common/trace/surface.h"
#include "common/trace/warp.h"
#include "tests/dice.h"

/* How far bounces start from the surface, in parts of the scene's diagonal. Far more than any
 * kernel's rounding, so that none of them has hits at the start that the others have not; far less
 * than a triangle of the largest scene. */
#define OFFSET 1e-5f

struct spot { /* a primary ray's hit */
    vec3 p;   /* already off the surface */
    vec3 n;   /* unit, to the side of the camera */
};

struct spots {
    struct spot *list;
    size_t count;
};

const char *shots_name(enum shots_kind kind)
{
    static const char *const names[] = {"primary", "bounce", "shadow"};
    _Static_assert(countof(names) == SHOTS_KINDS, "a name for each");
    return names[kind];
}

struct shots shots_slice(const struct shots *s, size_t begin, size_t end)
{
    return (struct shots){s->list + begin, min_size(end, s->count) - begin, s->kind};
}

static struct shot shot_make(vec3 origin, vec3 dir, float t_max)
{
    struct shot shot = {.t_max = t_max};
    vec3_store(shot.origin, origin);
    vec3_store(shot.dir, dir);
    return shot;
}

static float offset_of(const struct stage *s)
{
    return OFFSET * vec3_length(vec3_load(s->bounds[1]) - vec3_load(s->bounds[0]));
}

static struct shots make_primary(const struct stage *s, struct arena *arena, struct spots *spots)
{
    const uint32_t width = s->film.width_px, height = s->film.height_px;
    const size_t pixels = (size_t)width * height;
    const float offset = offset_of(s);
    struct shot *list = arena_new(arena, struct shot, pixels);
    *spots =
        (struct spots){arena_alloc(arena, pixels, sizeof *spots->list, alignof(struct spot)), 0};
    for (size_t i = 0; i < pixels; i++) {
        const float x = (float)(i % width), y = (float)(i / width);
        const struct ray ray = camera_ray(&s->camera, x + 0.5f, y + 0.5f);
        list[i] = shot_make(ray.origin, ray.dir, ray.t_max);
        struct ray_hit hit;
        if (!bvh_hit_closest(s, &ray, &hit))
            continue;
        const struct surface surface = surface_at(s, &ray, &hit);
        const vec3 n = vec3_dot(surface.ng, ray.dir) > 0 ? -surface.ng : surface.ng;
        spots->list[spots->count++] = (struct spot){surface.p + offset * n, n};
    }
    return (struct shots){list, pixels, SHOTS_PRIMARY};
}

static struct shots make_bounces(const struct spots *spots, size_t count, struct arena *arena)
{
    struct dice d = dice_make(2);
    count = spots->count ? count : 0;
    struct shot *list = arena_new(arena, struct shot, count);
    for (size_t i = 0; i < count; i++) {
        const struct spot *spot = &spots->list[i * spots->count / count];
        const struct warp_frame frame = warp_frame_make(spot->n);
        const vec3 dir = warp_cosine((struct square){dice_float(&d), dice_float(&d)});
        list[i] = shot_make(spot->p, warp_to_world(&frame, dir), INFINITY);
    }
    return (struct shots){list, count, SHOTS_BOUNCE};
}

static bool aim_at_lamp(const struct spot *spot, const vec3 lamp[3], struct dice *d,
                        struct shot *out)
{
    const float u = dice_float(d), v = dice_float(d);
    const vec3 dir = lamp[0] + u * lamp[1] + v * lamp[2] - spot->p;
    *out = shot_make(spot->p, dir, 0.999f);
    return vec3_dot(dir, spot->n) > 0;
}

/* In as few passes over the spots as give enough, all passes with the same stride. */
static struct shots make_shadows(const struct spots *spots, const vec3 lamp[3], size_t count,
                                 struct arena *arena)
{
    struct dice d = dice_make(3);
    struct shot shot, *list = arena_new(arena, struct shot, count);
    size_t lit = 0, made = 0;
    for (size_t i = 0; i < spots->count; i++)
        lit += aim_at_lamp(&spots->list[i], lamp, &d, &shot);
    if (lit < spots->count / 100 + 1)
        return (struct shots){list, 0, SHOTS_SHADOW};
    const size_t tries = (size_t)((double)count * (double)spots->count / (double)lit * 1.05);
    const size_t passes = tries / spots->count + 1, each = tries / passes;
    for (size_t pass = 0; pass < passes; pass++)
        for (size_t i = 0; i < each && made < count; i++)
            if (aim_at_lamp(&spots->list[i * spots->count / each], lamp, &d, &shot))
                list[made++] = shot;
    return (struct shots){list, made, SHOTS_SHADOW};
}

void shots_make(const struct stage *s, const vec3 lamp[3], size_t count, struct arena *arena,
                struct shots sets[SHOTS_KINDS])
{
    struct spots spots;
    sets[SHOTS_PRIMARY] = make_primary(s, arena, &spots);
    sets[SHOTS_BOUNCE] = make_bounces(&spots, count, arena);
    sets[SHOTS_SHADOW] = make_shadows(&spots, lamp, count, arena);
}
