/* mesh.h - an asset's bytes to arrays: PLY (ascii, binary of either endianness) and OBJ.
 *
 * Polygons become fans of triangles; PLY triangle strips are read. Normals, texture
 * coordinates, materials and other properties are passed over: surfaces are flat
 * triangles today. Bytes are hostile: counts are held against the input's size and
 * SCENE_MAX_TRIANGLES before anything is allocated, indices against the vertex count,
 * and a coordinate that is not finite is refused with its vertex.
 * Errors name the line (text) or the element and byte offset (binary).
 * SPDX-License-Identifier: MIT */
#ifndef COMMON_MESH_H
#define COMMON_MESH_H

#include "common/scene.h"

/* Fills vertices, indices and counts of `mesh` (whose format is set) with memory of the arena. */
bool mesh_read(struct mesh *mesh, const void *data, size_t bytes, struct arena *arena,
               struct err *err) MUST_CHECK;

/* By the file name's ending, .ply or .obj in any case; false for others. */
bool mesh_format_of(const char *file, enum mesh_format *format);

#endif
