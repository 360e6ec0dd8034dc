/* SPDX-License-Identifier: MIT */
#include "common/trace/path8.h"

#include "common/trace/light8.h"

/* --- arriving --- */

struct found { /* what has to be looked up, lane by lane */
    const float *corners[8];
    vec3 albedo[8], dir[8];
    _Alignas(32) float u[8], v[8];
    _Alignas(32) uint32_t prim[8], emitter[8], material[8];
};

struct tables {
    const struct stage_shape *shapes;
    const struct material *materials;
    const struct stage_block *blocks;
};

/* False: it is not plain. */
static inline bool look_up(const struct stage *s, const struct tables *t, uint32_t i,
                           const struct ray_hit *hit, struct found *f)
{
    if (hit->place.kind != STAGE_TRIANGLE || hit->instance != STAGE_NONE ||
        surface_is_near_edge(hit))
        return false;
    const struct stage_shape *shape = &t->shapes[stage_shape_of(s, hit->prim)];
    const struct material *m = &t->materials[shape->material];
    if (m->kind != MATERIAL_DIFFUSE ||
        shape->detail != STAGE_NONE) /* textured ones have a detail */
        return false;
    const struct stage_block *block = &t->blocks[hit->place.index / STAGE_LANES];
    f->corners[i] = &block->v[0][0][hit->place.index % STAGE_LANES];
    f->albedo[i] = m->diffuse.albedo;
    f->u[i] = hit->u;
    f->v[i] = hit->v;
    f->prim[i] = hit->prim;
    f->material[i] = shape->material;
    f->emitter[i] = STAGE_NONE;
    if (shape->emitter_begin != STAGE_NONE)
        f->emitter[i] = shape->emitter_begin + hit->prim - shape->prim_begin;
    return true;
}

uint32_t path8_arrive(const struct stage *s, uint32_t which, const struct ray rays[],
                      const struct ray_hit hits[], struct path8_vertex *v)
{
    const struct tables tables = {stage_at(s, s->shapes), stage_at(s, s->materials),
                                  stage_at(s, s->blocks)};
    struct found f;
    uint32_t plain = 0;
    for (uint32_t lanes = which; lanes; lanes &= lanes - 1) {
        const uint32_t i = (uint32_t)__builtin_ctz(lanes);
        if (!look_up(s, &tables, i, &hits[i], &f))
            continue;
        f.dir[i] = rays[i].dir;
        plain |= 1u << i;
    }
    v->shining = 0;
    if (!plain)
        return 0;
    for (uint32_t i = 0; i < 8; i++) /* lanes that mean nothing are read, too */
        if (!(plain >> i & 1))
            f.corners[i] = f.corners[__builtin_ctz(plain)];
    const struct surface8_corners t = surface8_corners_at(f.corners);
    surface8_place(&t, f32x8_load(f.u), f32x8_load(f.v), &v->at);
    v->at.ng = surface8_normal(&t);
    v->at.prim = u32x8_load(f.prim);
    v->emitter = u32x8_load(f.emitter);
    v->material = u32x8_load(f.material);
    v->frame = warp8_frame_make(v->at.ng);
    v->albedo = vec8_gather(f.albedo);
    v->wo = warp8_to_local(&v->frame, vec8_negative(vec8_gather(f.dir)));
    v->shining = plain & i32x8_mask((i32x8)(v->emitter != STAGE_NONE) & (v->wo.z > 0));
    return plain;
}

/* --- scattering: the diffuse material, as bsdf.c has it --- */

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

uint32_t path8_light_directly(const struct stage *s, const struct path8 *p,
                              const struct sobol8_bits *place, struct ray shadows[8],
                              struct vec8 *light)
{
    const struct path8_vertex *v = &p->vertex;
    const f32x8 none = {0};
    struct light8_sample sample;
    const uint32_t lit = light8_sample(s, &v->at, place, &sample, shadows);
    const f32x8 wi = vec8_dot(sample.wi, v->frame.z);
    const f32x8 pdf_w = warp8_cosine_pdf_w(from_wo(v->wo.z, wi));
    const struct vec8 f = vec8_scale(v->albedo, pdf_w);
    const i32x8 scatters = (v->wo.z * wi > none) & ~vec8_is_zero(f);
    const f32x8 weight =
        f32x8_choose(sample.pdf_w != none, mis_weight(sample.pdf_w, pdf_w), f32x8_splat(1));
    *light = vec8_mul(p->throughput, vec8_scale(vec8_mul(f, sample.value), weight));
    return lit & i32x8_mask(scatters);
}

uint32_t path8_scatter(struct path8 *p, const struct path8_draw *draw, struct ray rays[8])
{
    const struct path8_vertex *v = &p->vertex;
    const f32x8 none = {0}, one = f32x8_splat(1);
    struct vec8 wi = warp8_cosine(draw->direction);
    p->pdf_w = warp8_cosine_pdf_w(wi.z);
    i32x8 goes = (v->wo.z != none) & (p->pdf_w > none);
    wi.z = from_wo(v->wo.z, wi.z);
    p->throughput = vec8_mul(p->throughput, v->albedo);
    goes &= ~vec8_is_zero(p->throughput);
    const f32x8 most = vec8_most(p->throughput);
    p->scale = f32x8_choose(draw->first, most, p->scale);
    const struct vec8 dir = warp8_to_world(&v->frame, wi);
    goes &= vec8_dot(dir, v->at.ng) * wi.z > none;
    const f32x8 share = 2 * (most / p->scale);
    const f32x8 q = f32x8_choose(draw->may_end & (share < one), share, one);
    goes &= (q >= one) | (draw->roulette < q);
    p->throughput = vec8_over(p->throughput, q);
    surface8_leave(&v->at, dir, rays);
    return i32x8_mask(goes);
}
