/* Row F-10 of docs/accuracy.md, for paths: a ray that starts where another has met an edge of a
 * closed body, or all but met it, does not get out. SPDX-License-Identifier: MIT */
#include <math.h>

#include "common/trace/bvh.h"
#include "common/trace/surface.h"
#include "common/trace/warp.h"
#include "tests/catalog.h"
#include "tests/dice.h"
#include "tests/scenes.h"
#include "tests/stat/stat.h"
#include "tests/tap.h"

/* From `inside` towards a point of an edge of the triangle. */
static struct ray towards_edge(const struct stage_triangle *t, vec3 inside, struct dice *d)
{
    const uint32_t k = dice_bits(d) % 3;
    const vec3 a = vec3_load(t->v[k]), b = vec3_load(t->v[(k + 1) % 3]);
    const vec3 target = a + (float)dice_unit(d) * (b - a);
    return (struct ray){inside, vec3_unit(target - inside), INFINITY, 0, 0};
}

/* Evenly bright light's: as a matte surface scatters. */
static vec3 scattered(const struct surface *at, vec3 dir, struct dice *d)
{
    const struct warp_frame f = warp_frame_make(vec3_dot(dir, at->ng) < 0 ? at->ng : -at->ng);
    const struct square q = {dice_float(d), dice_float(d)};
    return vec3_unit(warp_to_world(&f, warp_cosine(q)));
}

static void keeps_light_in(struct scenes *s, vec3 inside, const char *name)
{
    const struct stage *stage = scenes_stage(s);
    struct dice d = dice_make(3);
    const uint32_t tries = stat_tries(200000, 4000000);
    uint32_t missed = 0, out = 0;
    for (uint32_t i = 0; i < tries; i++) {
        const struct stage_triangle t = catalog_triangle(stage, dice_bits(&d) % stage->prim_count);
        const struct ray ray = towards_edge(&t, inside, &d);
        struct ray_hit hit, next;
        if (!bvh_hit_closest(stage, &ray, &hit)) {
            missed++;
            continue;
        }
        const struct surface at = surface_at(stage, &ray, &hit);
        const struct ray onward = surface_leave(&at, scattered(&at, ray.dir, &d));
        out += !bvh_hit_closest(stage, &onward, &next);
    }
    ok(missed == 0 && out == 0,
       "F-10: %s: of %u rays at edges %u miss, %u that start there get out", name, tries, missed,
       out);
    scenes_release(s);
}

static void box(vec3 at, const char *name)
{
    struct scenes s;
    scenes_init(&s, 1, 1);
    scenes_box(&s, scenes_diffuse(&s, rgb_gray(1)), at - vec3_make(.6f, .5f, .4f),
               at + vec3_make(.613f, .6f, .7f), true);
    keeps_light_in(&s, at, name);
}

static void ball(float wave, const char *name)
{
    struct scenes s;
    scenes_init(&s, 1, 1);
    scenes_ball(&s, scenes_diffuse(&s, rgb_gray(1)), vec3_make(0, 0, 0), 1, 12, wave, true);
    keeps_light_in(&s, vec3_make(.1f, .05f, 0), name);
}

int main(void)
{
    box(vec3_make(0, 0, 0), "a room");
    box(vec3_make(100, 30, -50), "a room 100 m away");
    ball(0, "a ball");
    ball(.3f, "a wavy ball");
    return tap_done();
}
