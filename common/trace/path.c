/* SPDX-License-Identifier: MIT */
#include "common/trace/path.h"

#include <string.h>

#include "common/trace/bsdf.h"
#include "common/trace/bvh.h"
#include "common/trace/light.h"
#include "common/trace/material.h"
#include "common/trace/path_mask.h"
#include "common/trace/warp.h"

/* The power heuristic with exponent 2 for the technique of density a beside one of density b. As a
 * quotient, so that no square leaves the range of float: a and b may be anything but both 0. */
static float mis_weight(float a, float b)
{
    const float r = b / a;
    return 1 / (1 + r * r);
}

/* Russian roulette: the chance to go on. `share` is the path's throughput, relative to what its
 * first scattering left of it: what all paths of the pixel have lost alike makes none of them less
 * important. (And relative to what refraction alone has put into it, which leaving the glass takes
 * out again.) Nothing happens to a share of a half; from there on survivors all carry a half. A
 * smaller bound spends rays on paths that hardly count, a larger one ends those that reach a lamp
 * through glass. In a furnace of albedo a the chance becomes a per bounce: the variance is finite
 * exactly when the chance exceeds a^2 (the second moment of the series must converge), and a > a^2
 * always. J. Arvo, D. Kirk, "Particle Transport and Image Synthesis", SIGGRAPH 1990. */
static float survival(float share)
{
    const float q = 2 * share;
    return q < 1 ? q : 1;
}

static struct path_vertex vertex_make(const struct stage *s, const struct ray *ray,
                                      const struct ray_hit *hit)
{
    const struct surface at = surface_at(s, ray, hit);
    const struct warp_frame frame = warp_frame_make(at.ng);
    return (struct path_vertex){
        .at = at,
        .frame = frame,
        .material = (const struct material *)stage_at(s, s->materials) + at.material,
        .wo = warp_to_local(&frame, -ray->dir),
    };
}

/* What the vertex emits to where the ray came from. */
static rgb emission(const struct stage *s, const struct path_vertex *v)
{
    if (v->at.emitter == STAGE_NONE || !(v->wo[2] > 0))
        return (rgb){0, 0, 0, 0};
    return vec3_load(((const struct emitter *)stage_at(s, s->emitters))[v->at.emitter].radiance);
}

/* Siblings share the ray, so they share its numbers. */
static uint32_t pass_masks(const struct stage *s, const struct rng rngs[], uint32_t count,
                           uint32_t found, struct ray rays[], struct ray_hit hits[])
{
    struct rng elders[PATH_WAVE];
    for (uint32_t i = 0; i < count; i++)
        elders[i] = rng_elder(&rngs[i]);
    const struct path_mask_rays r = {rays, hits, elders, NULL, 0, count};
    return path_mask_pass(s, &r, found);
}

void path_begin(const struct stage *s, const struct ray rays[], const struct rng rngs[],
                uint32_t count, struct path_start starts[])
{
    struct ray passed[PATH_WAVE];
    struct ray_hit hits[PATH_WAVE];
    uint32_t found = bvh_hit_closest_8(s, rays, count, hits);
    if (s->masked) {
        memcpy(passed, rays, count * sizeof *rays);
        found = pass_masks(s, rngs, count, found, passed, hits);
        rays = passed;
    }
    for (uint32_t i = 0; i < count; i++) {
        struct path_start *start = &starts[i];
        start->met = found >> i & 1;
        start->ends = !start->met;
        if (start->ends) {
            start->light = s->sky;
            continue;
        }
        start->vertex = vertex_make(s, &rays[i], &hits[i]);
        start->light = emission(s, &start->vertex);
        start->ends = s->settings.max_bounces == 0;
    }
}

/* --- paths in step --- */

struct path {
    rgb light; /* found so far */
    rgb throughput;
    float scale; /* what roulette divides out of throughput; from the first scattering on */
    float pdf_w; /* of the last direction; 0: a delta lobe's, which next-event estimation cannot
                  * make */
    struct path_vertex vertex;
};

struct wave {
    const struct stage *stage;
    const struct rng *rngs; /* by path */
    struct rng8 rng;        /* the same, of all */
    uint32_t bounce, roulette_begin;
    struct path paths[PATH_WAVE];

    /* A bounce's random numbers, by path: made for all at once, which costs less than for two of
     * them alone. */
    struct sobol8_bits lamp;
    struct sobol8_square direction;
    f32x8 lobe, roulette;

    uint32_t going; /* paths that have a next ray */
    uint32_t path_of[PATH_WAVE];
    struct ray rays[PATH_WAVE];

    uint32_t shadow_count; /* light that arrives if nothing is in its way */
    uint32_t shadow_path[PATH_WAVE];
    struct ray shadows[PATH_WAVE];
    rgb light[PATH_WAVE];
};

/* Light that may reach the vertex from one chosen emitter and goes on to wo, MIS-weighted. */
static void light_directly(struct wave *w, uint32_t path)
{
    const struct stage *s = w->stage;
    const struct path *p = &w->paths[path];
    const struct path_vertex *v = &p->vertex;
    const struct material *m = v->material;
    if (s->emitters.count == 0 || bsdf_is_delta(m))
        return;
    const struct sobol_bits place = {w->lamp.u[path], w->lamp.v[path]};
    struct light_sample light;
    if (!light_sample(s, &v->at, place, &light))
        return;
    const vec3 wi = warp_to_local(&v->frame, light.wi);
    rgb f = bsdf_eval(m, v->wo, wi);
    if (rgb_is_black(f))
        return;
    f *= light.value;
    if (light.pdf_w != 0)
        f *= mis_weight(light.pdf_w, bsdf_pdf_w(m, v->wo, wi));
    w->shadow_path[w->shadow_count] = path;
    w->shadows[w->shadow_count] = light.shadow;
    w->light[w->shadow_count++] = p->throughput * f;
}

/* The next ray; false: there is none. */
static bool scatter(struct wave *w, uint32_t path, struct ray *ray)
{
    struct path *p = &w->paths[path];
    const struct path_vertex *v = &p->vertex;
    const struct square direction = {w->direction.u[path], w->direction.v[path]};
    struct bsdf_sample next;
    if (!bsdf_sample(v->material, v->wo, w->lobe[path], direction, &next))
        return false;
    p->throughput *= next.weight;
    if (rgb_is_black(p->throughput))
        return false;
    p->scale = w->bounce == 0 ? rgb_max(p->throughput) : p->scale * next.scale;
    p->pdf_w = next.pdf_w;
    const vec3 dir = warp_to_world(&v->frame, next.wi);
    if (!(vec3_dot(dir, v->at.ng) * next.wi[2] > 0)) /* rounding put it on the wrong side */
        return false;
    if (w->bounce >= w->roulette_begin) { /* a channel weaker than the strongest only gains */
        const float q = survival(rgb_max(p->throughput) / p->scale);
        if (q < 1) {
            if (w->roulette[path] >= q)
                return false;
            p->throughput /= q;
        }
    }
    *ray = surface_leave(&v->at, dir);
    return true;
}

/* The next vertex, or the sky. False: the path ends there. */
static bool arrive(struct wave *w, uint32_t path, const struct ray *ray, const struct ray_hit *hit)
{
    const struct stage *s = w->stage;
    struct path *p = &w->paths[path];
    if (!hit) {
        p->light += p->throughput * s->sky;
        return false;
    }
    const vec3 from = p->vertex.at.p;
    p->vertex = vertex_make(s, ray, hit);

    /* Emission found by the BSDF's sampling; a delta lobe's by nothing else */
    const rgb found = emission(s, &p->vertex);
    if (!rgb_is_black(found)) {
        const float weight =
            p->pdf_w == 0 ? 1 : mis_weight(p->pdf_w, light_pdf_w(s, from, &p->vertex.at));
        p->light += p->throughput * found * weight;
    }
    return w->bounce + 1 < s->settings.max_bounces;
}

static void draw(struct wave *w)
{
    bool lobes = false;
    for (uint32_t i = 0; i < w->going; i++)
        lobes = lobes || bsdf_has_lobes(w->paths[w->path_of[i]].vertex.material);
    w->direction = rng8_pair(&w->rng, rng_dimension(w->bounce, RNG_BSDF_DIRECTION));
    if (w->stage->emitters.count > 0)
        w->lamp = rng8_pair_bits(&w->rng, rng_dimension(w->bounce, RNG_LIGHT));
    if (lobes)
        w->lobe = rng8_single(&w->rng, rng_dimension(w->bounce, RNG_BSDF_LOBE));
    if (w->bounce >= w->roulette_begin)
        w->roulette = rng8_single(&w->rng, rng_dimension(w->bounce, RNG_ROULETTE));
}

/* The vertices' materials, where some are made of others. */
static void choose_materials(struct wave *w)
{
    const f32x8 number = rng8_single(&w->rng, rng_dimension_choice(w->bounce));
    for (uint32_t i = 0; i < w->going; i++) {
        struct path_vertex *v = &w->paths[w->path_of[i]].vertex;
        v->material = material_at(w->stage, v->at.material, v->wo[2] < 0, number[w->path_of[i]]);
    }
}

/* What comes along the shadow rays that meet something. */
static void light_through_masks(struct wave *w, uint32_t dark)
{
    for (uint32_t i = 0; i < w->shadow_count; i++)
        if (dark >> i & 1)
            w->paths[w->shadow_path[i]].light +=
                w->light[i] * path_mask_share(w->stage, w->shadows[i]);
}

/* All paths from their vertices to the next ones. */
static void wave_step(struct wave *w)
{
    uint32_t going = 0;
    if (w->stage->wrapped)
        choose_materials(w);
    draw(w);
    w->shadow_count = 0;
    for (uint32_t i = 0; i < w->going; i++) {
        const uint32_t path = w->path_of[i];
        light_directly(w, path);
        w->path_of[going] = path;
        going += scatter(w, path, &w->rays[going]);
    }
    const uint32_t dark = bvh_hit_any_8(w->stage, w->shadows, w->shadow_count);
    for (uint32_t i = 0; i < w->shadow_count; i++)
        if (!(dark >> i & 1))
            w->paths[w->shadow_path[i]].light += w->light[i];

    if (w->stage->masked)
        light_through_masks(w, dark);
    struct ray_hit hits[PATH_WAVE];
    uint32_t found = bvh_hit_closest_8(w->stage, w->rays, going, hits);
    if (w->stage->masked) {
        const struct path_mask_rays r = {w->rays, hits, w->rngs, w->path_of, w->bounce + 1, going};
        found = path_mask_pass(w->stage, &r, found);
    }
    w->going = 0;
    for (uint32_t i = 0; i < going; i++) {
        const uint32_t path = w->path_of[i];
        w->path_of[w->going] = path;
        w->going += arrive(w, path, &w->rays[i], found >> i & 1 ? &hits[i] : NULL);
    }
    w->bounce++;
}

/* What has been found up to here. */
static void note_terms(const struct wave *w, struct path_terms *terms, uint32_t count)
{
    for (uint32_t i = 0; w->bounce < terms->count && i < count; i++)
        terms->light[w->bounce][i] = w->paths[i].light;
}

void path_radiance(const struct stage *s, const struct path_start starts[], const struct rng rngs[],
                   uint32_t count, uint32_t roulette_begin, struct path_terms *terms,
                   rgb radiance[])
{
    struct wave w;
    w.stage = s;
    w.rngs = rngs;
    w.bounce = w.going = 0;
    w.roulette_begin = roulette_begin;
    w.lobe = (f32x8){0};
    rng8_make(&w.rng, rngs, count);
    for (uint32_t i = 0; i < count; i++) {
        struct path *p = &w.paths[i];
        p->light = starts[i].light;
        if (starts[i].ends)
            continue;
        p->throughput = (rgb){1, 1, 1, 0};
        p->vertex = starts[i].vertex;
        w.path_of[w.going++] = i;
    }
    for (;;) {
        if (terms)
            note_terms(&w, terms, count);
        if (!w.going)
            break;
        wave_step(&w);
    }
    for (uint32_t i = 0; i < count; i++)
        radiance[i] = w.paths[i].light;
    for (uint32_t k = w.bounce + 1; terms && k < terms->count; k++)
        memcpy(terms->light[k], radiance, count * sizeof radiance[0]);
}
