/* relief.h - shading normals from textures: normal maps, and bumps.
 *
 * A normal map holds directions in the frame of the surface: 0 to 1 is -1 to 1, x along growing u,
 * y along growing v ("OpenGL"), z away from the surface. A bump is a height above the surface; its
 * normals are those of the raised surface, but the surface stays where it is.
 *
 * Where uv say no direction, the surface is as it was. What light such normals may carry is said in
 * path_shade.h. SPDX-License-Identifier: MIT */
#ifndef COMMON_TRACE_RELIEF_H
#define COMMON_TRACE_RELIEF_H

#include "common/trace/surface_detail.h"
#include "common/trace/texture.h"

/* d->ns as the relief of the material, which has one, makes it: unit, and above the surface. */
vec3 relief_normal(const struct stage *, const struct material *, const struct texture_point *,
                   const struct surface_detail *d, vec3 ng);

#endif
