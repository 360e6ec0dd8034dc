/* path_shade.h - the vertex of a path on a shape with a detail: its frame, and which directions
 * carry light there.
 *
 * The frame's z is the shading normal, its x the tangent where the material asks for it. Light is
 * held to both normals, so that none passes a wall: a reflected direction is on the viewer's side
 * of both, a transmitted one on the other side of both, and all others carry nothing. (bsdf.h
 * judges by z, and scatter and light_directly in path.c by whether ng agrees.)
 *
 * One exception lights the terminator of meshes with vertex normals. Near it, triangles are already
 * turned away from a light that the smooth surface still sees. There such light is gathered at a
 * point raised to about where the smooth surface is (J. Hanika, "Hacking the Shadow Terminator",
 * Ray Tracing Gems II, chapter 4, 2021), if nothing lies between the triangle and that point: the
 * light has then come all the way through free space. The triangle itself is met like any other.
 * SPDX-License-Identifier: MIT */
#ifndef COMMON_TRACE_PATH_SHADE_H
#define COMMON_TRACE_PATH_SHADE_H

#include "common/trace/path.h"

/* work, here and below: counts on. v: the plain vertex of the hit (its frame of ng, any tangent),
 * nothing raised; its point is set where the material has textures. Where the shape has no detail, it stays as it is. Afterwards wo is on the same
 * side of z as of ng. */
void path_shade(const struct stage *, const struct ray *, const struct ray_hit *,
                struct path_vertex *v, struct film_work *work);

/* Whether light from wi, local, along dir, the same in the world, may be gathered at the raised
 * point: only if it may not at v->at. */
static inline bool path_shade_is_raised(const struct path_vertex *v, vec3 dir, vec3 wi)
{
    return v->raised.is && wi[2] * v->wo[2] > 0 && vec3_dot(dir, v->at.ng) * wi[2] < 0;
}

/* Whether free space leads there from v->at. */
bool path_shade_is_clear(const struct stage *, const struct path_vertex *v, struct film_work *work);

/* v->at as it is there: in the air, on no triangle. */
struct surface path_shade_raised(const struct path_vertex *v);

/* For a direction on different sides of the two normals: moves v->at there if the path may go on
 * from there. False: it ends. */
bool path_shade_move(const struct stage *, struct path_vertex *v, vec3 dir, vec3 wi,
                     struct film_work *work);

#endif
