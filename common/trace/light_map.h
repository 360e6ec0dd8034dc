/* light_map.h - an environment map: an image of the whole sphere, by longitude and latitude.
 *
 * As a panoramic camera (camera.h) sees it: in the map's own frame -z is in the middle, +x right of
 * it, +y at the top. A pixel is a piece of the sphere, between two meridians and two circles of
 * latitude, that shines evenly: there is no interpolation, so what is sampled is exactly what is
 * looked up, and a pixel of radiance L and solid angle W makes an irradiance of L W cos.
 *
 * Two tables choose a row, then a pixel in it, in proportion to what it has above the mean
 * (prep_map.c), and where in the pixel is uniform in solid angle. The pixels with no part in the
 * tables are left to the BSDF's sampling.
 * SPDX-License-Identifier: MIT */
#ifndef COMMON_TRACE_LIGHT_MAP_H
#define COMMON_TRACE_LIGHT_MAP_H

#include "common/trace/sobol.h"
#include "common/trace/stage.h"

struct light_map_sample {
    vec3 dir; /* unit; in the world */
    rgb pixel;
    float pdf_w;
};

/* q.u chooses along a row, q.v the row. */
struct light_map_sample light_map_sample(const struct stage *, const struct stage_map *,
                                         struct sobol_bits q);

/* The pixel that a unit direction meets, and the density with which it is sampled. */
rgb light_map_pixel(const struct stage *, const struct stage_map *, vec3 dir, float *pdf_w);

#endif
