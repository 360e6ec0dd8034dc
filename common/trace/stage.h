/* stage.h - the render-ready scene: what rays are traced against.
 *
 * One relocatable block: a header, then arrays found by their byte offset from the
 * header, so the same bytes can be written to a file, mapped anywhere read-only and
 * shared by processes. prep.c makes it, everything else sees `const struct stage *`.
 *
 * Geometry is in world space. Primitives are numbered once, in document order (shape by shape, a
 * mesh's triangles in file order, a quad as two triangles): `prim`. That number breaks ties
 * between equally near hits, so the hit is a pure function of the ray. The BVH's leaves hold
 * primitives of one kind each.
 * SPDX-License-Identifier: MIT */
#ifndef COMMON_TRACE_STAGE_H
#define COMMON_TRACE_STAGE_H

#include "common/scene.h"

enum { STAGE_VERSION = 1 };

struct stage_span { /* an array inside the block */
    uint64_t offset; /* bytes from the start of the stage, 64-aligned */
    uint64_t count;  /* elements */
};

struct stage_triangle {
    float v[3][3];
};

struct stage_sphere {
    float center[3], radius;
};

struct stage_disc {
    float center[3], radius;
    float normal[3]; /* unit */
    float pad;
};

enum stage_prim_kind { STAGE_TRIANGLE, STAGE_SPHERE, STAGE_DISC };

struct stage_prim { /* indexed by prim */
    uint32_t shape; /* index into scene.shapes, for reports */
    uint32_t material;
    uint32_t kind : 2;   /* enum stage_prim_kind */
    uint32_t index : 30; /* into triangles, spheres or discs */
    uint32_t emitter;    /* index into emitters, or STAGE_NONE */
};

#define STAGE_NONE UINT32_MAX

/* Something next-event estimation can aim at: an emissive primitive, a point or a distant light. */
enum emitter_kind { EMITTER_PRIM, EMITTER_POINT, EMITTER_DISTANT };

struct emitter {
    enum emitter_kind kind;
    uint32_t prim;     /* EMITTER_PRIM */
    float radiance[3]; /* EMITTER_PRIM: radiance; POINT: intensity; DISTANT: irradiance */
    float at[3];       /* POINT: position; DISTANT: direction of travel, unit */
    float area;        /* EMITTER_PRIM: m^2 */
    float pick;        /* probability of being chosen; they sum to 1 */
};

struct stage_camera {
    float origin[3];
    float corner[3]; /* direction_raw through the top left corner of the frame */
    float dx[3], dy[3]; /* per pixel to the right, down */
};

struct stage {
    char magic[8];        /* "SMSTAGE" */
    uint32_t version;     /* STAGE_VERSION */
    uint32_t struct_bytes; /* sizeof(struct stage): another build's layout is refused */
    uint64_t bytes;       /* of the whole block */

    struct stage_camera camera;
    struct scene_film film;
    struct scene_settings settings;
    rgb sky;                   /* radiance of rays that leave the scene */
    float bounds[2][3];        /* of all primitives */
    uint32_t dropped_degenerate; /* zero-area triangles, not in any array */
    uint32_t dropped_nonfinite;  /* triangles with a vertex that is not finite */
    uint32_t bvh_depth;

    /* Only spans from here to the end: stage_check knows them by their place. */
    struct stage_span prims;     /* struct stage_prim */
    struct stage_span triangles; /* struct stage_triangle */
    struct stage_span spheres;   /* struct stage_sphere */
    struct stage_span discs;     /* struct stage_disc */
    struct stage_span materials; /* struct material, names NULL */
    struct stage_span emitters;  /* struct emitter */
    struct stage_span pick_cdf;  /* float: cumulative pick, one more than emitters */
    struct stage_span nodes;     /* struct bvh_node (bvh.h) */
    struct stage_span leaf_prims; /* uint32_t prim numbers in leaf order */
};

static inline const void *stage_at(const struct stage *s, struct stage_span span)
{
    return (const unsigned char *)s + span.offset;
}

/* Whether the bytes, 64-aligned and from anywhere, are a block of this build with every array inside
 * it. What stands in the arrays is not looked at: who keeps a block says how it is held
 * against damage. */
bool stage_check(const void *block, size_t bytes, struct err *) MUST_CHECK;

#endif
