/* path8.h - paths in step, in the lanes of vectors: what path.c does at one vertex, at eight at
 * once, where the vertices are plain: on a triangle that is no instance's, of a diffuse material.
 * That is most of them in most scenes.
 *
 * path.c is the definition. Here is the same arithmetic, operation by operation, so that a path's
 * bits do not depend on where it lives (tests/test_path8.c); whatever is not plain is path.c's,
 * lane by lane. SPDX-License-Identifier: MIT */
#ifndef COMMON_TRACE_PATH8_H
#define COMMON_TRACE_PATH8_H

#include "common/trace/sobol8.h"
#include "common/trace/surface8.h"
#include "common/trace/warp8.h"

struct path8_vertex { /* as struct path_vertex */
    struct surface8 at;
    struct warp8_frame frame;
    struct vec8 wo, albedo;
    uint32_t emitter[8];
    uint32_t material[8];
    uint32_t shining; /* bit i: the vertex emits to where the ray came from */
};

struct path8 { /* as struct path */
    struct vec8 light, throughput;
    f32x8 scale, pdf_w;
    struct path8_vertex vertex;
};

struct path8_draw {
    struct sobol8_square direction;
    const f32x8 *roulette; /* NULL: no path is ended by chance */
    bool first;            /* the first scattering */
};

/* Bit i: hits[i], among `which`, is plain and lane i holds the vertex. */
uint32_t path8_arrive(const struct stage *, uint32_t which, const struct ray rays[],
                      const struct ray_hit hits[], struct path8_vertex *);

/* Light that may reach the vertices. Bit i: *light adds to lane i what comes if shadows[i] hits
 * nothing. For a stage that light8_can; writes all of shadows. */
uint32_t path8_light_directly(const struct stage *, const struct path8 *,
                              const struct sobol8_bits *, struct ray shadows[8],
                              struct vec8 *light);

/* Bit i: lane i goes on along rays[i]. Writes all of rays. */
uint32_t path8_scatter(struct path8 *, const struct path8_draw *, struct ray rays[8]);

#endif
