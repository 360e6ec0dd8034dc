/* SPDX-License-Identifier: MIT */
#include "common/trace/path.h"

#include "common/trace/bsdf.h"
#include "common/trace/bvh.h"
#include "common/trace/light.h"
#include "common/trace/path_shade.h"
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

static inline __attribute__((always_inline)) struct path_vertex
vertex_make(const struct stage *s, const struct ray *ray, const struct ray_hit *hit)
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

void path_begin(const struct stage *s, const struct ray rays[], uint32_t count,
                struct path_start starts[])
{
    struct ray_hit hits[PATH_WAVE];
    const uint32_t found = bvh_hit_closest_8(s, rays, count, hits);
    for (uint32_t i = 0; i < count; i++) {
        struct path_start *start = &starts[i];
        start->ends = !(found >> i & 1);
        if (start->ends) {
            start->light = s->sky;
            continue;
        }
        start->vertex = vertex_make(s, &rays[i], &hits[i]);
        if (s->details.count)
            path_shade(s, &rays[i], &hits[i], &start->vertex, &start->raised);
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
    struct path_raised raised[PATH_WAVE]; /* in a scene with details */

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

/* The same light for the directions that only a raised point has: few, so they are traced at once.
 */
static __attribute__((cold, noinline)) void light_raised(struct wave *w, uint32_t path,
                                                         struct sobol_bits place)
{
    const struct path_vertex *v = &w->paths[path].vertex;
    const struct path_raised *raised = &w->raised[path];
    const struct surface from = path_shade_raised(raised, v);
    struct light_sample light;
    if (!raised->is || !light_sample(w->stage, &from, place, &light))
        return;
    const vec3 wi = warp_to_local(&v->frame, light.wi);
    if (!path_shade_is_raised(raised, v, light.wi, wi))
        return;
    rgb f = bsdf_eval(v->material, v->wo, wi) * light.value;
    if (rgb_is_black(f) || !path_shade_is_clear(w->stage, raised, v) ||
        bvh_hit_any(w->stage, &light.shadow))
        return;
    if (light.pdf_w != 0)
        f *= mis_weight(light.pdf_w, bsdf_pdf_w(v->material, v->wo, wi));
    w->paths[path].light += w->paths[path].throughput * f;
}

/* Light that may reach the vertex from one chosen emitter and goes on to wo, MIS-weighted. */
static inline __attribute__((always_inline)) void light_directly(struct wave *w, uint32_t path,
                                                                 bool details)
{
    const struct stage *s = w->stage;
    struct path *p = &w->paths[path];
    const struct path_vertex *v = &p->vertex;
    const struct material *m = v->material;
    if (s->emitters.count == 0 || bsdf_is_delta(m))
        return;
    const struct sobol_bits place = {w->lamp.u[path], w->lamp.v[path]};
    if (details)
        light_raised(w, path, place);
    struct light_sample light;
    if (!light_sample(s, &v->at, place, &light))
        return;
    const vec3 wi = warp_to_local(&v->frame, light.wi);
    if (details && !(vec3_dot(light.wi, v->at.ng) * wi[2] > 0))
        return;
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
static inline __attribute__((always_inline)) bool scatter(struct wave *w, uint32_t path,
                                                          bool details, struct ray *ray)
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
    if (!(vec3_dot(dir, v->at.ng) * next.wi[2] > 0) && /* by rounding, or a shading normal */
        !(details && path_shade_move(w->stage, &w->raised[path], &p->vertex, dir, next.wi)))
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
static inline __attribute__((always_inline)) bool arrive(struct wave *w, uint32_t path,
                                                         bool details, const struct ray *ray,
                                                         const struct ray_hit *hit)
{
    const struct stage *s = w->stage;
    struct path *p = &w->paths[path];
    if (!hit) {
        p->light += p->throughput * s->sky;
        return false;
    }
    const vec3 from = p->vertex.at.p;
    p->vertex = vertex_make(s, ray, hit);
    if (details)
        path_shade(s, ray, hit, &p->vertex, &w->raised[path]);

    /* Emission found by the BSDF's sampling; a delta lobe's by nothing else */
    const rgb found = emission(s, &p->vertex);
    if (!rgb_is_black(found)) {
        const float weight =
            p->pdf_w == 0 ? 1 : mis_weight(p->pdf_w, light_pdf_w(s, from, &p->vertex.at));
        p->light += p->throughput * found * weight;
    }
    return w->bounce + 1 < s->settings.max_bounces;
}

static inline __attribute__((always_inline)) void draw(struct wave *w)
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

/* All paths from their vertices to the next ones. details: whether the scene has any; a constant,
 * so that a scene without them does without asking. */
static inline __attribute__((always_inline)) void wave_step(struct wave *w, const bool details)
{
    uint32_t going = 0;
    draw(w);
    w->shadow_count = 0;
    for (uint32_t i = 0; i < w->going; i++) {
        const uint32_t path = w->path_of[i];
        light_directly(w, path, details);
        w->path_of[going] = path;
        going += scatter(w, path, details, &w->rays[going]);
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
        w->going += arrive(w, path, details, &w->rays[i], found >> i & 1 ? &hits[i] : NULL);
    }
    w->bounce++;
}

static __attribute__((noinline)) void follow_details(struct wave *w)
{
    while (w->going)
        wave_step(w, true);
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
        if (s->details.count)
            w.raised[i] = starts[i].raised;
        w.path_of[w.going++] = i;
    }
    if (s->details.count)
        follow_details(&w);
    while (w.going)
        wave_step(&w, false);
    for (uint32_t i = 0; i < count; i++)
        radiance[i] = w.paths[i].light;
}
