/* surface_detail.h - what some materials and meshes ask of a surface beyond surface.h: uv, the
 * directions in which u and v grow, the shading normal, a colour.
 *
 * Made on demand, and only for shapes that prep has given a record: those with vertex normals, or
 * with a material that needs any of it (enum material_needs).
 *
 * uv, origin bottom left, as the front is seen (the outside of a sphere or cylinder). Axes are the
 * object's, so that uv go where its transform takes the surface; a mirror shows them mirrored.
 *
 *   sphere    u runs once around y and grows to the right, .5 faces z, the seam -z; v goes from 0
 *             at -y evenly with the latitude to 1 at y
 *   cylinder  u as on the sphere, the axis in the place of y, what of z lies across it in that of z
 *             (of y, for an axis within 8 degrees of z); v goes from 0 at `from` to 1 at `to`
 *   disc      the middle of the square it is inscribed in is (.5, .5); v grows along what of y lies
 *             across the normal (of -z, for a normal within 8 degrees of y), u to the right of it
 *   quad      (0, 0), (1, 0), (1, 1), (0, 1) at its corners, linear on its two triangles
 *   mesh      its own, linear on each triangle; without any, (0, 0) everywhere
 *
 * Where uv say no direction (a pole; a triangle whose uv have no area; a mesh without), dp_du and
 * dp_dv are 0, and the frame is warp_frame_make's of the shading normal.
 * SPDX-License-Identifier: MIT */
#ifndef COMMON_TRACE_SURFACE_DETAIL_H
#define COMMON_TRACE_SURFACE_DETAIL_H

#include "common/trace/surface.h"
#include "common/trace/warp.h"

struct surface_detail {
    float u, v;
    vec3 dp_du, dp_dv; /* in the world, m per unit; both 0, or both finite and neither 0 */
    vec3 ns;           /* unit shading normal, on ng's side of the surface */
    rgb color;         /* linear; 1 where the mesh has none */
};

/* Of the shape that was hit. NULL: it has no detail, ns is ng. */
static inline const struct stage_detail *surface_detail_of(const struct stage *s, uint32_t prim,
                                                           uint32_t instance)
{
    if (!s->details.count)
        return NULL;
    const struct stage_shape *shapes = (const struct stage_shape *)stage_at(s, s->shapes);
    const uint32_t shape =
        instance == STAGE_NONE ? stage_shape_of(s, prim) : stage_instance_at(s, instance)->shape;
    const uint32_t detail = shapes[shape].detail;
    return detail == STAGE_NONE ? NULL
                                : (const struct stage_detail *)stage_at(s, s->details) + detail;
}

/* at: what surface_at makes of the hit. A point that was chosen on a primitive (surface_on_...) is
 * a hit with its prim, place and instance and, on a triangle, its u and v. */
struct surface_detail surface_detail_at(const struct stage *, const struct stage_detail *,
                                        const struct ray_hit *, const struct surface *at);

/* The point above a triangle with vertex normals, on the side that `side` says (of ng, or behind it
 * when negative), where the smooth surface would about be: the mean, by the corners' weights, of
 * the points that the corners' tangent planes make of p where they lie above it. False: not above
 * p. */
bool surface_detail_raise(const struct stage *, const struct stage_detail *, const struct ray_hit *,
                          const struct surface *at, float side, vec3 *raised);

/* How far a hit is from the nearest edge of its primitive, or less; a sphere has none. */
float surface_detail_edge(const struct stage *, const struct ray_hit *, const struct surface *at);

/* Right-handed: z is ns, x the direction across it in which u grows. No NaN. */
struct warp_frame surface_detail_frame(vec3 ns, vec3 dp_du);

#endif
