/* path8.h - paths in step, in the lanes of vectors: what path.c does at one vertex, at eight at
 * once, where the vertices are plain: on a shape that is shaded with its geometric normal, of a
 * material that is not made of others and has no textures, in a scene without media. That is most
 * of them in most scenes.
 *
 * What is done in vectors is what most vertices have in common: the frame, weights, roulette, rays
 * that leave. Points are computed in vectors on triangles of the world; scattering is, where the
 * material is diffuse; lights are sampled, where there are few (light8.h). For the other shapes,
 * materials and lights the functions for one are called, lane by lane, so that a new one needs no
 * vector form.
 *
 * path.c is the definition. Here is the same arithmetic, operation by operation, so that a path's
 * bits do not depend on where it lives (tests/test_wave.c); whatever is not plain is path.c's.
 * SPDX-License-Identifier: MIT */
#ifndef COMMON_TRACE_PATH8_H
#define COMMON_TRACE_PATH8_H

#include "common/trace/light.h"
#include "common/trace/sobol8.h"
#include "common/trace/surface8.h"
#include "common/trace/warp8.h"

struct path8_vertex { /* as struct path_vertex */
    struct surface8 at;
    struct warp8_frame frame;
    struct vec8 wo, albedo; /* albedo: where the material is diffuse */
    u32x8 emitter, material;
    uint32_t diffuse; /* bit i: the material is */
    uint32_t shining; /* bit i: the vertex emits to where the ray came from */
};

struct path8 { /* as struct path */
    struct vec8 light, throughput;
    f32x8 scale, pdf_w;
    const struct path8_vertex *vertex;
};

struct path8_draw {
    struct sobol8_square direction;
    f32x8 lobe, roulette;
    i32x8 first;   /* the path's first scattering */
    i32x8 may_end; /* by chance */
};

/* Bit i is that of lane k[i], where `lanes` is -1. */
static inline uint32_t path8_bits_take(i32x8 lanes, uint32_t bits, u32x8 k)
{
    const f32x8 moved = f32x8_permute((f32x8)i32x8_of_bits(bits), k);
    return i32x8_mask((i32x8)moved & lanes);
}

/* Where `lanes` is -1, lane i becomes what lane k[i] of `from` is. */
static inline void path8_vertex_take(struct path8_vertex *to, i32x8 lanes,
                                     const struct path8_vertex *from, u32x8 k)
{
    to->at.p = vec8_take(lanes, from->at.p, k, to->at.p);
    to->at.p_error = vec8_take(lanes, from->at.p_error, k, to->at.p_error);
    to->at.ng = vec8_take(lanes, from->at.ng, k, to->at.ng);
    to->at.prim = u32x8_take(lanes, from->at.prim, k, to->at.prim);
    to->frame.x = vec8_take(lanes, from->frame.x, k, to->frame.x);
    to->frame.y = vec8_take(lanes, from->frame.y, k, to->frame.y);
    to->frame.z = to->at.ng;
    to->wo = vec8_take(lanes, from->wo, k, to->wo);
    to->albedo = vec8_take(lanes, from->albedo, k, to->albedo);
    to->emitter = u32x8_take(lanes, from->emitter, k, to->emitter);
    to->material = u32x8_take(lanes, from->material, k, to->material);
    to->diffuse = (to->diffuse & ~i32x8_mask(lanes)) | path8_bits_take(lanes, from->diffuse, k);
}

static inline const struct material *path8_material(const struct stage *s,
                                                    const struct path8_vertex *v, uint32_t i)
{
    return (const struct material *)stage_at(s, s->materials) + v->material[i];
}

/* One lane alone. */
struct surface path8_surface(const struct stage *, const struct path8_vertex *, uint32_t i);

/* Bit i: hits[i], among `which`, is plain and lane i holds the vertex. */
uint32_t path8_arrive(const struct stage *, uint32_t which, const struct ray rays[],
                      const struct ray_hit hits[], struct path8_vertex *);

struct path8_lamps { /* a look at lights */
    uint32_t lanes;  /* of these */
    const struct sobol8_bits *bits;
    const struct light_pick *picks; /* by lane: what bits.u has picked; NULL: still to be done */
};

/* Light that may reach the vertices. Bit i: *light adds to lane i what comes if shadows[i] hits
 * nothing. May write all of shadows. */
uint32_t path8_light_directly(const struct stage *, const struct path8 *,
                              const struct path8_lamps *, struct ray shadows[8],
                              struct vec8 *light);

/* Bit i, among `lanes`: lane i goes on along rays[i]. Writes all of rays. */
uint32_t path8_scatter(const struct stage *, struct path8 *, uint32_t lanes,
                       const struct path8_draw *, struct ray rays[8]);

#endif
