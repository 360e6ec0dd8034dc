/* stage.h - the render-ready scene: what rays are traced against.
 *
 * One relocatable block: a header, then arrays found by their byte offset from the
 * header, so the same bytes can be written to a file, mapped anywhere read-only and
 * shared by processes. prep.c makes it, everything else sees `const struct stage *`.
 *
 * Primitives are numbered once, in document order (shape by shape, a mesh's triangles in file
 * order, a quad as two triangles): `prim`. That number breaks ties between equally near hits, so
 * the hit is a pure function of the ray. Their vertices are in world space, in leaves of the
 * hierarchy: `struct stage_place` says where.
 *
 * A mesh that many shapes use may be stored once, in object space, as a tree of its own (prep.h
 * says when). A hit on it is still tested in world space, with the very vertices that a copy would
 * have had. SPDX-License-Identifier: MIT */
#ifndef COMMON_TRACE_STAGE_H
#define COMMON_TRACE_STAGE_H

#include "common/scene.h"

#define STAGE_NONE UINT32_MAX

#define STAGE_MAGIC "SMSTAGE"

enum { STAGE_VERSION = 7, STAGE_ALIGN = 64, STAGE_LANES = 8 };

struct stage_span {  /* an array inside the block */
    uint64_t offset; /* bytes from the start of the stage, 64-aligned */
    uint64_t count;  /* elements */
};

enum stage_kind { STAGE_TRIANGLE, STAGE_SPHERE, STAGE_DISC, STAGE_CYLINDER };

/* Where a primitive is stored. */
struct stage_place {
    uint32_t kind : 3;   /* enum stage_kind */
    uint32_t index : 29; /* into the array of its kind; a triangle's: 8 * block + lane */
};

struct stage_id { /* a primitive: its number, and the way to it */
    uint32_t prim;
    struct stage_place place;
    uint32_t instance; /* or STAGE_NONE: it is the world's own */
};

/* Eight triangles of one leaf, lane by lane: 320 bytes. Lanes not used are NaN, which no ray hits.
 */
struct stage_block {
    float v[3][3][STAGE_LANES]; /* [vertex][axis][lane] */
    uint32_t
        prim[STAGE_LANES]; /* a shared mesh's: number within the mesh. STAGE_NONE: no triangle */
};

struct stage_triangle {
    float v[3][3]; /* [vertex][axis] */
};

struct stage_sphere {
    float center[3], radius;
    uint32_t prim, pad[3];
};

struct stage_disc {
    float center[3], radius;
    float normal[3]; /* unit */
    uint32_t prim;
};

struct stage_cylinder {
    float from[3], radius;
    float axis[3]; /* from one end to the other */
    uint32_t prim;
};

struct stage_shape {     /* of the document, in its order */
    uint32_t prim_begin; /* its first primitive's number; the next shape's is where they end */
    uint32_t material;
    uint32_t emitter_begin; /* of its first primitive, the others follow; STAGE_NONE: no light */
    uint32_t detail; /* STAGE_NONE: it is shaded with the geometric normal, in any local frame */
};

/* What shading asks of a shape beyond points and geometric normals (surface_detail.h). */
struct stage_detail {
    /* Of a sphere, disc or cylinder: the x, y and z axes that its uv are counted in, unit. Of
     * triangles: the rows of what takes a normal to the world, but for its length. */
    float axes[3][3];
    uint32_t prim_begin;
    /* From here on of triangles. First elements: of the array of corners, the first primitive's; of
     * the others, that of vertex 0, or STAGE_NONE: the mesh has none, or nobody asks for them. */
    uint32_t corners, normals, uvs, colors;
    uint32_t mirrored; /* 1: corners 1 and 2 change places in the world */
};

/* A triangle's vertices, as the mesh numbers them; in v[0] with a bit that says that their normals
 * as a whole point away from its front. */
struct stage_corners {
    uint32_t v[3];
};

#define STAGE_CORNERS_BACK (1u << 31)

/* Of a vertex. */
struct stage_normal {
    float n[3];
};

struct stage_uv {
    float uv[2];
};

struct stage_color {
    float rgb[3];
};

/* How the numbers of an image are kept. */
enum stage_texels {
    STAGE_TEXELS_SRGB8, /* a byte, encoded; alpha is not */
    STAGE_TEXELS_U8,    /* a byte: value times 255 */
    STAGE_TEXELS_U16,   /* value times 65535 */
    STAGE_TEXELS_HALF,
    STAGE_TEXELS_FLOAT,
};

static inline uint32_t stage_texel_bytes(enum stage_texels texels)
{
    return texels <= STAGE_TEXELS_U8 ? 1 : texels == STAGE_TEXELS_FLOAT ? 4 : 2;
}

enum { STAGE_LEVELS = 15 }; /* of an image of SCENE_MAX_IMAGE_SIDE_PX */

/* An image in levels (texture.h), rows from the top, channels interleaved, nothing between rows. */
struct stage_pyramid {
    uint64_t level_at[STAGE_LEVELS]; /* bytes from the start of texels */
    uint32_t width_px, height_px;    /* of level 0 */
    uint32_t level_count;            /* the last one is 1 x 1 */
    uint32_t channels;               /* as in struct image_asset */
    enum stage_texels texels, coarse_texels; /* of level 0, of the others */
};

struct stage_bytes { /* what bytes decode to */
    float plain[256], srgb[256];
};

/* As struct texture, but: */
struct stage_texture {
    enum texture_kind kind;
    enum texture_wrap wrap;
    enum texture_filter filter;
    uint32_t pyramid; /* of an image; STAGE_NONE: nothing uses it */
    float uv_scale[2], uv_offset[2];
    float uv_area; /* |product| of uv_scale */
    float pad[3];
    rgb colors[2]; /* of a checker */
};

/* A hierarchy. The first is the world's, the others are of shared meshes. */
struct stage_tree {
    uint32_t root;                   /* bvh.h */
    uint32_t block_begin, block_end; /* its triangles */
    uint32_t pad;
    double cost; /* of a ray that crosses it: bvh_cost.h */
};

/* A shape whose mesh is shared. */
struct stage_instance {
    struct xform to_world;
    double to_object[3][4];
    uint32_t tree, shape, prim_begin;
    uint32_t mirrored;  /* 1: vertices 1 and 2 change places, so that the front stays the front */
    float lo[3], hi[3]; /* bounds in the world */
    float spread[3]; /* a world distance of 1 is at most this far along each axis in object space */
    float pad[3];
};

/* Something next-event estimation can aim at. Their order: emissive primitives by number; points
 * and spots (up to here they have a place: stage.far_begin); distant lights; what a ray that leaves
 * the scene can meet (from stage.beyond_begin on). */
enum emitter_kind { EMITTER_PRIM, EMITTER_POINT, EMITTER_SPOT, EMITTER_DISTANT, EMITTER_SUN, EMITTER_MAP };

struct emitter {
    enum emitter_kind kind;
    uint32_t prim;            /* EMITTER_PRIM */
    struct stage_place place; /* EMITTER_PRIM */
    uint32_t texture;         /* EMITTER_PRIM: radiance is multiplied by it; STAGE_NONE: none */
    float radiance[3];        /* PRIM, SUN: radiance; POINT, SPOT: intensity; DISTANT: irradiance;
                               * MAP: of a pixel value of 1 */
    float at[3];              /* POINT, SPOT: position; DISTANT, SUN: direction of travel, unit;
                               * a triangle: the middle that near_dd is counted from */
    union {
        float area;     /* EMITTER_PRIM: m^2 */
        float cap;      /* SUN: 1 - cos of its radius */
        uint32_t index; /* SPOT: into stage.spots; MAP: into stage.maps */
    };
    float pick; /* probability of being chosen; they sum to 1 */
    float near_dd;   /* a triangle: the square of how near it is sampled by solid angle (light_solid.h) */
    int32_t partner; /* of a quad's triangles: the other one is so many emitters further on; else 0 */
    uint32_t slot;   /* in the tree over many lights, 8 node + lane; else 0 */
    uint32_t pad;
};

_Static_assert(sizeof(struct emitter) == STAGE_ALIGN, "one of many comes from memory as one line");

struct stage_spot {
    float direction[3]; /* unit */
    float inner, outer; /* 1 - cos of the angles between which its light falls off */
};

/* An environment map: light_map.h. */
struct stage_map {
    float to_local[3][4]; /* rows of a rotation */
    uint32_t width, height;
    uint64_t pixel_begin; /* in stage.map_pixels and .map_columns, rows from the top */
    uint64_t row_begin;   /* in stage.map_rows */
};

struct stage_map_row {
    float edge, width;   /* s = (1 - cos) / 2 of the angle from the nearer pole: at the row's edge that
                          * is nearer to it, and how much more at the other */
    float solid_angle;   /* of one of its pixels */
    uint32_t begin;      /* its part of [0, 2^32) begins here and ends where the next one's does;
                          * UINT32_MAX: at the end, it is empty */
};

struct stage_map_pixel {
    float rgb[3];
};

/* A node of the tree over the emitters that have a place: eight groups of them, lane by lane, a
 * group being a node again or one emitter. The lanes not used are behind the others and have no
 * intensity. light_tree.h says what is made of it. 384 bytes: of a node whose lights all shine all
 * round, the first three lines alone are looked at. */
struct stage_light_node {
    float center[3][STAGE_LANES], radius[STAGE_LANES]; /* of a sphere that holds them */
    float intensity[STAGE_LANES]; /* the sum of the most each shines to where it faces, > 0; in units
                                   * of all of it over the square of the scene's radius */
    uint32_t child[STAGE_LANES]; /* a node, or STAGE_LIGHT_LEAF + an emitter; the first one's with
                                  * STAGE_LIGHT_ROUND if all lights of all lanes shine all round */

    float axis[3][STAGE_LANES]; /* unit: the middle of the directions in which they face */
    float facing[STAGE_LANES];  /* cos of the angle from there to the last of those directions */
    float reach[STAGE_LANES];   /* cos of the largest angle from where one faces to where it shines */
    uint32_t pad[8];
};

#define STAGE_LIGHT_LEAF  0x80000000u
#define STAGE_LIGHT_ROUND 0x40000000u

/* The emitters once more, in lanes, where there are few and all are triangles that pick_cdf chooses
 * among: light8.h. */
struct stage_lamps {
    _Alignas(32) float v[3][3][STAGE_LANES]; /* [vertex][axis][lane]; unused lanes are as lane 0 */
    float normal[3][STAGE_LANES];            /* unit, as of surface_on_triangle */
    float area[STAGE_LANES], radiance[3][STAGE_LANES];
    float middle[3][STAGE_LANES], near_dd[STAGE_LANES];
    float begin[STAGE_LANES], end[STAGE_LANES]; /* the emitter's part of pick_cdf */
    uint32_t prim[STAGE_LANES];
    uint32_t count; /* of emitters */
    uint32_t pad[7];
};

struct stage_camera { /* as perspective and thin lens have it; the others: camera.c */
    float origin[3];
    float corner[3];    /* direction_raw through the top left corner of the frame, 1 deep */
    float dx[3], dy[3]; /* per pixel to the right, down */
    enum camera_kind kind;
    uint32_t blades;            /* THIN_LENS: corners of the aperture; 0: round */
    float lens_x[3], lens_y[3]; /* THIN_LENS: across the aperture, from its middle to its circle */
    float inv_focus;            /* THIN_LENS: 1 / m */
    float turns_x, turns_y;     /* PANORAMIC: per pixel */
};

/* A pixel filter that is no box and no tent: it is even in x and in y, and its absolute value, on one
 * side, of mass 1, is straight between knots (filter.h). */
struct stage_knot {
    float x_px;
    float density; /* per pixel */
    float cdf;     /* mass up to here */
};

struct stage_filter {
    float gain;    /* of a sample's weight, along each axis; 1: the filter is nowhere negative */
    float zero_px; /* beyond this distance from the middle it is negative */
};

struct stage_view { /* what depth is measured along */
    float position[3];
    float direction[3]; /* unit; 0: none, depth is the distance */
};

/* Bodies around a point: materials, in the order in which they were entered (medium.h). */
enum { STAGE_BODIES = 8 };

struct stage_bodies {
    uint32_t count;
    uint32_t missed; /* entered when there was no room for them */
    uint32_t material[STAGE_BODIES];
};

/* What is counted (struct film_work) in units of work, each (work.h). */
struct stage_prices {
    uint32_t camera_ray, bounce_ray, shadow_ray, plain_vertex, other_vertex;
};

struct stage {
    char magic[8];         /* STAGE_MAGIC */
    uint32_t version;      /* STAGE_VERSION */
    uint32_t struct_bytes; /* sizeof(struct stage): another build's layout is refused */
    uint64_t bytes;        /* of the whole block */

    struct stage_camera camera;
    struct stage_view view;
    struct scene_film film;
    struct stage_filter filter;
    struct scene_settings settings;
    rgb sky;                     /* radiance of rays that leave the scene */
    float bounds[2][3];          /* of all primitives */
    uint32_t dropped_degenerate; /* zero-area triangles, not in any array */
    uint32_t dropped_nonfinite;  /* triangles with a vertex that is not finite */
    uint32_t bvh_depth;

    uint32_t prim_count;
    uint32_t wrapped, masked; /* 1: there are materials made of others; among them masks */
    uint32_t glowing;         /* 1: there are emitters with textures */
    uint32_t guide_shift;
    uint32_t far_begin, beyond_begin; /* among the emitters: see there */

    uint32_t media;             /* what the scene uses of medium.h */
    struct stage_bodies around; /* the camera, when media is not 0 */
    float cone_width, cone_spread; /* of camera rays (cone.h), when there are pyramids */
    struct stage_prices prices;

    /* Only spans from here to the end: stage_check knows them by their place. */
    struct stage_span shapes; /* struct stage_shape, and one more, whose prim_begin is prim_count */
    struct stage_span trees;  /* struct stage_tree */
    struct stage_span nodes;  /* struct bvh_node (bvh.h), of all trees */
    struct stage_span blocks; /* struct stage_block, of all trees */
    struct stage_span instances; /* struct stage_instance */
    struct stage_span spheres;   /* struct stage_sphere */
    struct stage_span discs;     /* struct stage_disc */
    struct stage_span cylinders; /* struct stage_cylinder */
    struct stage_span materials; /* struct material, names NULL */
    struct stage_span emitters;  /* struct emitter */
    struct stage_span pick_cdf;  /* float: cumulative pick, one more than emitters */
    struct stage_span knots;     /* struct stage_knot, or none */
    struct stage_span lamps;     /* struct stage_lamps: one, or none */
    struct stage_span guide;     /* uint32_t: the shape of primitive i << guide_shift, then that of
                                  * the last one */
    struct stage_span details;   /* struct stage_detail */
    struct stage_span corners;   /* struct stage_corners */
    struct stage_span normals;   /* struct stage_normal */
    struct stage_span uvs;       /* struct stage_uv */
    struct stage_span colors;    /* struct stage_color */
    struct stage_span slots;     /* struct material_slot */
    struct stage_span reliefs;   /* struct material_relief */
    struct stage_span textures;  /* struct stage_texture */
    struct stage_span pyramids;  /* struct stage_pyramid */
    struct stage_span bytes8;    /* struct stage_bytes, one if anything is kept in bytes */
    struct stage_span texels;    /* bytes, of all pyramids */
    struct stage_span spots;     /* struct stage_spot */
    struct stage_span light_nodes; /* struct stage_light_node; none: there are too few lights */
    struct stage_span light_parents; /* uint32_t: of each node its slot; the root is node 0 */
    struct stage_span maps;          /* struct stage_map */
    struct stage_span map_rows;      /* struct stage_map_row, of all maps */
    struct stage_span map_pixels;    /* struct stage_map_pixel, of all maps */
    struct stage_span map_columns;   /* uint32_t: as row.begin, of each pixel in its row */
};

static inline const void *stage_at(const struct stage *s, struct stage_span span)
{
    return (const unsigned char *)s + span.offset;
}

static inline const struct stage_instance *stage_instance_at(const struct stage *s, uint32_t i)
{
    return (const struct stage_instance *)stage_at(s, s->instances) + i;
}

static inline const struct emitter *stage_emitter_at(const struct stage *s, uint32_t i)
{
    return (const struct emitter *)stage_at(s, s->emitters) + i;
}

static inline struct stage_triangle stage_block_lane(const struct stage_block *b, uint32_t lane)
{
    return (struct stage_triangle){{
        {b->v[0][0][lane], b->v[0][1][lane], b->v[0][2][lane]},
        {b->v[1][0][lane], b->v[1][1][lane], b->v[1][2][lane]},
        {b->v[2][0][lane], b->v[2][1][lane], b->v[2][2][lane]},
    }};
}

/* The world's vertices of a triangle; instance: STAGE_NONE for one that is not shared. */
static inline struct stage_triangle stage_triangle_at(const struct stage *s, uint32_t index,
                                                      uint32_t instance)
{
    const struct stage_block *blocks = stage_at(s, s->blocks);
    const struct stage_triangle t =
        stage_block_lane(&blocks[index / STAGE_LANES], index % STAGE_LANES);
    if (instance == STAGE_NONE)
        return t;
    const struct stage_instance *of = stage_instance_at(s, instance);
    struct stage_triangle world;
    for (int i = 0; i < 3; i++)
        vec3_store(world.v[of->mirrored ? (3 - i) % 3 : i],
                   xform_point(&of->to_world, vec3_load(t.v[i])));
    return world;
}

/* The shape that a primitive belongs to: the last one that does not begin after it. */
static inline uint32_t stage_shape_of(const struct stage *s, uint32_t prim)
{
    const struct stage_shape *shapes = stage_at(s, s->shapes);
    const uint32_t *guide = (const uint32_t *)stage_at(s, s->guide) + (prim >> s->guide_shift);
    uint32_t begin = guide[0], count = guide[1] - begin + 1;
    while (count > 1) {
        const uint32_t half = count / 2;
        begin += half & -(uint32_t)(shapes[begin + half].prim_begin <= prim); /* no branch */
        count -= half;
    }
    return begin;
}

/* Whether the bytes, 64-aligned and from anywhere, are a block of this build with every array
 * inside it. What stands in the arrays is not looked at: who keeps a block says how it is held
 * against damage. */
bool stage_check(const void *block, size_t bytes, struct err *) MUST_CHECK;

#endif
