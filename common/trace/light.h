/* light.h - next-event estimation: choosing a direction to a light, and the density of that choice.
 *
 * A point of the square picks one emitter: its u falls into a part of the stage's pick_cdf, and
 * where in that part is a u again. Of many lights that have a place, which all share one part, a
 * tree picks one by what it may mean to the point (light_tree.h). So points that are spread evenly
 * over the square are spread so over neighbours in the table, such as the triangles of a quad. Then
 * a point on the emitter: triangles uniformly by area, or where they are near by solid angle, the
 * halves of a quad together (light_solid.h); discs uniformly by area, spheres uniformly by the
 * solid angle they fill, cylinders nearly so (light_cylinder.h), the sun uniformly in its cone,
 * environment maps pixel by pixel (light_map.h), point,
 * spot and distant lights as they are. Emission is one-sided: only the front of a surface shines.
 *
 * The sky is no emitter here. It has one radiance everywhere, so sampling it would be sampling the
 * sphere blindly: the BSDF's own sampling is never worse, and finds it with weight 1.
 * SPDX-License-Identifier: MIT */
#ifndef COMMON_TRACE_LIGHT_H
#define COMMON_TRACE_LIGHT_H

#include "common/trace/sobol.h"
#include "common/trace/surface.h"

struct light_sample {
    vec3 wi;     /* unit, from the surface to the light */
    rgb value;   /* radiance that arrives along wi, divided by the density of the choice; for a
                  * delta light irradiance on a surface across wi, divided by the pick alone */
    float pdf_w; /* of the choice, the pick included; 0: a delta light, which nothing else finds */
    struct ray shadow; /* hits nothing: the light is seen */
};

/* False: nothing arrives from what was chosen. */
bool light_sample(const struct stage *, const struct surface *from, struct sobol_bits,
                  struct light_sample *);

/* The same in two steps, for up to 8 points whose walks through the tree go side by side. bits:
 * their sobol_bits.u. */
struct light_pick {
    uint32_t emitter; /* STAGE_NONE: nothing arrives */
    float probability;
    uint32_t rest; /* where u lies in the emitter's part: sobol_bits.u again */
};

void light_pick(const struct stage *, const struct surface *const from[], const uint32_t bits[],
                uint32_t count, struct light_pick[]);
bool light_sample_picked(const struct stage *, const struct surface *from, struct light_pick,
                         uint32_t v, struct light_sample *);

/* The density with which light_sample at `from` would have chosen the front side of `at`, a point
 * of an emissive primitive seen from there. */
float light_pdf_w(const struct stage *, const struct surface *from, const struct surface *at);

/* What a ray along dir (unit) that leaves the scene meets of an emitter from stage.beyond_begin on;
 * and, if that is not black, the density with which light_sample would have chosen dir for that
 * emitter's sake. */
rgb light_beyond(const struct stage *, uint32_t emitter, vec3 dir, float *pdf_w);

#endif
