/* Light from points, spots and distant lights that meets something smooth first: no path from the
 * eye can find it. It is followed from the lights, and wherever something scatters it widely, what
 * goes to the eye from there counts. If smooth surfaces that light passes are all that stands
 * before the eye, it is seen through them: about as much, in about the same place, is what such
 * surfaces let through. (What is seen in mirrors is left out. So the share is a lower bound.)
 * SPDX-License-Identifier: MIT */
#include "common/trace/bsdf.h"
#include "common/trace/bvh.h"
#include "common/trace/light_spot.h"
#include "common/trace/study_lens.h"
#include "common/trace/study_parts.h"

enum {
    SALT = 2,
    BETWEEN = 64,     /* looks at whether to stop: paths */
    SCATTERINGS = 32, /* of a path from a light */
    PANES = 16,       /* before the eye */
    ROULETTE_BEGIN = 3,
};

static const float pi = 2 * FMATH_HALF_PI;

struct ball { /* around the scene */
    vec3 center;
    float radius;
};

static struct ball around(const struct stage *s)
{
    const vec3 lo = vec3_load(s->bounds[0]), hi = vec3_load(s->bounds[1]);
    return (struct ball){0.5f * (lo + hi), 0.5f * vec3_length(hi - lo)};
}

/* W, of all that leaves the light; of a spot as if it did not fall off. */
static float flux_of(const struct stage *s, const struct emitter *e)
{
    const float power = rgb_luminance(vec3_load(e->radiance));
    const struct stage_spot *spot;
    switch (e->kind) {
    case EMITTER_POINT:
        return power * 4 * pi;
    case EMITTER_SPOT:
        spot = (const struct stage_spot *)stage_at(s, s->spots) + e->index;
        return power * 2 * pi * spot->outer;
    case EMITTER_DISTANT:
        return power * pi * around(s).radius * around(s).radius;
    case EMITTER_PRIM:
    case EMITTER_SUN:
    case EMITTER_MAP:
        return 0;
    }
    __builtin_unreachable();
}

/* A ray from the light, and what it carries over what it carries on the average. */
static struct ray leave(const struct stage *s, const struct emitter *e, struct square q,
                        float *carries)
{
    const vec3 at = vec3_load(e->at);
    const struct ball ball = around(s);
    *carries = 1;
    if (e->kind == EMITTER_DISTANT) {
        const struct warp_frame f = warp_frame_make(at);
        const vec3 off = warp_to_world(&f, warp_disc(q)) * ball.radius;
        return (struct ray){ball.center + off - 2 * ball.radius * at, at, __builtin_inff(), 0, 0};
    }
    if (e->kind == EMITTER_POINT)
        return (struct ray){at, warp_cap(q, 2), __builtin_inff(), 0, 0};
    const struct stage_spot *spot = (const struct stage_spot *)stage_at(s, s->spots) + e->index;
    const struct warp_frame f = warp_frame_make(vec3_load(spot->direction));
    const vec3 dir = vec3_unit(warp_to_world(&f, warp_cap(q, spot->outer)));
    *carries = light_spot_falloff(spot, dir);
    return (struct ray){at, dir, __builtin_inff(), 0, 0};
}

static bool passes(const struct material *m)
{
    return bsdf_is_delta(m) && (m->kind == MATERIAL_DIELECTRIC || m->kind == MATERIAL_PANE);
}

enum sight { SIGHT_NONE, SIGHT_CLEAR, SIGHT_THROUGH };

static enum sight sight_of(struct study *t, struct ray ray)
{
    const struct stage *s = t->stage;
    const struct material *materials = stage_at(s, s->materials);
    for (int n = 0; n < PANES; n++) {
        struct ray_hit hit;
        t->work.bounce_rays++;
        if (!bvh_hit_closest(s, &ray, &hit))
            return n ? SIGHT_THROUGH : SIGHT_CLEAR;
        const struct surface at = surface_at(s, &ray, &hit);
        const struct material *m = &materials[at.material];
        if (m->kind >= MATERIAL_MIX && m->kind <= MATERIAL_TWO_SIDED) /* one of many */
            return SIGHT_NONE;
        if (!passes(m))
            return SIGHT_NONE;
        const vec3 end = ray.origin + ray.dir;
        ray = surface_to_point(&at, end);
    }
    return SIGHT_NONE;
}

/* What goes from the vertex to the eye, of a path that carries throughput, W. */
static void show(struct study *t, struct study_path *p, const struct study_chain *chain,
                 double missed[])
{
    const struct path_vertex *v = &p->path.vertex;
    struct study_seen seen;
    if (!study_lens_sees(t->stage, &v->at, &seen))
        return;
    const vec3 eye = warp_to_local(&v->frame, seen.to_eye);
    if (!(vec3_dot(seen.to_eye, v->at.ng) * eye[2] > 0) || v->wo[2] == 0)
        return;
    const rgb f = bsdf_eval(v->material, eye, v->wo);
    if (rgb_is_black(f))
        return;
    const enum sight sight = sight_of(t, seen.ray);
    if (sight == SIGHT_NONE)
        return;
    const float across = eye[2] / v->wo[2];
    const double light = (double)rgb_luminance(p->path.throughput * f) *
                         (double)(across < 0 ? -across : across) * seen.per_watt;
    missed[study_class(sight == SIGHT_THROUGH, chain->head, chain->rough + 1)] += light;
}

/* The next ray. It is flux that is followed, not radiance: what refraction puts into radiance, and
 * takes out again, is divided out. */
static bool scatter(struct study_path *p, struct study_chain *chain, struct ray *ray)
{
    p->path.scale = 1;
    if (!study_path_scatter(p, false, false, ray))
        return false;
    p->path.throughput /= p->path.scale;
    study_chain_add(chain, p->path.pdf_w == 0);
    return chain->head; /* any other path from the light is one from the eye, too */
}

static bool goes_on(struct study_path *p, float began)
{
    if (p->bounce < ROULETTE_BEGIN)
        return true;
    const float share = rgb_max(p->path.throughput) / began;
    const float q = share < 0.95f ? share : 0.95f;
    if (!(rng_single(&p->rng, rng_dimension(p->bounce, RNG_ROULETTE)) < q))
        return false;
    p->path.throughput /= q;
    return true;
}

static void follow(struct study *t, struct study_path *p, struct ray ray, double missed[])
{
    const uint32_t bounces = t->stage->settings.max_bounces;
    const uint32_t most = bounces < SCATTERINGS ? bounces : SCATTERINGS;
    const float began = rgb_max(p->path.throughput);
    struct study_chain chain = {0};
    for (bool first = true; chain.count < most; first = false) {
        if (!study_path_go(p, ray, first))
            return;
        if (!bsdf_is_delta(study_path_material(p)) && chain.head)
            show(t, p, &chain, missed);
        if (!goes_on(p, began) || !scatter(p, &chain, &ray))
            return;
    }
}

struct sources {
    const struct emitter *emitters;
    uint32_t count; /* of all emitters */
    double flux;    /* of those without size */
    uint32_t next;  /* emitters below are behind us, and .. */
    double done;    /* .. what they have of the flux */
};

/* Path i of `paths`, i growing: the emitter on whose part of all flux the middle of its own falls.
 */
static const struct emitter *choose(const struct stage *s, struct sources *from, uint32_t i,
                                    uint32_t paths)
{
    const double place = (i + 0.5) / paths * from->flux;
    for (; from->next + 1 < from->count; from->next++) {
        const double flux = (double)flux_of(s, &from->emitters[from->next]);
        if (from->done + flux > place)
            break;
        from->done += flux;
    }
    return &from->emitters[from->next];
}

static void follow_from(struct study *t, const struct emitter *e, float flux, uint32_t i,
                        double missed[])
{
    const struct stage *s = t->stage;
    const struct rng rng = study_rng(s, (struct study_place){0, 0}, i, SALT);
    float carries;
    const struct ray ray = leave(s, e, rng_pair(&rng, RNG_LENS), &carries);
    const rgb radiance = vec3_load(e->radiance);
    struct study_path p;
    study_path_init(&p, s, rng, &t->work);
    if (s->media)
        p.media.bodies = medium_around(s, ray.origin);
    p.path.throughput = radiance * (flux * carries / rgb_luminance(radiance));
    if (!rgb_is_black(p.path.throughput))
        follow(t, &p, ray, missed);
}

static bool trace(struct study *t, struct sources *from, double missed[])
{
    const uint32_t paths = plan_light_paths(t->plan);
    for (uint32_t i = 0; i < paths; i++) {
        if (i % BETWEEN == 0 && study_is_halted(t))
            return false;
        const struct emitter *e = choose(t->stage, from, i, paths);
        if (flux_of(t->stage, e) > 0)
            follow_from(t, e, (float)from->flux, i, missed);
    }
    t->plan->light.light_paths = paths;
    for (int c = 0; paths > 0 && c < PLAN_CLASSES; c++)
        missed[c] /= paths;
    return true;
}

bool study_light(struct study *t)
{
    const struct stage *s = t->stage;
    struct plan_light *to = &t->plan->light;
    struct sources from = {.emitters = stage_at(s, s->emitters),
                           .count = (uint32_t)s->emitters.count};
    for (uint32_t i = 0; i < from.count; i++)
        from.flux += (double)flux_of(s, &from.emitters[i]);
    if (from.flux > 0 && t->plan->features.lobes[PLAN_DELTA] > 0 && !trace(t, &from, to->missed))
        return false;
    double all = 0;
    for (int c = 0; c < PLAN_CLASSES; c++)
        all += to->found[c] + to->missed[c];
    for (int c = 0; all > 0 && c < PLAN_CLASSES; c++) {
        to->found[c] /= all;
        to->missed[c] /= all;
    }
    return true;
}
