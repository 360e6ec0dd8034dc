/* Row F-13 of docs/accuracy.md, and F-12 where it is about sizes: a scene's unit is no part of it.
 * Scaled from a millionth to a million, a scene gives the same image; moved away, it does as far as
 * float coordinates can say where it is. SPDX-License-Identifier: MIT */
#include <math.h>

#include "tests/scenes.h"
#include "tests/stat/stat.h"
#include "tests/tap.h"

static const double pi = 3.14159265358979323846;
static const double slack = STAT_SLOW == 1 ? 1 : 10; /* few samples: one that strays is more */

/* --- scenes about 1 in size --- */

static void furnace(struct scenes *s)
{
    scenes_look(s, vec3_make(.2f, -.1f, .3f), vec3_make(.5f, .3f, -1), pi / 2);
    const uint32_t wall = scenes_diffuse(s, rgb_gray(.8f));
    scenes_ball(s, wall, vec3_make(0, 0, 0), 1, 7, .3f, true);
    s->scene.shapes[0].emission = rgb_gray(1);
}

static void lamps(struct scenes *s)
{
    const uint32_t white = scenes_diffuse(s, rgb_gray(.8f)), black = scenes_diffuse(s, rgb_gray(0));
    scenes_look(s, vec3_make(0, .8f, 1), vec3_make(0, 0, 0), .8);
    scenes_disc(s, white, vec3_make(0, 0, 0), vec3_make(0, 1, 0), 1);
    scenes_triangle(s, black, vec3_make(-.5f, .6f, 0), vec3_make(0, .6f, .1f),
                    vec3_make(-.2f, .7f, .5f))
        ->emission = rgb_gray(3);
    scenes_sphere(s, black, vec3_make(.5f, .4f, -.3f), .2f)->emission = rgb_gray(4);
    scenes_cylinder(s, black, vec3_make(-.6f, .3f, -.5f), vec3_make(.1f, .4f, -.6f), .03f)
        ->emission = rgb_gray(9);
    struct light *bulb = scenes_light(s, LIGHT_POINT), *sun = scenes_light(s, LIGHT_DISTANT);
    vec3_store(bulb->point.position, vec3_make(.3f, .5f, .4f));
    bulb->point.intensity = rgb_gray(.2f);
    vec3_store(sun->distant.direction, vec3_make(0, -.8f, .6f));
    sun->distant.irradiance = rgb_gray(.5f);
}

static void glass(struct scenes *s)
{
    scenes_look(s, vec3_make(0, 1, 2), vec3_make(0, .3f, 0), .7);
    const uint32_t white = scenes_diffuse(s, rgb_gray(.6f));
    scenes_quad(s, white, vec3_make(-2, 0, 2), vec3_make(4, 0, 0), vec3_make(0, 0, -4));
    scenes_sphere(s, scenes_glass(s, 1.5f), vec3_make(-.4f, .35f, 0), .35f);
    scenes_ball(s, scenes_metal(s, rgb_gray(.2f), rgb_gray(3.9f), .2f), vec3_make(.5f, .4f, 0), .4f,
                6, .2f, false);
    scenes_sky(s, rgb_gray(1));
}

static void mirrors(struct scenes *s)
{
    scenes_box(s, scenes_mirror(s, rgb_gray(.9f)), vec3_make(-.6f, -.5f, -.4f),
               vec3_make(.5f, .6f, .7f), true);
    for (uint32_t i = 0; i < s->scene.shape_count; i++)
        s->scene.shapes[i].emission = rgb_gray(1);
}

/* All lengths times `scale`, then moved. Radiances stay; what a point light sends out grows with
 * the square. */
static void transform(struct scenes *s, float scale, vec3 move)
{
    for (uint32_t i = 0; i < s->scene.shape_count; i++)
        for (int k = 0; k < 3; k++) {
            s->scene.shapes[i].to_world.m[k][k] = scale;
            s->scene.shapes[i].to_world.m[k][3] = move[k];
        }
    for (int k = 0; k < 3; k++) {
        float *at = &s->scene.camera.to_world.m[k][3];
        *at = *at * scale + move[k];
    }
    for (uint32_t i = 0; i < s->scene.light_count; i++)
        if (s->scene.lights[i].kind == LIGHT_POINT) {
            float *p = s->scene.lights[i].point.position;
            vec3_store(p, vec3_load(p) * scale + move);
            s->scene.lights[i].point.intensity *= scale * scale;
        }
}

struct apart {           /* two images */
    double mean, pixels; /* difference of their means; mean |difference|: both over their mean */
    uint64_t invalid;
};

static struct apart compare(void (*make)(struct scenes *), float scale, vec3 move)
{
    struct film film[2];
    struct apart d = {0, 0, 0};
    double sum = 0;
    for (int i = 0; i < 2; i++) {
        struct scenes s;
        scenes_init(&s, 8, 8);
        make(&s);
        if (i)
            transform(&s, scale, move);
        scenes_render(scenes_stage(&s), max_u32(8, stat_tries(256, 4096)), &film[i]);
        d.invalid += film[i].invalid_count;
        scenes_release(&s);
    }
    for (size_t p = 0; p < tile_rect_pixels(film[0].window); p++) {
        double a[3], b[3];
        film_mean(&film[0], p, a);
        film_mean(&film[1], p, b);
        d.mean += b[1] - a[1];
        d.pixels += fabs(b[1] - a[1]);
        sum += a[1];
    }
    for (int i = 0; i < 2; i++)
        film_release(&film[i]);
    return (struct apart){fabs(d.mean) / sum, d.pixels / sum, d.invalid};
}

struct example {
    const char *name;
    void (*make)(struct scenes *);
};

static void scales(const struct example *e)
{
    static const float scale[] = {1e-6f, 1e-3f, 1e3f, 1e6f};
    const vec3 stay = vec3_make(0, 0, 0);
    double off = 0;
    uint64_t invalid = 0;
    for (size_t k = 0; k < countof(scale); k++) {
        const struct apart d = compare(e->make, scale[k], stay);
        off = fmax(off, d.pixels);
        invalid += d.invalid;
    }
    ok(off <= slack * 1e-4 && invalid == 0,
       "F-13: %s, 1e-6 to 1e6 times as large: the same image (%.1e)", e->name, off);
    ok(compare(e->make, 0x1p20f, stay).pixels == 0 && compare(e->make, 0x1p-20f, stay).pixels == 0,
       "F-13: %s, by powers of 2: to the last bit", e->name);
}

/* A path that meets an edge elsewhere goes elsewhere from there on, so pixels part sooner than the
 * image's mean. A million sizes away coordinates are steps of 1/16 of the scene. */
static void moves(const struct example *e)
{
    const vec3 way = vec3_make(1, -.7f, .3f);
    const struct apart near_by = compare(e->make, 1, 100 * way),
                       far = compare(e->make, 1, 1000 * way),
                       lost = compare(e->make, 1, 1e6f * way);
    ok(near_by.pixels <= slack * 1e-3 && near_by.invalid == 0,
       "F-13: %s, 100 sizes away: the same image (%.1e)", e->name, near_by.pixels);
    ok(far.mean <= slack * 1e-3 && far.invalid == 0,
       "F-13: %s, 1000 sizes away: the same mean (%.1e)", e->name, far.mean);
    ok(lost.invalid == 0, "F-13: %s, 1e6 sizes away, beyond float: no invalid sample (%.1e off)",
       e->name, lost.mean);
}

/* --- F-12: a surface that shines is seen to, whatever its size --- */

static void emitters_of_any_size(void)
{
    int wrong = 0;
    for (int e = -8; e <= 8; e++) {
        struct scenes s;
        struct film film;
        const float size = (float)pow(10, e);
        scenes_init(&s, 8, 8);
        scenes_look(&s, vec3_make(0, 0, size), vec3_make(0, 0, 0), .3);
        scenes_quad(&s, scenes_diffuse(&s, rgb_gray(0)), vec3_make(-size, -size, 0),
                    vec3_make(2 * size, 0, 0), vec3_make(0, 2 * size, 0))
            ->emission = rgb_gray(1);
        scenes_render(scenes_stage(&s), 8, &film);
        wrong += scenes_mean(&film, 0).mean != 1;
        film_release(&film);
        scenes_release(&s);
    }
    ok(wrong == 0, "F-12: emitters of size 1e-8 to 1e8 show their radiance exactly (%d do not)",
       wrong);
}

int main(void)
{
    static const struct example some[] = {
        {"furnace", furnace}, {"lamps", lamps}, {"glass", glass}, {"mirrors", mirrors}};
    for (size_t i = 0; i < countof(some); i++) {
        scales(&some[i]);
        moves(&some[i]);
    }
    emitters_of_any_size();
    return tap_done();
}
