/* mesh_build.h - what the mesh readers share: growing arrays, tokens of text, numbers.
 *
 * Private to mesh*.c. Text is never NUL-terminated: a span is what one may look at. Memory
 * grows with the input only: each vertex and each corner takes bytes of the file.
 * SPDX-License-Identifier: MIT */
#ifndef COMMON_MESH_BUILD_H
#define COMMON_MESH_BUILD_H

#include "common/buf.h"
#include "common/mesh.h"

struct mesh_build {
    struct buf vertices; /* float[3] each */
    struct buf indices;  /* uint32_t[3] each */
    struct buf polygon;  /* uint32_t: corners of the face in hand */
};

static inline size_t mesh_build_vertices(const struct mesh_build *b)
{
    return b->vertices.size / (3 * sizeof(float));
}

bool mesh_build_vertex(struct mesh_build *, const double p[3], struct err *) MUST_CHECK;
/* What stands in `polygon`, as a fan around its first corner; then empties it. */
bool mesh_build_polygon(struct mesh_build *, struct err *) MUST_CHECK;
bool mesh_build_triangle(struct mesh_build *, uint32_t a, uint32_t b, uint32_t c,
                         struct err *) MUST_CHECK;

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
