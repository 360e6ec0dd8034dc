/* mesh_build.h - what the mesh readers share: growing arrays, tokens of text, numbers.
 *
 * Private to mesh*.c. Text is never NUL-terminated: a span is what one may look at. Memory
 * grows with the input only: each vertex and each corner takes bytes of the file.
 * SPDX-License-Identifier: MIT */
#ifndef COMMON_MESH_BUILD_H
#define COMMON_MESH_BUILD_H

#include "common/buf.h"
#include "common/mesh.h"

#define MESH_NONE UINT32_MAX

struct mesh_corner { /* of a face: numbers from 0 */
    uint32_t vertex;
    uint32_t uv, normal; /* that it names itself, or MESH_NONE */
};

struct mesh_build {
    struct buf vertices; /* float[3] each */
    struct buf indices;  /* uint32_t[3] each */
    struct buf polygon;  /* struct mesh_corner: the face in hand */
    /* Of each vertex, or for corners to name; empty: there are none. */
    struct buf normals, uvs; /* float[3], float[2] each; as struct mesh has them */
    struct buf colors;       /* float[3] each, of the first vertices: those behind them are white */
    struct buf corners;      /* struct mesh_corner[3] of each triangle; empty: they name nothing */
};

static inline size_t mesh_build_vertices(const struct mesh_build *b)
{
    return b->vertices.size / (3 * sizeof(float));
}

bool mesh_build_vertex(struct mesh_build *, const double p[3], struct err *) MUST_CHECK;
bool mesh_build_normal(struct mesh_build *, const double n[3], struct err *) MUST_CHECK;
bool mesh_build_uv(struct mesh_build *, const double uv[2], struct err *) MUST_CHECK;
/* Of the last vertex. white: sRGB-encoded, in [0, white]; 0: linear. */
bool mesh_build_color(struct mesh_build *, const double c[3], double white,
                      struct err *) MUST_CHECK;
/* What stands in `polygon`, as a fan around its first corner; then empties it. */
bool mesh_build_polygon(struct mesh_build *, struct err *) MUST_CHECK;
bool mesh_build_triangle(struct mesh_build *, const struct mesh_corner[3], struct err *) MUST_CHECK;
/* The colors of all vertices, if there are any. */
void mesh_build_whiten(struct mesh_build *);
/* What corners name, given to vertices (mesh_split.c): afterwards normals and uvs are of each
 * vertex, or none are. */
void mesh_build_split(struct mesh_build *);

struct mesh_span { /* [at, end) */
    const char *at, *end;
};

bool mesh_span_is(struct mesh_span, const char *word);
/* The next word of a line, which it leaves behind. False: there is none. A backslash before a
 * line's end counts as a space. */
bool mesh_span_token(struct mesh_span *line, struct mesh_span *token);
/* Decimal, correctly rounded; no hexadecimal, no infinity, no NaN. */
bool mesh_span_number(struct mesh_span token, double *);
bool mesh_span_integer(struct mesh_span token, int64_t *); /* |v| < 10^15 */
/* A word for a message: in quotes, cut, harmless. */
const char *mesh_span_print(struct mesh_span token, char out[64]);

/* The readers by format: all vertices and triangles of the bytes. */
bool mesh_ply_read(struct mesh_build *, struct mesh_span file, struct err *) MUST_CHECK;
bool mesh_obj_read(struct mesh_build *, struct mesh_span file, struct err *) MUST_CHECK;

#endif
