/* A path followed by itself, through the functions of path.h and those beside it for scenes that
 * need them: the definition, which waves must meet to the bit.
 * SPDX-License-Identifier: MIT */
#include "tests/stability/trial.h"

#include "common/trace/bvh.h"
#include "common/trace/camera.h"
#include "common/trace/cone.h"
#include "common/trace/filter.h"
#include "common/trace/material.h"
#include "common/trace/path_mask.h"
#include "common/trace/path_media.h"
#include "common/trace/rng.h"
#include "common/trace/textured.h"

struct way {
    const struct stage *stage;
    struct rng rng;
    struct ray ray;
    struct ray_hit hit;
    struct cone cone;
    struct film_work work;
    struct path path;
    struct path_media media;
    struct material textured;
};

static struct ray camera_ray_of(const struct stage *s, const struct rng *elder, uint32_t x_px,
                                uint32_t y_px)
{
    const struct square q = rng_pair(elder, RNG_FILTER), lens = rng_pair(elder, RNG_LENS);
    const float dx = filter_offset(s, f32x8_splat(q.u))[0];
    const float dy = filter_offset(s, f32x8_splat(q.v))[0];
    return camera_ray_through(&s->camera, (float)x_px + 0.5f + dx, (float)y_px + 0.5f + dy, lens);
}

/* The closest hit that no mask lets through. */
static bool meets(struct way *w, const struct rng *rng, uint32_t bounce)
{
    if (!bvh_hit_closest(w->stage, &w->ray, &w->hit))
        return false;
    if (!w->stage->masked)
        return true;
    const struct path_mask_rays r = {rng, u32x8_splat(bounce), &w->ray, &w->hit, &w->work};
    return path_mask_pass(w->stage, 1, &r) != 0;
}

static bool begin(struct way *w)
{
    const struct stage *s = w->stage;
    struct path *p = &w->path;
    const struct rng elder = rng_elder(&w->rng);
    const vec3 origin = w->ray.origin;
    const bool met = meets(w, &elder, 0);
    if (s->pyramids.count && met)
        w->cone = cone_along((struct cone){s->cone_width, s->cone_spread}, w->hit.t);
    p->work = &w->work;
    p->light = rgb_gray(0);
    p->throughput = rgb_gray(1);
    if (s->media) {
        p->media = &w->media;
        p->vertex.at.p = origin;
        return path_media_begin(
            s, p,
            &(struct path_media_way){&w->ray, met ? &w->hit : NULL, w->cone.width, &w->rng, 0});
    }
    if (!met) {
        p->light = path_beyond(s, w->ray.dir, 0);
        return false;
    }
    p->vertex = path_vertex_make(s, &w->ray, &w->hit, w->cone.width, &w->work);
    p->light = path_emission(s, &p->vertex);
    return true;
}

static void put_material(struct way *w, uint32_t bounce)
{
    const struct stage *s = w->stage;
    struct path_vertex *v = &w->path.vertex;
    const struct material *m = (const struct material *)stage_at(s, s->materials) + v->at.material;
    if (s->wrapped && v->material == m) {
        const struct material_side side = {v->at.material, v->wo[2] < 0, &v->point};
        v->material = material_at(s, &side, rng_single(&w->rng, rng_dimension_choice(bounce)));
    }
    if (s->slots.count)
        v->material = textured_material(s, v->material, &v->point, &w->textured);
}

static void look_at_light(struct way *w, uint32_t bounce)
{
    const struct stage *s = w->stage;
    const struct path_lamp lamp = {rng_pair_bits(&w->rng, rng_dimension(bounce, RNG_LIGHT)), NULL};
    struct ray shadow;
    rgb light;
    if (s->emitters.count == 0 || !path_light_directly(s, &w->path, &lamp, &shadow, &light))
        return;
    if (!bvh_hit_any(s, &shadow))
        w->path.light += light;
    else if (s->masked)
        w->path.light += light * path_mask_share(s, shadow, &w->work);
}

static bool arrive(struct way *w, uint32_t bounce)
{
    const struct stage *s = w->stage;
    struct path *p = &w->path;
    const bool met = meets(w, &w->rng, bounce);
    if (s->pyramids.count && met)
        w->cone = cone_along(cone_scatter(w->cone, p->pdf_w), w->hit.t);
    if (s->media)
        return path_media_arrive(s, p,
                                 &(struct path_media_way){&w->ray, met ? &w->hit : NULL,
                                                          w->cone.width, &w->rng, bounce});
    if (!met) {
        p->light += p->throughput * path_beyond(s, w->ray.dir, p->pdf_w);
        return false;
    }
    const struct path_vertex v = path_vertex_make(s, &w->ray, &w->hit, w->cone.width, &w->work);
    path_arrive(s, p, &v);
    return true;
}

rgb trial_path(const struct stage *s, uint32_t x_px, uint32_t y_px, uint32_t sample,
               uint32_t roulette_begin)
{
    struct way w = {.stage = s, .rng = rng_make(s->settings.seed, x_px, y_px, sample)};
    const struct rng elder = rng_elder(&w.rng);
    w.ray = camera_ray_of(s, &elder, x_px, y_px);
    bool goes_on = begin(&w);
    for (uint32_t bounce = 0; goes_on && bounce < s->settings.max_bounces; bounce++) {
        put_material(&w, bounce);
        look_at_light(&w, bounce);
        const struct path_draw draw = {
            .direction = rng_pair(&w.rng, rng_dimension(bounce, RNG_BSDF_DIRECTION)),
            .lobe = rng_single(&w.rng, rng_dimension(bounce, RNG_BSDF_LOBE)),
            .roulette = rng_single(&w.rng, rng_dimension(bounce, RNG_ROULETTE)),
            .first = bounce == 0,
            .may_end = bounce >= roulette_begin,
        };
        goes_on = path_scatter(s, &w.path, &draw, &w.ray) && arrive(&w, bounce + 1);
    }
    return w.path.light;
}
