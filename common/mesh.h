/* mesh.h - an asset's bytes to arrays: PLY (ascii, binary of either endianness) and OBJ.
 *
 * Polygons become fans of triangles; PLY triangle strips are read. Normals, texture coordinates and
 * colours of vertices are read, of OBJ also those that corners name: a vertex of which corners name
 * different ones becomes as many. Materials and other properties are passed over. Bytes are
 * hostile: counts are held against the input's size and SCENE_MAX_TRIANGLES before anything is
 * allocated, indices against the counts of what they number, and a value that is not finite is
 * refused with its vertex. Errors name the line (text) or the element and byte offset (binary).
 * SPDX-License-Identifier: MIT */
#ifndef COMMON_MESH_H
#define COMMON_MESH_H

#include "common/scene.h"

/* How far u and v may be from 0: there, floats are a sixteenth apart. */
#define MESH_MAX_UV 1e6

/* Fills the arrays and counts of `mesh` (whose format is set) with memory of the arena. */
bool mesh_read(struct mesh *mesh, const void *data, size_t bytes, struct arena *arena,
               struct err *err) MUST_CHECK;

/* n over its length; 0, 0, 0 stays. Finite. */
void mesh_normal_make(const double n[3], float out[3]);

/* By the file name's ending, .ply or .obj in any case; false for others. */
bool mesh_format_of(const char *file, enum mesh_format *format);

#endif
