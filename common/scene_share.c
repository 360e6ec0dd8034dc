/* SPDX-License-Identifier: MIT */
#include "common/scene_share.h"

#define MOST 1e6 /* what can be rescaled */

bool scene_share_wanted(const struct scene_at *whole)
{
    struct scene_at settings, flag;
    return scene_at_type(whole) == SCENE_OBJECT && scene_at_member(whole, "settings", &settings) &&
           scene_at_type(&settings) == SCENE_OBJECT &&
           scene_at_member(&settings, "rescale", &flag) && scene_at_type(&flag) == SCENE_BOOLEAN &&
           scene_at_boolean(&flag);
}

static struct scene_range range_of(const struct scene_params *p)
{
    return (struct scene_range){0, p->doc->rescale ? MOST : 1, false};
}

/* --- warnings --- */

static void add_warning(const struct scene_params *p, const struct scene_warning *w)
{
    struct scene *scene = p->scene;
    scene->warnings =
        arena_grow(p->doc->arena, scene->warnings, scene->warning_count, sizeof *scene->warnings);
    scene->warnings[scene->warning_count++] = *w;
}

static void rescale(const struct scene_params *p, struct scene_share s, float most)
{
    struct scene_at at;
    if (!scene_at_member(p->at, s.key, &at))
        return;
    struct scene_warning w = {.where = scene_doc_pointer(p->doc, &at)};
    vec3_store(w.was, *s.out);
    *s.out /= most;
    vec3_store(w.became, *s.out);
    w.what =
        arena_printf(p->doc->arena, "more light than there is: was %g, %g, %g, became %g, %g, %g",
                     (double)w.was[0], (double)w.was[1], (double)w.was[2], (double)w.became[0],
                     (double)w.became[1], (double)w.became[2]);
    add_warning(p, &w);
}

/* --- parameters --- */

/* Reads a share, or what is to become one; whether it is a plain colour. */
static bool read_plain(const struct scene_params *p, struct scene_share s)
{
    struct scene_at at;
    if (!scene_at_member(p->at, s.key, &at))
        return false;
    if (scene_at_type(&at) != SCENE_OBJECT)
        return scene_doc_rgb(p->doc, &at, range_of(p), s.out);
    scene_param_rgb(p, s.key, (struct scene_range){0, 1, false}, s.out);
    return false;
}

void scene_share_rgb(const struct scene_params *p, const char *key, rgb *out)
{
    const struct scene_share s = {key, out};
    if (read_plain(p, s) && rgb_max(*out) > 1)
        rescale(p, s, rgb_max(*out));
}

void scene_share_pair(const struct scene_params *p, struct scene_share a, struct scene_share b)
{
    const bool both = (int)read_plain(p, a) & (int)read_plain(p, b);
    const rgb sum = *a.out + *b.out;
    if (!both || !(rgb_max(sum) > 1.000001f)) /* .9 + .1 is more than 1 in float */
        return;
    if (!p->doc->rescale) {
        scene_doc_fault(p->doc, p->at, ERR_INPUT,
                        "expected %s + %s of at most 1 in every channel, got %g, %g, %g", a.key,
                        b.key, (double)sum[0], (double)sum[1], (double)sum[2]);
    } else {
        rescale(p, a, rgb_max(sum));
        rescale(p, b, rgb_max(sum));
    }
}
