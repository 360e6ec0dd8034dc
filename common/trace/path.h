/* path.h - the path integrator: light along a ray, by following it through the scene.
 *
 * J. Kajiya, "The Rendering Equation", SIGGRAPH 1986, with next-event estimation and multiple
 * importance sampling (E. Veach, L. Guibas, "Optimally Combining Sampling Techniques for Monte
 * Carlo Rendering", SIGGRAPH 1995, power heuristic).
 *
 * Here is what one path does at one vertex: it looks at a light, is scattered, arrives. wave.h
 * takes eight paths at a time through it, ray by ray; path8.h has the same for vertices that are
 * plain. SPDX-License-Identifier: MIT */
#ifndef COMMON_TRACE_PATH_H
#define COMMON_TRACE_PATH_H

#include "common/film.h"
#include "common/trace/light.h"
#include "common/trace/ray.h"
#include "common/trace/sobol.h"
#include "common/trace/stage.h"
#include "common/trace/surface.h"
#include "common/trace/texture.h"
#include "common/trace/warp.h"

/* The first bounce after which a path may be ended by chance. */
enum { PATH_ROULETTE_BEGIN = 1 };

struct path_raised { /* path_shade.h */
    bool is;         /* light from below the triangle and above the frame's plane is gathered at: */
    vec3 p;
};

struct path_vertex { /* where a ray has arrived */
    struct surface at;
    struct warp_frame frame;
    const struct material *material;
    vec3 wo;                    /* where the ray came from; local */
    struct texture_point point; /* for the textures of a material that has some */
    struct path_raised raised;
};

struct path_media;

struct path {
    struct path_media *media; /* NULL: the scene has none (path_media.h) */
    struct film_work *work;   /* counts the rays that are traced at a vertex, one path's alone */
    rgb light;                /* found so far */
    rgb throughput;
    float scale; /* what roulette divides out of throughput; from the first scattering on */
    float pdf_w; /* of the last direction; 0: a delta lobe's, which next-event estimation cannot
                  * make */
    struct path_vertex vertex;
};

struct path_draw { /* the random numbers of a scattering */
    struct square direction;
    float lobe, roulette;
    bool first;   /* the path's first scattering */
    bool may_end; /* by chance */
};

/* What a vertex's surface.lit is, as far as anybody asks: the tree of lights. up: wo's z. (What is
 * scattered to wo came from the same side by both normals.) */
float path_lit(const struct stage *, const struct material *, float up);

/* width: of the ray's cone at the hit, in m (cone.h). work: counts on. */
struct path_vertex path_vertex_make(const struct stage *, const struct ray *,
                                    const struct ray_hit *, float width, struct film_work *work);

/* What a ray that leaves the scene meets. pdf_w: of its direction, by the sampling that made it; 0:
 * nothing else could have made it. */
rgb path_beyond(const struct stage *, vec3 dir, float pdf_w);

/* What an emitter that is a primitive without a texture emits from its front. */
static inline rgb path_radiance(const struct stage *s, uint32_t emitter)
{
    return vec3_load(stage_emitter_at(s, emitter)->radiance);
}

/* What the vertex emits to where the ray came from. */
rgb path_emission(const struct stage *, const struct path_vertex *);

/* The weight of what `at` emits to the vertex `from`, found by a direction of density pdf_w; 0: a
 * delta lobe's. */
float path_emission_weight(const struct stage *, const struct surface *from,
                           const struct surface *at, float pdf_w);

/* How many times a technique's density counts in the other's weight. Weights add up to 1 whatever
 * that is, so each strategy is unbiased; where both techniques find a light, one of them has all
 * the weight, exactly 1 (and the other 0, unless its density is 2^36 times as large), and what only
 * one finds it still finds. */
struct path_trust {
    float light, bsdf; /* each 1 over the other */
};

const struct path_trust *path_trust(const struct stage *);

struct path_lamp { /* the random numbers of a look at a light */
    struct sobol_bits bits;
    const struct light_pick *pick; /* what bits.u has picked; NULL: that is still to be done */
};

/* Light that may reach the vertex from one chosen emitter and goes on to wo, MIS-weighted. True:
 * *light comes if *shadow hits nothing. */
bool path_light_directly(const struct stage *, struct path *, const struct path_lamp *,
                         struct ray *shadow, rgb *light);

/* The next ray; false: there is none. */
bool path_scatter(const struct stage *, struct path *, const struct path_draw *, struct ray *);

/* The vertex where the ray has arrived, and what it emits. */
void path_arrive(const struct stage *, struct path *, const struct path_vertex *);

#endif
