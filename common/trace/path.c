/* SPDX-License-Identifier: MIT */
#include "common/trace/path.h"

#include "common/trace/bsdf.h"
#include "common/trace/bvh.h"
#include "common/trace/light.h"
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
    struct path_vertex v = {
        .at = at,
        .frame = frame,
        .material = (const struct material *)stage_at(s, s->materials) + at.material,
        .wo = warp_to_local(&frame, -ray->dir),
    };
    if (s->light_nodes.count && bsdf_is_opaque(v.material))
        v.at.lit = v.wo[2] < 0 ? -1 : 1;
    return v;
}

/* What a ray that leaves the scene meets. pdf_w: of its direction, by the sampling that made it; 0:
 * nothing else could have made it. */
static rgb beyond(const struct stage *s, vec3 dir, float pdf_w)
{
    rgb light = s->sky;
    for (uint32_t e = s->beyond_begin; e < s->emitters.count; e++) {
        const rgb found = light_beyond(s, e, dir);
        if (!rgb_is_black(found))
            light += found * (pdf_w == 0 ? 1 : mis_weight(pdf_w, light_beyond_pdf_w(s, e, dir)));
    }
    return light;
}

/* What the vertex emits to where the ray came from. */
static rgb emission(const struct stage *s, const struct path_vertex *v)
{
    if (v->at.emitter == STAGE_NONE || !(v->wo[2] > 0))
        return (rgb){0, 0, 0, 0};
    return vec3_load(((const struct emitter *)stage_at(s, s->emitters))[v->at.emitter].radiance);
}

void path_begin(const struct stage *s, const struct ray rays[], uint32_t count,
                struct path_start starts[])
{
    struct ray_hit hits[PATH_WAVE];
    const uint32_t found = bvh_hit_closest_8(s, rays, count, hits);
    for (uint32_t i = 0; i < count; i++) {
        struct path_start *start = &starts[i];
        start->ends = !(found >> i & 1);
        if (start->ends) {
            start->light = beyond(s, rays[i].dir, 0);
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
    struct rng8 rng;
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

/* Which of many lights is sampled, by path. */
static void pick_lights(const struct wave *w, struct light_pick picks[PATH_WAVE])
{
    const struct surface *from[PATH_WAVE];
    uint32_t path_of[PATH_WAVE], bits[PATH_WAVE], count = 0;
    struct light_pick found[PATH_WAVE];
    for (uint32_t i = 0; i < w->going; i++) {
        const uint32_t path = w->path_of[i];
        const struct path_vertex *v = &w->paths[path].vertex;
        if (bsdf_is_delta(v->material))
            continue;
        from[count] = &v->at;
        bits[count] = w->lamp.u[path];
        path_of[count++] = path;
    }
    light_pick(w->stage, from, bits, count, found);
    for (uint32_t i = 0; i < count; i++)
        picks[path_of[i]] = found[i];
}

/* Light that may reach the vertex from one chosen emitter and goes on to wo, MIS-weighted. */
static void light_directly(struct wave *w, uint32_t path, const struct light_pick *pick)
{
    const struct stage *s = w->stage;
    const struct path *p = &w->paths[path];
    const struct path_vertex *v = &p->vertex;
    const struct material *m = v->material;
    if (s->emitters.count == 0 || bsdf_is_delta(m))
        return;
    const struct sobol_bits place = {w->lamp.u[path], w->lamp.v[path]};
    struct light_sample light;
    if (!(pick ? light_sample_picked(s, &v->at, *pick, place.v, &light)
               : light_sample(s, &v->at, place, &light)))
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
        p->light += p->throughput * beyond(s, ray->dir, p->pdf_w);
        return false;
    }
    const struct surface from = p->vertex.at;
    p->vertex = vertex_make(s, ray, hit);

    /* Emission found by the BSDF's sampling; a delta lobe's by nothing else */
    const rgb found = emission(s, &p->vertex);
    if (!rgb_is_black(found)) {
        const float weight =
            p->pdf_w == 0 ? 1 : mis_weight(p->pdf_w, light_pdf_w(s, &from, &p->vertex.at));
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

/* All paths from their vertices to the next ones. */
static void wave_step(struct wave *w)
{
    uint32_t going = 0;
    draw(w);
    w->shadow_count = 0;
    struct light_pick picks[PATH_WAVE];
    const bool picked = w->stage->light_nodes.count > 0;
    if (picked)
        pick_lights(w, picks);
    for (uint32_t i = 0; i < w->going; i++) {
        const uint32_t path = w->path_of[i];
        light_directly(w, path, picked ? &picks[path] : NULL);
        w->path_of[going] = path;
        going += scatter(w, path, &w->rays[going]);
    }
    const uint32_t dark = bvh_hit_any_8(w->stage, w->shadows, w->shadow_count);
    for (uint32_t i = 0; i < w->shadow_count; i++)
        if (!(dark >> i & 1))
            w->paths[w->shadow_path[i]].light += w->light[i];

    struct ray_hit hits[PATH_WAVE];
    const uint32_t found = bvh_hit_closest_8(w->stage, w->rays, going, hits);
    w->going = 0;
    for (uint32_t i = 0; i < going; i++) {
        const uint32_t path = w->path_of[i];
        w->path_of[w->going] = path;
        w->going += arrive(w, path, &w->rays[i], found >> i & 1 ? &hits[i] : NULL);
    }
    w->bounce++;
}

void path_radiance(const struct stage *s, const struct path_start starts[], const struct rng rngs[],
                   uint32_t count, uint32_t roulette_begin, rgb radiance[])
{
    struct wave w;
    w.stage = s;
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
    while (w.going)
        wave_step(&w);
    for (uint32_t i = 0; i < count; i++)
        radiance[i] = w.paths[i].light;
}
