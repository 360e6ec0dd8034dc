/* scene_read.h - the parts of a document, each read into its part of the scene.
 *
 * Private to the scene reader. Each function goes on after a fault and fills what was good; the
 * scene may be used only when the document has no fault at all.
 * SPDX-License-Identifier: MIT */
#ifndef COMMON_SCENE_READ_H
#define COMMON_SCENE_READ_H

#include "common/scene_doc.h"
#include "common/scene_names.h"

void scene_read(struct scene_doc *, const struct scene_at *whole, struct scene *);

struct scene_names scene_read_textures(struct scene_doc *, const struct scene_at *, struct scene *);
struct scene_names scene_read_materials(struct scene_doc *, const struct scene_at *,
                                        const struct scene_names *textures, struct scene *);
/* What shapes may name. */
struct scene_known {
    const struct scene_names *materials, *textures;
};
void scene_read_shapes(struct scene_doc *, const struct scene_at *, const struct scene_known *,
                       struct scene *);
void scene_read_filter(struct scene_doc *, const struct scene_at *, struct scene_film *);
void scene_read_camera(struct scene_doc *, const struct scene_at *, struct scene_camera *);
void scene_read_lights(struct scene_doc *, const struct scene_at *, struct scene *);
void scene_read_mesh(struct scene_doc *, const struct scene_at *shape, struct mesh *,
                     enum mesh_normals *);

/* The image that an object names by "file", or by "asset" and "format", which are among its keys;
 * `what` names it in messages: "an image texture". */
bool scene_read_image(struct scene_doc *, const struct scene_at *, const char *what, struct scene *,
                      uint32_t *image);

/* scene_xform.h's map from a list of steps or a matrix. */
struct scene_xform;
bool scene_read_matrix(struct scene_doc *, const struct scene_at *, struct scene_xform *);
bool scene_read_transform(struct scene_doc *, const struct scene_at *, struct scene_xform *);

#endif
