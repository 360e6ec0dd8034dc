/* path_media.h - what a path does only in a scene with media (medium.h).
 *
 * Its segments absorb, and surfaces of bodies may not be there, or lie between two bodies. Nothing
 * else of path.h changes.
 * SPDX-License-Identifier: MIT */
#ifndef COMMON_TRACE_PATH_MEDIA_H
#define COMMON_TRACE_PATH_MEDIA_H

#include "common/trace/medium.h"
#include "common/trace/path.h"
#include "common/trace/rng.h"

struct path_media {
    struct stage_bodies bodies; /* around the vertex, on the side of wo */
    struct material seen;       /* the vertex's, as an interface between two bodies */
    uint32_t body;              /* whose surface the vertex is on: the material, or STAGE_NONE */
    bool entering;
};

struct path_media_way { /* how a path has come to where it is */
    const struct ray *ray;
    const struct ray_hit *hit; /* past masks; NULL: there is none */
    float width;               /* of the ray's cone there (cone.h) */
    const struct rng *rng; /* the path's, and after how many scattering events: for masks that */
    uint32_t bounce;       /* lie behind a surface that is not there */
};

/* A path along a camera ray, with light and throughput. False: it ends, and has found what it
 * finds. */
bool path_media_begin(const struct stage *, struct path *, const struct path_media_way *);

/* In place of path_arrive and, without a hit, path_beyond. False: the path ends. */
bool path_media_arrive(const struct stage *, struct path *, const struct path_media_way *);

/* What is left of light along a shadow ray that starts in the direction wi, local. */
rgb path_media_passed(const struct stage *, const struct path *, vec3 wi, const struct ray *shadow);

/* The path goes on in the direction wi, local: to the other side, maybe. */
void path_media_leave(struct path *, vec3 wi);

#endif
