/* SPDX-License-Identifier: MIT */
#include "common/trace/path.h"

#include "common/trace/bsdf.h"
#include "common/trace/bvh.h"
#include "common/trace/glow.h"
#include "common/trace/light.h"
#include "common/trace/path_mask.h"
#include "common/trace/path_media.h"
#include "common/trace/textured.h"
#include "common/trace/path_shade.h"
#include "common/trace/warp.h"

/* The power heuristic with exponent 2 for the technique of density a beside one of density b. As a
 * quotient, so that no square leaves the range of float: a and b may be anything but both 0. */
static float mis_weight(float a, float b)
{
    const float r = b / a;
    return 1 / (1 + r * r);
}

static const struct path_trust trusts[] = {[STRATEGY_MIS] = {1, 1},
                                           [STRATEGY_LIGHT] = {0x1p+100f, 0x1p-100f},
                                           [STRATEGY_BSDF] = {0x1p-100f, 0x1p+100f}};

const struct path_trust *path_trust(const struct stage *s)
{
    return &trusts[s->settings.strategy];
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

float path_lit(const struct stage *s, const struct material *m, float up)
{
    if (!s->light_nodes.count || !bsdf_is_opaque(m))
        return 0;
    return up < 0 ? -1 : 1;
}

struct path_vertex path_vertex_make(const struct stage *s, const struct ray *ray,
                                    const struct ray_hit *hit, float width, struct film_work *work)
{
    struct path_vertex v; /* its point stays unset when nothing is textured */
    v.at = surface_at(s, ray, hit);
    v.frame = warp_frame_make(v.at.ng);
    v.material = (const struct material *)stage_at(s, s->materials) + v.at.material;
    v.wo = warp_to_local(&v.frame, -ray->dir);
    v.raised.is = false;
    if (((s->slots.count || s->reliefs.count) && textured_needs(v.material)) ||
        (s->glowing && glow_is(s, v.at.emitter)))
        v.point = textured_point(s, ray, hit, &v.at, width);
    if (s->details.count)
        path_shade(s, ray, hit, &v, work);
    v.at.lit = path_lit(s, v.material, v.wo[2]);
    return v;
}

rgb path_beyond(const struct stage *s, vec3 dir, float pdf_w)
{
    rgb light = s->sky;
    for (uint32_t e = s->beyond_begin; e < s->emitters.count; e++) {
        float sampled;
        const rgb found = light_beyond(s, e, dir, &sampled);
        if (!rgb_is_black(found))
            light += found * (pdf_w == 0 ? 1 : mis_weight(pdf_w, sampled * path_trust(s)->light));
    }
    return light;
}

rgb path_emission(const struct stage *s, const struct path_vertex *v)
{
    if (v->at.emitter == STAGE_NONE || !(v->wo[2] > 0))
        return (rgb){0, 0, 0, 0};
    const struct emitter *e = stage_emitter_at(s, v->at.emitter);
    return e->texture == STAGE_NONE ? vec3_load(e->radiance) : glow_at(s, e, &v->point);
}

/* What of a chosen light goes on to wo, if nothing is in its way. */
static rgb reflected(const struct stage *s, const struct path *p, const struct light_sample *light,
                     vec3 wi)
{
    const struct path_vertex *v = &p->vertex;
    rgb f = bsdf_eval(v->material, v->wo, wi);
    if (rgb_is_black(f))
        return f;
    f *= light->value;
    if (light->pdf_w != 0)
        f *= mis_weight(light->pdf_w, bsdf_pdf_w(v->material, v->wo, wi) * path_trust(s)->bsdf);
    if (p->media)
        f *= path_media_passed(s, p, wi, &light->shadow);
    return p->throughput * f;
}

/* The same light for the directions that only a raised point has: few, so they are traced at once.
 */
static void light_raised(const struct stage *s, struct path *p, struct sobol_bits lamp)
{
    const struct path_vertex *v = &p->vertex;
    const struct surface from = path_shade_raised(v);
    struct light_sample sample;
    if (!light_sample(s, &from, lamp, &sample))
        return;
    const vec3 wi = warp_to_local(&v->frame, sample.wi);
    if (!path_shade_is_raised(v, sample.wi, wi))
        return;
    const rgb light = reflected(s, p, &sample, wi);
    if (rgb_is_black(light) || !path_shade_is_clear(s, v, p->work))
        return;
    p->work->shadow_rays++;
    if (!bvh_hit_any(s, &sample.shadow))
        p->light += light;
    else if (s->masked)
        p->light += light * path_mask_share(s, sample.shadow, p->work);
}

bool path_light_directly(const struct stage *s, struct path *p, const struct path_lamp *lamp,
                         struct ray *shadow, rgb *light)
{
    const struct path_vertex *v = &p->vertex;
    if (s->emitters.count == 0 || bsdf_is_delta(v->material))
        return false;
    if (v->raised.is)
        light_raised(s, p, lamp->bits);
    struct light_sample sample;
    if (!(lamp->pick ? light_sample_picked(s, &v->at, *lamp->pick, lamp->bits.v, &sample)
                     : light_sample(s, &v->at, lamp->bits, &sample)))
        return false;
    const vec3 wi = warp_to_local(&v->frame, sample.wi);
    if (!(vec3_dot(sample.wi, v->at.ng) * wi[2] > 0)) /* the two normals disagree */
        return false;
    *light = reflected(s, p, &sample, wi);
    *shadow = sample.shadow;
    return !rgb_is_black(*light); /* the strategy may give it no weight */
}

bool path_scatter(const struct stage *s, struct path *p, const struct path_draw *draw,
                  struct ray *ray)
{
    struct path_vertex *v = &p->vertex;
    struct bsdf_sample next;
    if (!bsdf_sample(v->material, v->wo, draw->lobe, draw->direction, &next))
        return false;
    p->throughput *= next.weight;
    if (rgb_is_black(p->throughput))
        return false;
    p->scale = draw->first ? rgb_max(p->throughput) : p->scale * next.scale;
    p->pdf_w = next.pdf_w;
    const vec3 dir = warp_to_world(&v->frame, next.wi);
    if (!(vec3_dot(dir, v->at.ng) * next.wi[2] > 0) && /* by rounding, or a shading normal */
        !path_shade_move(s, v, dir, next.wi, p->work))
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

float path_emission_weight(const struct stage *s, const struct surface *from,
                           const struct surface *at, float pdf_w)
{
    if (pdf_w == 0)
        return 1;
    return mis_weight(pdf_w, light_pdf_w(s, from, at) * path_trust(s)->light);
}

void path_arrive(const struct stage *s, struct path *p, const struct path_vertex *v)
{
    const struct surface from = p->vertex.at;
    p->vertex = *v;

    /* Emission found by the BSDF's sampling; a delta lobe's by nothing else */
    const rgb found = path_emission(s, v);
    if (rgb_is_black(found))
        return;
    p->light += p->throughput * found * path_emission_weight(s, &from, &v->at, p->pdf_w);
}
