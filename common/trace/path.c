/* SPDX-License-Identifier: MIT */
#include "common/trace/path.h"

#include "common/trace/bsdf.h"
#include "common/trace/light.h"
#include "common/trace/path_media.h"
#include "common/trace/textured.h"
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

struct path_vertex path_vertex_make(const struct stage *s, const struct ray *ray,
                                    const struct ray_hit *hit, float width)
{
    struct path_vertex v; /* its point stays unset when nothing is textured */
    v.at = surface_at(s, ray, hit);
    v.frame = warp_frame_make(v.at.ng);
    v.material = (const struct material *)stage_at(s, s->materials) + v.at.material;
    v.wo = warp_to_local(&v.frame, -ray->dir);
    if (s->slots.count && textured_needs(v.material))
        v.point = textured_point(s, ray, hit, &v.at, width);
    return v;
}

rgb path_beyond(const struct stage *s, vec3 dir, float pdf_w)
{
    rgb light = s->sky;
    for (uint32_t e = s->beyond_begin; e < s->emitters.count; e++) {
        const rgb found = light_beyond(s, e, dir);
        if (!rgb_is_black(found))
            light += found * (pdf_w == 0 ? 1 : mis_weight(pdf_w, light_beyond_pdf_w(s, e, dir)));
    }
    return light;
}

rgb path_emission(const struct stage *s, const struct path_vertex *v)
{
    if (v->at.emitter == STAGE_NONE || !(v->wo[2] > 0))
        return (rgb){0, 0, 0, 0};
    return vec3_load(((const struct emitter *)stage_at(s, s->emitters))[v->at.emitter].radiance);
}

bool path_light_directly(const struct stage *s, const struct path *p, struct sobol_bits lamp,
                         struct ray *shadow, rgb *light)
{
    const struct path_vertex *v = &p->vertex;
    const struct material *m = v->material;
    if (s->emitters.count == 0 || bsdf_is_delta(m))
        return false;
    struct light_sample sample;
    if (!light_sample(s, &v->at, lamp, &sample))
        return false;
    const vec3 wi = warp_to_local(&v->frame, sample.wi);
    rgb f = bsdf_eval(m, v->wo, wi);
    if (rgb_is_black(f))
        return false;
    f *= sample.value;
    if (sample.pdf_w != 0)
        f *= mis_weight(sample.pdf_w, bsdf_pdf_w(m, v->wo, wi));
    if (p->media)
        f *= path_media_passed(s, p, wi, &sample.shadow);
    *shadow = sample.shadow;
    *light = p->throughput * f;
    return true;
}

bool path_scatter(struct path *p, const struct path_draw *draw, struct ray *ray)
{
    const struct path_vertex *v = &p->vertex;
    struct bsdf_sample next;
    if (!bsdf_sample(v->material, v->wo, draw->lobe, draw->direction, &next))
        return false;
    p->throughput *= next.weight;
    if (rgb_is_black(p->throughput))
        return false;
    p->scale = draw->first ? rgb_max(p->throughput) : p->scale * next.scale;
    p->pdf_w = next.pdf_w;
    const vec3 dir = warp_to_world(&v->frame, next.wi);
    if (!(vec3_dot(dir, v->at.ng) * next.wi[2] > 0)) /* rounding put it on the wrong side */
        return false;
    if (draw->may_end) { /* a channel weaker than the strongest only gains */
        const float q = survival(rgb_max(p->throughput) / p->scale);
        if (q < 1) {
            if (draw->roulette >= q)
                return false;
            p->throughput /= q;
        }
    }
    if (p->media)
        path_media_leave(p, next.wi);
    *ray = surface_leave(&v->at, dir);
    return true;
}

void path_arrive(const struct stage *s, struct path *p, const struct path_vertex *v)
{
    const vec3 from = p->vertex.at.p;
    p->vertex = *v;

    /* Emission found by the BSDF's sampling; a delta lobe's by nothing else */
    const rgb found = path_emission(s, v);
    if (rgb_is_black(found))
        return;
    const float weight = p->pdf_w == 0 ? 1 : mis_weight(p->pdf_w, light_pdf_w(s, from, &v->at));
    p->light += p->throughput * found * weight;
}
