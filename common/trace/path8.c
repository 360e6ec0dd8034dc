/* SPDX-License-Identifier: MIT */
#include "common/trace/path8.h"

#include "common/trace/bsdf.h"
#include "common/trace/light8.h"
#include "common/trace/material.h"
#include "common/trace/path.h"

static inline uint32_t lowest(uint32_t lanes)
{
    return (uint32_t)__builtin_ctz(lanes);
}

struct surface path8_surface(const struct stage *s, const struct path8_vertex *v, uint32_t i)
{
    return (struct surface){.p = vec8_lane(&v->at.p, i),
                            .p_error = vec8_lane(&v->at.p_error, i),
                            .ng = vec8_lane(&v->at.ng, i),
                            .prim = v->at.prim[i],
                            .material = v->material[i],
                            .emitter = v->emitter[i],
                            .lit = path_lit(s, path8_material(s, v, i), v->wo.z[i])};
}

/* --- arriving --- */

/* Of hit i, bit i and those at these places above it. */
enum { FOUND_DIFFUSE = 8, FOUND_FLAT = 16 };

struct found {                    /* what has to be looked up, lane by lane */
    const float *corners[8];      /* of those that are flat: in triangles of the world */
    vec3 p[8], p_error[8], ng[8]; /* of the others */
    vec3 albedo[8], dir[8];
    _Alignas(32) float u[8], v[8];
    _Alignas(32) uint32_t prim[8], emitter[8], material[8];
};

struct tables {
    const struct stage *stage;
    const struct stage_shape *shapes;
    const struct material *materials;
    const struct stage_block *blocks;
};

static inline const struct stage_shape *shape_at(const struct tables *t, const struct ray_hit *hit)
{
    return &t->shapes[hit->instance == STAGE_NONE
                          ? stage_shape_of(t->stage, hit->prim)
                          : stage_instance_at(t->stage, hit->instance)->shape];
}

/* 0: it is not plain. */
static inline uint32_t look_up(const struct tables *t, uint32_t i, const struct ray *ray,
                               const struct ray_hit *hit, struct found *f)
{
    const struct stage_shape *shape = shape_at(t, hit);
    const struct material *m = &t->materials[shape->material];
    if (shape->detail != STAGE_NONE || material_is_wrapped(m)) /* textured ones have a detail */
        return 0;
    const bool diffuse = m->kind == MATERIAL_DIFFUSE, flat = hit->place.kind == STAGE_TRIANGLE &&
                                                             hit->instance == STAGE_NONE &&
                                                             !surface_is_near_edge(hit);
    if (flat) {
        const struct stage_block *block = &t->blocks[hit->place.index / STAGE_LANES];
        f->corners[i] = &block->v[0][0][hit->place.index % STAGE_LANES];
        f->u[i] = hit->u;
        f->v[i] = hit->v;
    } else {
        const struct surface at = surface_point_at(t->stage, ray, hit);
        f->p[i] = at.p;
        f->p_error[i] = at.p_error;
        f->ng[i] = at.ng;
    }
    f->albedo[i] = m->diffuse.albedo;
    f->dir[i] = ray->dir;
    f->prim[i] = hit->prim;
    f->material[i] = shape->material;
    f->emitter[i] = STAGE_NONE;
    if (shape->emitter_begin != STAGE_NONE)
        f->emitter[i] = shape->emitter_begin + hit->prim - shape->prim_begin;
    return 1 | (uint32_t)diffuse << FOUND_DIFFUSE | (uint32_t)flat << FOUND_FLAT;
}

static inline void place_flat(struct found *f, uint32_t flat, struct surface8 *at)
{
    for (uint32_t left = 0xff & ~flat; left; left &= left - 1) /* mean nothing, and are read, too */
        f->corners[lowest(left)] = f->corners[lowest(flat)];
    const struct surface8_corners t = surface8_corners_at(f->corners);
    surface8_place(&t, f32x8_load(f->u), f32x8_load(f->v), at);
    at->ng = surface8_normal(&t);
}

static inline void place_others(const struct found *f, uint32_t flat, struct surface8 *at)
{
    const i32x8 m = i32x8_of_bits(flat);
    at->p = vec8_choose(m, at->p, vec8_gather(f->p));
    at->p_error = vec8_choose(m, at->p_error, vec8_gather(f->p_error));
    at->ng = vec8_choose(m, at->ng, vec8_gather(f->ng));
}

uint32_t path8_arrive(const struct stage *s, uint32_t which, const struct ray rays[],
                      const struct ray_hit hits[], struct path8_vertex *v)
{
    const struct tables tables = {s, stage_at(s, s->shapes), stage_at(s, s->materials),
                                  stage_at(s, s->blocks)};
    struct found f;
    uint32_t found = 0;
    for (; which; which &= which - 1) {
        const uint32_t i = lowest(which);
        found |= look_up(&tables, i, &rays[i], &hits[i], &f) << i;
    }
    const uint32_t plain = found & 0xff, flat = found >> FOUND_FLAT;
    v->diffuse = found >> FOUND_DIFFUSE & 0xff;
    v->shining = 0;
    if (!plain)
        return 0;
    if (flat)
        place_flat(&f, flat, &v->at);
    if (plain & ~flat)
        place_others(&f, flat, &v->at);
    v->at.prim = u32x8_load(f.prim);
    v->emitter = u32x8_load(f.emitter);
    v->material = u32x8_load(f.material);
    v->frame = warp8_frame_make(v->at.ng);
    v->albedo = vec8_gather(f.albedo);
    v->wo = warp8_to_local(&v->frame, vec8_negative(vec8_gather(f.dir)));
    v->shining = plain & i32x8_mask((i32x8)(v->emitter != STAGE_NONE) & (v->wo.z > 0));
    return plain;
}

/* --- lights --- */

/* z of a local direction as seen from the side that wo is on. */
static inline f32x8 from_wo(f32x8 wo, f32x8 wi)
{
    return f32x8_choose(wo < 0, -wi, wi);
}

static inline f32x8 mis_weight(f32x8 a, f32x8 b)
{
    const f32x8 r = b / a;
    return 1 / (1 + r * r);
}

static uint32_t delta_lanes(const struct stage *s, const struct path8_vertex *v, uint32_t lanes)
{
    uint32_t delta = 0;
    for (lanes &= ~v->diffuse; lanes; lanes &= lanes - 1)
        delta |= (uint32_t)bsdf_is_delta(path8_material(s, v, lowest(lanes))) << lowest(lanes);
    return delta;
}

/* As light8_sample, one by one. */
static uint32_t sample_each(const struct stage *s, const struct path8_vertex *v,
                            const struct path8_lamps *l, struct light8_sample *out,
                            struct ray shadows[8])
{
    vec3 p[8], p_error[8], ng[8], wi[8] = {{0}}, value[8] = {{0}};
    _Alignas(32) float pdf_w[8] = {0};
    uint32_t lit = 0;
    vec8_scatter(v->at.p, p);
    vec8_scatter(v->at.p_error, p_error);
    vec8_scatter(v->at.ng, ng);
    for (uint32_t left = l->lanes; left; left &= left - 1) {
        const uint32_t i = lowest(left);
        struct surface from = {p[i], p_error[i], ng[i], v->at.prim[i], STAGE_NONE, STAGE_NONE, 0};
        if (l->picks) /* the tree is asked again for the other half of a quad that is near */
            from.lit = path_lit(s, path8_material(s, v, i), v->wo.z[i]);
        struct light_sample sample;
        if (!(l->picks ? light_sample_picked(s, &from, l->picks[i], l->bits->v[i], &sample)
                       : light_sample(s, &from, (struct sobol_bits){l->bits->u[i], l->bits->v[i]},
                                      &sample)))
            continue;
        lit |= 1u << i;
        wi[i] = sample.wi;
        value[i] = sample.value;
        pdf_w[i] = sample.pdf_w;
        shadows[i] = sample.shadow;
    }
    out->wi = vec8_gather(wi);
    out->value = vec8_gather(value);
    out->pdf_w = f32x8_load(pdf_w);
    return lit;
}

struct passed { /* of light from wi to wo */
    struct vec8 f;
    f32x8 pdf_w;
    i32x8 some;
};

static inline void pass_diffuse(const struct path8_vertex *v, f32x8 wi, struct passed *to)
{
    const f32x8 none = {0};
    to->pdf_w = warp8_cosine_pdf_w(from_wo(v->wo.z, wi));
    to->f = vec8_scale(v->albedo, to->pdf_w);
    to->some = v->wo.z * wi > none;
}

static void pass_others(const struct stage *s, const struct path8_vertex *v, uint32_t others,
                        struct vec8 wi, struct passed *to)
{
    const i32x8 m = i32x8_of_bits(others);
    const f32x8 none = {0};
    vec3 f[8] = {{0}};
    _Alignas(32) float pdf_w[8] = {0};
    for (; others; others &= others - 1) {
        const uint32_t i = lowest(others);
        const struct material *material = path8_material(s, v, i);
        const vec3 o = vec8_lane(&v->wo, i), w = vec8_lane(&wi, i);
        f[i] = bsdf_eval(material, o, w);
        if (!rgb_is_black(f[i]))
            pdf_w[i] = bsdf_pdf_w(material, o, w);
    }
    to->f = vec8_choose(m, vec8_gather(f), to->f);
    to->pdf_w = f32x8_choose(m, f32x8_load(pdf_w), to->pdf_w);
    to->some |= m & (wi.z * wi.z > none);
}

uint32_t path8_light_directly(const struct stage *s, const struct path8 *p,
                              const struct path8_lamps *lamps, struct ray shadows[8],
                              struct vec8 *light)
{
    const struct path8_vertex *v = p->vertex;
    const struct path8_lamps l = {lamps->lanes & ~delta_lanes(s, v, lamps->lanes), lamps->bits,
                                  lamps->picks};
    const f32x8 none = {0};
    struct light8_sample sample;
    struct passed to;
    if (!l.lanes)
        return 0;
    const uint32_t lit = light8_can(s) ? light8_sample(s, &v->at, l.lanes, l.bits, &sample, shadows)
                                       : sample_each(s, v, &l, &sample, shadows);
    pass_diffuse(v, vec8_dot(sample.wi, v->frame.z), &to);
    if (lit & ~v->diffuse)
        pass_others(s, v, lit & ~v->diffuse, warp8_to_local(&v->frame, sample.wi), &to);
    const f32x8 weight =
        f32x8_choose(sample.pdf_w != none, mis_weight(sample.pdf_w, to.pdf_w * path_trust(s)->bsdf),
                     f32x8_splat(1));
    *light = vec8_mul(p->throughput, vec8_scale(vec8_mul(to.f, sample.value), weight));
    return lit & i32x8_mask(to.some & ~vec8_is_zero(*light));
}

/* --- scattering --- */

struct next { /* as struct bsdf_sample */
    struct vec8 wi, weight;
    f32x8 pdf_w, scale;
    i32x8 some;
};

static inline void scatter_diffuse(const struct path8_vertex *v, const struct path8_draw *draw,
                                   struct next *n)
{
    const f32x8 none = {0};
    n->wi = warp8_cosine(draw->direction);
    n->pdf_w = warp8_cosine_pdf_w(n->wi.z);
    n->some = (v->wo.z != none) & (n->pdf_w > none);
    n->wi.z = from_wo(v->wo.z, n->wi.z);
    n->weight = v->albedo;
    n->scale = f32x8_splat(1);
}

static void scatter_others(const struct stage *s, const struct path8_vertex *v, uint32_t others,
                           const struct path8_draw *draw, struct next *n)
{
    const i32x8 m = i32x8_of_bits(others);
    vec3 wi[8] = {{0}}, weight[8] = {{0}};
    _Alignas(32) float pdf_w[8] = {0}, scale[8] = {0};
    uint32_t some = 0;
    for (; others; others &= others - 1) {
        const uint32_t i = lowest(others);
        const struct square direction = {draw->direction.u[i], draw->direction.v[i]};
        struct bsdf_sample one;
        if (!bsdf_sample(path8_material(s, v, i), vec8_lane(&v->wo, i), draw->lobe[i], direction,
                         &one))
            continue;
        some |= 1u << i;
        wi[i] = one.wi;
        weight[i] = one.weight;
        pdf_w[i] = one.pdf_w;
        scale[i] = one.scale;
    }
    n->wi = vec8_choose(m, vec8_gather(wi), n->wi);
    n->weight = vec8_choose(m, vec8_gather(weight), n->weight);
    n->pdf_w = f32x8_choose(m, f32x8_load(pdf_w), n->pdf_w);
    n->scale = f32x8_choose(m, f32x8_load(scale), n->scale);
    n->some = (n->some & ~m) | i32x8_of_bits(some);
}

uint32_t path8_scatter(const struct stage *s, struct path8 *p, uint32_t lanes,
                       const struct path8_draw *draw, struct ray rays[8])
{
    const struct path8_vertex *v = p->vertex;
    const f32x8 none = {0}, one = f32x8_splat(1);
    struct next n;
    scatter_diffuse(v, draw, &n);
    if (lanes & ~v->diffuse)
        scatter_others(s, v, lanes & ~v->diffuse, draw, &n);
    p->pdf_w = n.pdf_w;
    p->throughput = vec8_mul(p->throughput, n.weight);
    i32x8 goes = n.some & ~vec8_is_zero(p->throughput);
    const f32x8 most = vec8_most(p->throughput);
    p->scale = f32x8_choose(draw->first, most, p->scale * n.scale);
    const struct vec8 dir = warp8_to_world(&v->frame, n.wi);
    goes &= vec8_dot(dir, v->at.ng) * n.wi.z > none;
    const f32x8 share = 2 * (most / p->scale);
    const f32x8 q = f32x8_choose(draw->may_end & (share < one), share, one);
    goes &= (q >= one) | (draw->roulette < q);
    p->throughput = vec8_over(p->throughput, q);
    surface8_leave(&v->at, dir, rays);
    return lanes & i32x8_mask(goes);
}
