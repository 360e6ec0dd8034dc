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

/* Light that reaches the vertex from one chosen emitter and goes on to wo, MIS-weighted. */
static rgb light_directly(const struct stage *s, const struct path_vertex *v, const struct rng *rng,
                          uint32_t bounce)
{
    const rgb black = {0, 0, 0, 0};
    const struct material *m = v->material;
    const struct sobol_bits place = rng_pair_bits(rng, rng_dimension(bounce, RNG_LIGHT));
    struct light_sample light;
    if (!light_sample(s, &v->at, place, &light))
        return black;
    const vec3 wi = warp_to_local(&v->frame, light.wi);
    const rgb f = bsdf_eval(m, v->wo, wi);
    if (rgb_is_black(f) || bvh_hit_any(s, &light.shadow))
        return black;
    if (light.pdf_w == 0)
        return f * light.value;
    return f * light.value * mis_weight(light.pdf_w, bsdf_pdf_w(m, v->wo, wi));
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

void path_begin(const struct stage *s, struct ray ray, struct path_start *start)
{
    struct ray_hit hit;
    start->ends = !bvh_hit_closest(s, &ray, &hit);
    if (start->ends) {
        start->light = s->sky;
        return;
    }
    start->vertex = vertex_make(s, &ray, &hit);
    start->light = emission(s, &start->vertex);
    start->ends = s->settings.max_bounces == 0;
}

rgb path_radiance(const struct stage *s, const struct path_start *start, const struct rng *rng,
                  uint32_t roulette_begin)
{
    rgb light = start->light;
    if (start->ends)
        return light;
    struct path_vertex v = start->vertex;
    struct square direction = rng_pair(rng, rng_dimension(0, RNG_BSDF_DIRECTION));
    rgb throughput = {1, 1, 1, 0};
    float scale = 1; /* what roulette divides out of throughput */

    for (uint32_t bounce = 0;; bounce++) {
        /* Emission found by next-event estimation */
        if (s->emitters.count > 0 && !bsdf_is_delta(v.material))
            light += throughput * light_directly(s, &v, rng, bounce);

        /* Scattering */
        const float lobe =
            bsdf_has_lobes(v.material) ? rng_single(rng, rng_dimension(bounce, RNG_BSDF_LOBE)) : 0;
        struct bsdf_sample next;
        if (!bsdf_sample(v.material, v.wo, lobe, direction, &next))
            return light;
        throughput *= next.weight;
        if (rgb_is_black(throughput))
            return light;
        scale = bounce == 0 ? rgb_max(throughput) : scale * next.scale;
        const vec3 dir = warp_to_world(&v.frame, next.wi);
        if (!(vec3_dot(dir, v.at.ng) * next.wi[2] > 0)) /* rounding put it on the wrong side */
            return light;
        const struct ray ray = surface_leave(&v.at, dir);

        /* Russian roulette; a channel weaker than the strongest only gains */
        if (bounce >= roulette_begin) {
            const float q = survival(rgb_max(throughput) / scale);
            if (q < 1) {
                if (rng_single(rng, rng_dimension(bounce, RNG_ROULETTE)) >= q)
                    return light;
                throughput /= q;
            }
        }

        /* The next vertex, or the sky */
        const vec3 from = v.at.p;
        struct ray_hit hit;
        if (!bvh_hit_closest(s, &ray, &hit))
            return light + throughput * s->sky;
        /* Drawn here, because it takes as long as the vertex and waits for nothing */
        direction = rng_pair(rng, rng_dimension(bounce + 1, RNG_BSDF_DIRECTION));
        v = vertex_make(s, &ray, &hit);

        /* Emission found by the BSDF's sampling; a delta lobe's by nothing else */
        const rgb found = emission(s, &v);
        if (!rgb_is_black(found)) {
            const float weight =
                next.pdf_w == 0 ? 1 : mis_weight(next.pdf_w, light_pdf_w(s, from, &v.at));
            light += throughput * found * weight;
        }
        if (bounce + 1 == s->settings.max_bounces)
            return light;
    }
}
