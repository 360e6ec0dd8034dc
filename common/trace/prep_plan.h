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
    struct stage_spot *spots;
    struct stage_light_node *light_nodes; /* NULL: no tree */
    uint32_t *light_slots, *light_parents;
};

/* Allocates the arrays. False: too many primitives. */
bool prep_plan_make(struct prep_plan *, const struct scene *, struct arena *scratch,
                    struct err *) MUST_CHECK;

/* Shapes -> primitives, emitters, and trees with their plans. The bounds of the scene are then
 * known. */
void prep_shapes(struct prep_plan *, const struct crew *);

/* The document's lights -> emitters behind those of shapes; and the table by which one is picked, or
 * the tree if they are many. After prep_shapes: a distant light shines on what there is. */
void prep_lights(struct prep_plan *, struct arena *scratch);

/* The tree over emitters [0, far_begin), which know their triangles by their number among the
 * world's. radius: of the scene. */
void prep_light_tree(struct prep_plan *, double radius, struct arena *scratch);

#endif
