/* SPDX-License-Identifier: MIT */
#include "common/trace/path_mask.h"

#include "common/trace/bvh.h"
#include "common/trace/material.h"
#include "common/trace/textured.h"

/* The rest of a ray behind a surface that it has met. A segment ends where it did. */
static struct ray beyond(const struct ray *ray, const struct surface *at)
{
    struct ray rest = surface_leave(at, ray->dir);
    rest.to = ray->to;
    if (ray->t_max <= 1) {
        rest.dir = ray->origin + ray->dir - rest.origin;
        rest.t_max = ray->t_max;
    }
    return rest;
}

/* Textures are looked at as finely as they are: what is averaged is whether the ray goes on. */
static float opacity(const struct stage *s, const struct ray *ray, const struct ray_hit *hit,
                     const struct surface *at)
{
    const struct material *m = (const struct material *)stage_at(s, s->materials) + at->material;
    struct texture_point point;
    if (s->slots.count && textured_needs(m))
        point = textured_point(s, ray, hit, at, 0);
    const struct material_side side = {at->material, vec3_dot(ray->dir, at->ng) > 0, &point};
    return material_opacity(s, &side);
}

static bool meets(const struct stage *s, const struct ray *ray, struct ray_hit *hit,
                  struct film_work *work)
{
    work->bounce_rays++;
    return bvh_hit_closest(s, ray, hit);
}

bool path_mask_stops(const struct stage *s, const struct path_mask_ray *r)
{
    struct ray *ray = r->ray;
    struct ray_hit *hit = r->hit;
    for (uint32_t crossing = r->crossing;; crossing++) {
        const struct surface at = surface_at(s, ray, hit);
        const float stops = opacity(s, ray, hit, &at);
        if (stops >= 1 || rng_single(r->rng, rng_dimension_mask(r->bounce, crossing)) < stops)
            return true;
        *ray = beyond(ray, &at);
        if (!meets(s, ray, hit, r->work))
            return false;
    }
}

uint32_t path_mask_pass(const struct stage *s, uint32_t found, const struct path_mask_rays *r)
{
    uint32_t stopped = 0;
    for (; found; found &= found - 1) {
        const uint32_t i = (uint32_t)__builtin_ctz(found);
        const struct path_mask_ray one = {&r->rngs[i], r->bounce[i], 0,
                                          &r->rays[i], &r->hits[i],  r->work};
        if (path_mask_stops(s, &one))
            stopped |= 1u << i;
    }
    return stopped;
}

float path_mask_share(const struct stage *s, struct ray shadow, struct film_work *work)
{
    float share = 1;
    struct ray_hit hit;
    while (meets(s, &shadow, &hit, work)) {
        const struct surface at = surface_at(s, &shadow, &hit);
        share *= 1 - opacity(s, &shadow, &hit, &at);
        if (!(share > 0))
            return 0;
        shadow = beyond(&shadow, &at);
    }
    return share;
}
