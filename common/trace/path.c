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

/* Light that reaches `at` from one chosen emitter and goes on to wo, MIS-weighted. */
static rgb light_directly(const struct stage *s, const struct surface *at, const struct material *m,
                          const struct warp_frame *frame, vec3 wo, const struct rng *rng,
                          uint32_t bounce)
{
    const rgb black = {0, 0, 0, 0};
    const uint32_t pick =
        s->emitters.count > 1 ? rng_bits(rng, rng_dimension(bounce, RNG_LIGHT_PICK)) : 0;
    const struct square position = rng_pair(rng, rng_dimension(bounce, RNG_LIGHT_POSITION));
    struct light_sample light;
    if (!light_sample(s, at, pick, position, &light))
        return black;
    const vec3 wi = warp_to_local(frame, light.wi);
    const rgb f = bsdf_eval(m, wo, wi);
    if (rgb_is_black(f) || bvh_hit_any(s, &light.shadow))
        return black;
    if (light.pdf_w == 0)
        return f * light.value;
    return f * light.value * mis_weight(light.pdf_w, bsdf_pdf_w(m, wo, wi));
}

/* Russian roulette: the chance to go on. It is the path's throughput, relative to what it started
 * with: `scale` is what refraction alone has put into it, which leaving the glass takes out again.
 * Survivors then all carry the same weight. In a furnace of albedo a the chance is a per bounce
 * and the variance a mu^2: it is finite exactly when the chance exceeds a^2 (the second moment of
 * the series must converge), and a > a^2 always. A channel weaker than the strongest only
 * gains. J. Arvo, D. Kirk, "Particle Transport and Image Synthesis", SIGGRAPH 1990. */
static float survival(rgb throughput, float scale)
{
    const float q = rgb_max(throughput) / scale;
    return q < 1 ? q : 1;
}

rgb path_radiance(const struct stage *s, struct ray ray, const struct rng *rng,
                  uint32_t roulette_begin)
{
    const struct material *materials = stage_at(s, s->materials);
    rgb light = {0, 0, 0, 0};
    rgb throughput = {1, 1, 1, 0};
    float scale = 1;        /* the part of throughput that is change of radiance by refraction */
    float pdf_w = 0;        /* of the ray's direction; 0: camera ray or delta lobe, which
                             * next-event estimation cannot make */
    vec3 from = ray.origin; /* the last vertex, where next-event estimation was done */

    for (uint32_t bounce = 0;; bounce++) {
        /* The next vertex, or the sky */
        struct ray_hit hit;
        if (!bvh_hit_closest(s, &ray, &hit))
            return light + throughput * s->sky;
        /* Drawn here, because it takes as long as the vertex and waits for nothing */
        const struct square direction = rng_pair(rng, rng_dimension(bounce, RNG_BSDF_DIRECTION));
        const struct surface at = surface_at(s, &ray, &hit);
        const struct material *m = &materials[at.material];
        const struct warp_frame frame = warp_frame_make(at.ng);
        const vec3 wo = warp_to_local(&frame, -ray.dir);

        /* Emission found by the BSDF's sampling */
        if (at.emitter != STAGE_NONE && wo[2] > 0) {
            const struct emitter *e = (const struct emitter *)stage_at(s, s->emitters) + at.emitter;
            const float weight = pdf_w == 0 ? 1 : mis_weight(pdf_w, light_pdf_w(s, from, &at));
            light += throughput * vec3_load(e->radiance) * weight;
        }
        if (bounce == s->settings.max_bounces)
            return light;

        /* Emission found by next-event estimation */
        if (s->emitters.count > 0 && !bsdf_is_delta(m))
            light += throughput * light_directly(s, &at, m, &frame, wo, rng, bounce);

        /* Scattering */
        const float lobe =
            bsdf_has_lobes(m) ? rng_single(rng, rng_dimension(bounce, RNG_BSDF_LOBE)) : 0;
        struct bsdf_sample next;
        if (!bsdf_sample(m, wo, lobe, direction, &next))
            return light;
        throughput *= next.weight;
        if (rgb_is_black(throughput))
            return light;
        scale *= next.scale;
        pdf_w = next.pdf_w;
        from = at.p;
        const vec3 dir = warp_to_world(&frame, next.wi);
        if (!(vec3_dot(dir, at.ng) * next.wi[2] > 0)) /* rounding put it on the wrong side */
            return light;
        ray = surface_leave(&at, dir);

        /* Russian roulette */
        if (bounce >= roulette_begin) {
            const float q = survival(throughput, scale);
            if (q < 1) {
                if (rng_single(rng, rng_dimension(bounce, RNG_ROULETTE)) >= q)
                    return light;
                throughput /= q;
            }
        }
    }
}
