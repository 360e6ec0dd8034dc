/* SPDX-License-Identifier: MIT */
#include "tests/swarm.h"

#include <math.h>

#include "common/trace/bvh.h"
#include "common/trace/light_tree.h"
#include "tests/catalog.h"
#include "tests/dice.h"

static const double pi = 3.14159265358979323846;

void swarm_init(struct swarm *w, uint32_t count, bool occluded, uint64_t seed)
{
    struct dice dice = dice_make(seed);
    scenes_init(&w->s, 8, 8);
    scenes_look(&w->s, vec3_make(0, .01f, 0), vec3_make(0, 0, 0), 1e-3);
    w->s.scene.settings.max_bounces = 1;
    w->count = count;
    scenes_disc(&w->s, scenes_diffuse(&w->s, rgb_gray(1)), vec3_make(0, 0, 0), vec3_make(0, 1, 0),
                .2f);
    if (occluded) /* what is seen from the middle is a cone with a cosine of .8 */
        scenes_cylinder(&w->s, scenes_diffuse(&w->s, rgb_gray(0)), vec3_make(0, -.01f, 0),
                        vec3_make(0, .4f, 0), .3f);
    struct light *lights = arena_new(&w->s.arena, struct light, count);
    for (uint32_t i = 0; i < count; i++) {
        const double z = dice_range(&dice, -1, 1), phi = dice_range(&dice, 0, 2 * pi);
        const double r = sqrt(1 - z * z);
        lights[i].kind = LIGHT_POINT;
        lights[i].point.intensity = rgb_gray((float)pow(10, dice_range(&dice, 0, 4)));
        vec3_store(lights[i].point.position,
                   vec3_make((float)(r * cos(phi)), (float)z, (float)(r * sin(phi))));
    }
    w->s.scene.lights = lights;
    w->s.scene.light_count = count;
    w->stage = scenes_stage(&w->s);
}

void swarm_release(struct swarm *w)
{
    scenes_release(&w->s);
}

struct surface swarm_point(const struct swarm *w, vec3 p)
{
    struct surface at = surface_on_disc(w->stage, catalog_id(w->stage, 0), p);
    at.lit = 1;
    return at;
}

/* Irradiance by a point light, 0 if it is not seen. */
static double sent(const struct swarm *w, const struct surface *from, const struct emitter *e)
{
    double dd = 0, height = 0;
    for (int k = 0; k < 3; k++) {
        const double d = (double)e->at[k] - (double)from->p[k];
        dd += d * d;
        height += d * (double)from->ng[k];
    }
    if (!(height > 0))
        return 0;
    const struct ray shadow = surface_to_point(from, vec3_load(e->at));
    return bvh_hit_any(w->stage, &shadow) ? 0 : (double)e->radiance[0] * height / (dd * sqrt(dd));
}

struct swarm_law swarm_law(const struct swarm *w, const struct surface *from)
{
    const struct emitter *emitters = stage_at(w->stage, w->stage->emitters);
    const float *cdf = stage_at(w->stage, w->stage->pick_cdf);
    struct swarm_law law = {0};
    double power = 0;
    for (uint32_t i = 0; i < w->count; i++)
        power += (double)emitters[i].radiance[0];
    for (uint32_t i = 0; i < w->count; i++) {
        const double f = sent(w, from, &emitters[i]);
        const double p = w->stage->light_nodes.count ? light_tree_probability(w->stage, from, i)
                                                     : (double)cdf[i + 1] - (double)cdf[i];
        law.mass += p;
        law.irradiance += f;
        law.missed += f > 0 && !(p > 0);
        if (f > 0 && p > 0)
            law.ours += f * f / p;
        law.power += f * f / ((double)emitters[i].radiance[0] / power);
        law.uniform += f * f * w->count;
    }
    const double square = law.irradiance * law.irradiance;
    law.ours = law.ours / square - 1;
    law.power = law.power / square - 1;
    law.uniform = law.uniform / square - 1;
    return law;
}
