/* F-21: where a path could go round for ever. Surfaces that lie on each other take no longer than
 * surfaces that all but do, and energy stays. SPDX-License-Identifier: MIT */
#include <math.h>
#include <time.h>

#include "tests/scenes.h"
#include "tests/stat/stat.h"
#include "tests/tap.h"

static const float apart = 1e-3f;

static void begin(struct scenes *s)
{
    scenes_init(s, 8, 8);
    scenes_sky(s, rgb_gray(1));
    s->scene.settings.max_bounces = 1000;
}

/* Panes of 4 x 4 m at z = 0 and behind it, fronts towards the camera and away. */
static void panes(struct scenes *s, float gap)
{
    begin(s);
    scenes_look(s, vec3_make(0.3f, 0.2f, 2), vec3_make(0, 0, 0), 0.5);
    const uint32_t glass = scenes_glass(s, 1.5f);
    const vec3 x = vec3_make(4, 0, 0), y = vec3_make(0, 4, 0);
    scenes_quad(s, glass, vec3_make(-2, -2, 0), x, y);
    scenes_quad(s, glass, vec3_make(-2, -2, -gap), y, x);
}

static void nested(struct scenes *s, float gap)
{
    begin(s);
    scenes_look(s, vec3_make(1, 2, 3), vec3_make(0, 0, 0), 0.5);
    const uint32_t glass = scenes_glass(s, 1.5f);
    for (int i = 0; i < 100; i++)
        scenes_sphere(s, glass, vec3_make(0, 0, 0), 1 - (float)i * gap);
}

/* Two panes of glass that share the edge along which the camera looks, or all but do. */
static void edge(struct scenes *s, float gap)
{
    begin(s);
    scenes_look(s, vec3_make(0, 0, 3), vec3_make(0, 0, 0), 1e-4);
    const uint32_t glass = scenes_glass(s, 1.5f);
    const vec3 z = vec3_make(0, 0, 2);
    scenes_quad(s, glass, vec3_make(gap, 0, -1), vec3_make(1, 1, 0), z);
    scenes_quad(s, glass, vec3_make(-gap, 0, -1), z, vec3_make(-1, 1, 0));
}

/* Two mirrors that take nothing, opposite each other, each twice; the camera between them. */
static void corridor(struct scenes *s, float gap)
{
    begin(s);
    s->scene.settings.max_bounces = 10000; /* as many as there can be */
    scenes_look(s, vec3_make(0, 0, 0), vec3_make(0, 0, -1), 0.5);
    const uint32_t mirror = scenes_mirror(s, rgb_gray(1));
    const vec3 x = vec3_make(20, 0, 0), y = vec3_make(0, 20, 0);
    for (int i = 0; i < 2; i++) {
        scenes_quad(s, mirror, vec3_make(-10, -10, -1 - (float)i * gap), x, y);
        scenes_quad(s, mirror, vec3_make(-10, -10, 1 + (float)i * gap), y, x);
    }
}

struct run {
    double seconds; /* of CPU time, the least of three */
    struct scenes_mean mean;
    uint64_t invalid;
};

static struct run run_of(void (*make)(struct scenes *, float), float gap, uint32_t spp)
{
    struct run r = {.seconds = HUGE_VAL};
    struct scenes s;
    make(&s, gap);
    const struct stage *stage = scenes_stage(&s);
    for (int i = 0; i < 3; i++) {
        struct timespec a, b;
        struct film film;
        clock_gettime(CLOCK_THREAD_CPUTIME_ID, &a);
        scenes_render(stage, spp, &film);
        clock_gettime(CLOCK_THREAD_CPUTIME_ID, &b);
        r.seconds =
            fmin(r.seconds, (double)(b.tv_sec - a.tv_sec) + 1e-9 * (double)(b.tv_nsec - a.tv_nsec));
        r.mean = scenes_mean(&film, 0);
        r.invalid = film.invalid_count;
        film_release(&film);
    }
    scenes_release(&s);
    return r;
}

/* Without a cut of the paths radiance would be 1 in all of them. 100 shells each 1 mm thick, of
 * which every one counts as glass in air, keep some light for more than 1000 bounces.
 *
 * Two surfaces of glass in one place are one surface with glass on its far side, or none: not what
 * the author means, but a light's energy at most. */
static void judge(const char *name, double least, const struct run *on, const struct run *near_by)
{
    const double room = 3.9 * near_by->mean.error + 1e-4;
    ok(near_by->mean.mean > least - room && near_by->mean.mean < 1 + room,
       "F-21: %s, 1 mm apart: radiance is %.4f, %g to 1 +- %.2g", name, near_by->mean.mean, least, room);
    ok(on->mean.mean > 0.1 && on->mean.mean < 1 + 1e-4, "F-21: %s, on each other: it is %.4f", name,
       on->mean.mean);
    ok(near_by->invalid + on->invalid == 0, "%s: no invalid sample", name);
    ok(on->seconds <= 2 * near_by->seconds, "F-21: %s: on each other they take %.2g s, apart %.2g s",
       name, on->seconds, near_by->seconds);
}

int main(void)
{
    static const struct {
        const char *name;
        void (*make)(struct scenes *, float);
        uint32_t spp;
        double least; /* radiance */
    } cases[] = {{"two panes of glass", panes, 1024, 1},
                 {"100 nested spheres of glass", nested, 8, 0.5},
                 {"along the edge of two panes", edge, 1024, 1},
                 {"a corridor of mirrors", corridor, 8, 1}};
    for (size_t i = 0; i < countof(cases); i++) {
        const uint32_t spp = max_u32(8, cases[i].spp / STAT_SLOW);
        const struct run on = run_of(cases[i].make, 0, spp);
        const struct run near_by = run_of(cases[i].make, apart, spp);
        judge(cases[i].name, cases[i].least, &on, &near_by);
    }
    return tap_done();
}
