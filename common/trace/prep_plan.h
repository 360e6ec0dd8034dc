/* prep_plan.h - what prep.c and its helpers fill before the block is laid out. Private to them.
 * SPDX-License-Identifier: MIT */
#ifndef COMMON_TRACE_PREP_PLAN_H
#define COMMON_TRACE_PREP_PLAN_H

#include "common/trace/bvh_build.h"

/* A tree to be, and its triangles in the order in which they were added. */
struct prep_tree {
    struct bvh_item *items;           /* until the plan is made, which is before the block is: */
    struct arena item_arena;          /* their memory */
    struct stage_triangle *triangles; /* of the world: in world space; of a mesh: in object space */
    uint32_t *prims;                  /* their numbers, in the scene or in the mesh */
    uint32_t item_count, triangle_count;
    struct bvh_plan plan;
};

/* Where a mesh's triangles and vertices come to lie in the stage's arrays; STAGE_NONE: nowhere. The
 * same mesh is another one for shapes whose normals are made. */
struct prep_mesh {
    const float *given; /* the normals, as struct mesh has them */
    uint32_t corners; /* of all its triangles */
    uint32_t in_tree; /* of those that its shared tree has kept, when these are not all */
    uint32_t normals, uvs, colors;
};

/* Everything is copied into the block. Memory of the scratch arena. */
struct prep_plan {
    const struct scene *scene;
    struct stage head;
    struct stage_shape *shapes;
    struct prep_tree *trees; /* the world's, then one of each shared mesh */
    uint32_t tree_count;
    uint32_t *mesh_tree; /* of each mesh: its tree; 0: it is not shared */
    struct stage_instance *instances;
    struct stage_sphere *spheres;
    struct stage_disc *discs;
    struct stage_cylinder *cylinders;
    struct emitter *emitters;
    double *power; /* of each emitter */
    float *pick_cdf;
    struct stage_knot *knots;
    struct stage_detail *details;
    struct prep_mesh *detail_meshes; /* two of each mesh; the second: smooth */
    uint32_t quad_uvs; /* as in struct prep_mesh */
    struct stage_texture *textures;
    struct stage_pyramid *pyramids;
    struct prep_image *pyramid_images; /* what they are made of */
    struct stage_spot *spots;
    struct stage_light_node *light_nodes; /* NULL: no tree */
    uint32_t *light_parents;
    struct stage_map *maps; /* room for all lights' */
    struct stage_map_row *map_rows;
    struct stage_map_pixel *map_pixels;
    uint32_t *map_columns;
};

/* Allocates the arrays. False: too many primitives. */
bool prep_plan_make(struct prep_plan *, const struct scene *, struct arena *scratch,
                    struct err *) MUST_CHECK;

/* Shapes -> primitives, emitters, and trees with their plans. The bounds of the scene are then
 * known. */
void prep_shapes(struct prep_plan *, const struct crew *);

/* Whether the shape is an instance: its triangles are those of its mesh's own tree. */
bool prep_shape_is_shared(const struct prep_plan *, const struct shape *);

/* --- prep_triangle.c: the triangles of quads and meshes, number i of them --- */

enum prep_fate { PREP_KEPT, PREP_NONFINITE, PREP_DEGENERATE };

enum prep_fate prep_triangle_make(const vec3 v[3], struct stage_triangle *, double *area);

/* Whether the transform turns the winding. */
bool prep_triangle_mirrored(const struct shape *);
/* The numbers of a quad's corners, in the order in which they lie in the world. */
void prep_triangle_quad(bool mirrored, uint32_t i, uint32_t v[3]);
void prep_triangle_object(const struct mesh *, uint32_t i, vec3 v[3]);
/* The front stays where the author put it: a mirroring transform turns the winding, so it is turned
 * back. mesh: the shape's; NULL for a quad. */
void prep_triangle_world(const struct mesh *, const struct shape *, bool mirrored, uint32_t i,
                         vec3 v[3]);

/* --- prep_detail.c --- */

/* Once all shapes have their primitives: which of them have a detail, and where its parts will lie;
 * then the parts. False: too many vertices. */
bool prep_detail_plan(struct prep_plan *, struct arena *scratch, struct err *) MUST_CHECK;
void prep_detail_write(const struct prep_plan *, unsigned char *block);

/* --- prep_smooth.c --- */

/* Normals for the mesh's vertices, made of its triangles': as struct mesh has them. */
const float *prep_smooth_make(const struct mesh *, struct arena *);

/* Where the camera stands and how it maps the film. */
void prep_camera(struct stage_camera *, const struct scene *);

/* The document's lights -> emitters behind those of shapes; and the table by which one is picked, or
 * the tree if they are many. After prep_shapes: a distant light shines on what there is. */
void prep_lights(struct prep_plan *, struct arena *scratch);

/* Makes room for the document's environment maps. */
void prep_map_open(struct prep_plan *, struct arena *scratch);
/* Whether all pixels are the same, *pixel: then the map is a sky. */
bool prep_map_is_uniform(const struct scene *, const struct light *, rgb *pixel);
/* Makes the next map, and its emitter but for prim and pick. Returns what it sends of light above its
 * mean, which is what is sampled: the integral of its luminance. */
double prep_map_make(struct prep_plan *, struct emitter *, const struct light *,
                     struct arena *scratch);

/* The tree over emitters [0, far_begin), which know their triangles by their number among the
 * world's. radius: of the scene. */
void prep_light_tree(struct prep_plan *, double radius, struct arena *scratch);

/* The pixel filter's knots, if it has any; its zero and gain. */
void prep_filter(struct prep_plan *, struct arena *scratch);

/* --- prep_texture.c --- */

/* Once the camera is aimed: which textures are used, and where their pyramids will lie; then the
 * pyramids. False: too much memory. */
bool prep_texture_plan(struct prep_plan *, struct arena *scratch, struct err *) MUST_CHECK;
void prep_texture_write(const struct prep_plan *, unsigned char *block);

#endif
