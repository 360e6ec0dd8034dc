/* mesh_ply.h - the header of a PLY file: which elements follow, and how their rows are laid out.
 *
 * Private to mesh_ply.c and mesh_ply_header.c.
 * SPDX-License-Identifier: MIT */
#ifndef COMMON_MESH_PLY_H
#define COMMON_MESH_PLY_H

#include "common/mesh_build.h"

enum ply_format { PLY_ASCII, PLY_LITTLE, PLY_BIG };

enum ply_type {
    PLY_INT8,
    PLY_UINT8,
    PLY_INT16,
    PLY_UINT16,
    PLY_INT32,
    PLY_UINT32,
    PLY_FLOAT32,
    PLY_FLOAT64
};

struct ply_type_name {
    const char *names[2]; /* of 1994, and with its size */
    size_t bytes;
};

extern const struct ply_type_name mesh_ply_types[PLY_FLOAT64 + 1];

enum ply_property_role {
    /* A number of a vertex: */
    PLY_X,
    PLY_Y,
    PLY_Z,
    PLY_NX,
    PLY_NY,
    PLY_NZ,
    PLY_U,
    PLY_V,
    PLY_RED,
    PLY_GREEN,
    PLY_BLUE,
    PLY_NUMBERS, /* as many */
    PLY_INDICES = PLY_NUMBERS,
    PLY_PASSED
};

struct ply_property {
    struct mesh_span name;
    bool is_list;
    enum ply_type type, count_type; /* count_type: of a list, a whole number's */
    enum ply_property_role role;
};

enum ply_element_role { PLY_VERTEX, PLY_FACE, PLY_STRIPS, PLY_OTHER };

struct ply_element {
    struct mesh_span name; /* in the file; no longer than PLY_MAX_WORD */
    enum ply_element_role role;
    bool has_normal, has_uv, has_color; /* a vertex */
    double white;                       /* of its colors, as mesh_build_color has it */
    uint64_t count;
    size_t property_begin, property_end; /* into ply.properties */
};

enum { PLY_MAX_ELEMENTS = 16, PLY_MAX_PROPERTIES = 256, PLY_MAX_WORD = 64 };

struct ply {
    struct mesh_span file;  /* what is left */
    const char *file_begin; /* for byte offsets */
    struct mesh_span line;  /* the line in hand, text only */
    size_t line_count;      /* the number of that line, from 1 */
    enum ply_format format;
    double vertex_count;
    struct ply_element elements[PLY_MAX_ELEMENTS];
    size_t element_count;
    struct ply_property properties[PLY_MAX_PROPERTIES];
    size_t property_count;
};

/* Leaves `file` at the first byte of the first row. The rows that need it find: vertices before
 * faces and strips, x, y, z in a vertex, normals, texture coordinates and colors whole or not at
 * all, one list of indices in a face or strip. */
bool mesh_ply_header(struct ply *, struct err *) MUST_CHECK;
void mesh_ply_line(struct ply *); /* sets `line`, moves `file` behind it */
size_t mesh_ply_row_bytes(const struct ply *, const struct ply_element *); /* the fewest; not 0 */

#endif
