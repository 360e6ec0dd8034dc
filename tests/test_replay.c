/* render_follow: the path that it shows is the one that was rendered.
 * SPDX-License-Identifier: MIT */
#include "common/trace/render.h"

#include <string.h>

#include "tests/scenes.h"
#include "tests/tap.h"

enum { SIDE = 8, SAMPLES = 32 };

struct found {
    int ends_differ, dark, jumps, places, cut;
};

/* A path is followed up to where it has ended. */
static void follow(const struct stage *s, struct film_key key, struct found *f)
{
    struct render_place now, last = {.traced = 0};
    uint32_t n = 0;
    for (;; n++) {
        render_follow(s, key, n, &now);
        if (now.material == STAGE_NONE)
            break;
        f->places++;
        f->dark += rgb_is_black(now.throughput);
        for (int c = 0; c < 3; c++)
            f->jumps += now.light[c] < last.light[c];
        f->jumps += n > 0 && now.traced != last.traced + 1;
        last = now;
    }
    f->cut += n > s->settings.max_bounces;
    const rgb all = render_sample(s, key.x_px, key.y_px, key.sample);
    f->ends_differ += memcmp(&all, &now.light, 3 * sizeof(float)) != 0;
}

static void judge(struct scenes *s, const char *what, bool cuts)
{
    const struct stage *stage = scenes_stage(s);
    struct found f = {0};
    for (uint32_t y = 0; y < SIDE; y++)
        for (uint32_t x = 0; x < SIDE; x++)
            for (uint32_t i = 0; i < SAMPLES; i++)
                follow(stage, (struct film_key){x, y, i}, &f);
    ok(f.ends_differ == 0, "%s: what a path has found in the end is what was rendered (%d not)",
       what, f.ends_differ);
    ok(f.places > SIDE * SIDE * SAMPLES && f.dark == 0 && f.jumps == 0,
       "on the way nothing is lost, and each place is a ray further (%d places)", f.places);
    ok((f.cut > 0) == cuts, "%d paths are cut", f.cut);
}

/* A furnace with a mirror ball and one of glass: lanes, other vertices, and delta lobes. */
static void room(struct scenes *s, bool absorbs)
{
    scenes_init(s, SIDE, SIDE);
    struct shape *walls = scenes_box(s, scenes_diffuse(s, rgb_gray(.7f)), vec3_make(-2, -2, -2),
                                     vec3_make(2, 2, 2), true);
    walls[4].emission = rgb_gray(3);
    uint32_t glass = scenes_glass(s, 1.5f);
    if (absorbs)
        s->scene.materials[glass].inside.absorption = rgb_gray(.5f);
    scenes_sphere(s, glass, vec3_make(.6f, 0, 0), .5f);
    scenes_sphere(s, scenes_mirror(s, rgb_gray(.9f)), vec3_make(-.6f, 0, 0), .5f);
    scenes_look(s, vec3_make(0, 0, 1.8f), vec3_make(0, 0, 0), 1.2);
}

int main(void)
{
    struct scenes s;
    room(&s, false);
    judge(&s, "balls in a room", false);
    scenes_release(&s);

    room(&s, false);
    s.scene.settings.max_bounces = 3;
    judge(&s, "with 3 bounces", true);
    scenes_release(&s);

    room(&s, true);
    judge(&s, "glass that absorbs", false);
    scenes_release(&s);

    scenes_init(&s, SIDE, SIDE);
    scenes_sky(&s, rgb_gray(1));
    scenes_ball(&s, scenes_diffuse(&s, rgb_gray(.5f)), vec3_make(0, 0, -3), 1, 12, .1f, false);
    scenes_look(&s, vec3_make(0, 0, 0), vec3_make(0, 0, -3), .4);
    judge(&s, "a ball under a sky", false);
    struct render_place place;
    render_follow(scenes_stage(&s), (struct film_key){4, 4, 0}, 0, &place);
    ok(place.p[2] > -2.2f && place.p[2] < -1.8f && place.ng[2] > .5f,
       "the first place is the side that is seen");
    scenes_release(&s);
    return tap_done();
}
