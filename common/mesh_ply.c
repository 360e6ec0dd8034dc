/* Polygon File Format, ascii and binary: G. Turk, "The PLY polygon file format", Stanford, 1994.
 * Rows of the elements vertex, face and tristrips are used, all others are stepped over.
 * SPDX-License-Identifier: MIT */
#include "common/mesh_ply.h"

#include <math.h>
#include <string.h>

static size_t bytes_left(const struct ply *p)
{
    return (size_t)(p->file.end - p->file.at);
}

static uint64_t bits_read(const struct ply *p, size_t size)
{
    uint64_t bits = 0;
    for (size_t i = 0; i < size; i++) {
        const size_t at = p->format == PLY_BIG ? i : size - 1 - i;
        bits = bits << 8 | (unsigned char)p->file.at[at];
    }
    return bits;
}

static double bits_value(uint64_t bits, enum ply_type type)
{
    float f;
    double d;
    const uint32_t low = (uint32_t)bits;
    switch (type) {
    case PLY_INT8:
        return (int8_t)bits;
    case PLY_UINT8:
    case PLY_UINT16:
    case PLY_UINT32:
        return low;
    case PLY_INT16:
        return (int16_t)bits;
    case PLY_INT32:
        return (int32_t)low;
    case PLY_FLOAT32:
        memcpy(&f, &low, sizeof f);
        return (double)f;
    case PLY_FLOAT64:
        memcpy(&d, &bits, sizeof d);
        return d;
    }
    __builtin_unreachable();
}

static bool text_value(struct ply *p, double *out, struct err *err)
{
    struct mesh_span token;
    char shown[64];
    if (!mesh_span_token(&p->line, &token))
        return err_set(err, ERR_INPUT, "expected more values before the line ends");
    if (!mesh_span_number(token, out))
        return err_set(err, ERR_INPUT, "expected a number, got %s", mesh_span_print(token, shown));
    return true;
}

static bool value_read(struct ply *p, enum ply_type type, double *out, struct err *err)
{
    if (p->format == PLY_ASCII)
        return text_value(p, out, err);
    const size_t size = mesh_ply_types[type].bytes;
    if (bytes_left(p) < size)
        return err_set(err, ERR_INPUT, "the file ends too early");
    *out = bits_value(bits_read(p, size), type);
    p->file.at += size;
    return true;
}

/* How many values a list has; never more than there are bytes for. */
static bool list_count(struct ply *p, const struct ply_property *property, size_t *count,
                       struct err *err)
{
    double n;
    if (!value_read(p, property->count_type, &n, err))
        return false;
    const struct mesh_span rest = p->format == PLY_ASCII ? p->line : p->file;
    const size_t size = p->format == PLY_ASCII ? 2 : mesh_ply_types[property->type].bytes;
    const size_t room = ((size_t)(rest.end - rest.at) + 1) / size; /* no space after the last */
    if (!(n >= 0 && n == floor(n) && n <= (double)room))
        return err_set(err, ERR_INPUT, "expected a list of 0 to %zu values, got a count of %g",
                       room, n);
    *count = (size_t)n;
    return true;
}

/* Corners into `polygon`; -1, which ends a strip, as vertex MESH_NONE. */
static bool index_list_read(struct ply *p, const struct ply_property *property, bool strips,
                            struct mesh_build *b, struct err *err)
{
    size_t count;
    if (!list_count(p, property, &count, err))
        return false;
    b->polygon.size = 0;
    for (size_t i = 0; i < count; i++) {
        double v;
        if (!value_read(p, property->type, &v, err))
            return false;
        const bool end = strips && v == -1;
        if (!end && !(v >= 0 && v < p->vertex_count && v == floor(v)))
            return err_set(err, ERR_INPUT, "expected a vertex from 0 to %.0f, got %g",
                           p->vertex_count - 1, v);
        const uint32_t index = end ? MESH_NONE : (uint32_t)v;
        buf_append(&b->polygon, &(struct mesh_corner){index, MESH_NONE, MESH_NONE},
                   sizeof(struct mesh_corner));
    }
    return true;
}

/* Each corner after the second makes a triangle with the two before it; every other one is
 * turned round. Strips are joined by repeated corners: those triangles have no area. */
static bool strips_cut(struct mesh_build *b, struct err *err)
{
    const struct mesh_corner *corner = (const struct mesh_corner *)(const void *)b->polygon.data;
    const size_t count = b->polygon.size / sizeof *corner;
    size_t length = 0; /* corners of this strip so far */
    for (size_t i = 0; i < count; i++) {
        length = corner[i].vertex == MESH_NONE ? 0 : length + 1;
        if (length < 3)
            continue;
        const uint32_t u = corner[i - 2].vertex, v = corner[i - 1].vertex, w = corner[i].vertex;
        const size_t odd = length % 2 == 0;
        if (u != v && v != w && w != u &&
            !mesh_build_triangle(
                b, (struct mesh_corner[3]){corner[i - 2 + odd], corner[i - 1 - odd], corner[i]},
                err))
            return false;
    }
    b->polygon.size = 0;
    return true;
}

static bool list_skip(struct ply *p, const struct ply_property *property, struct err *err)
{
    size_t count;
    if (!list_count(p, property, &count, err))
        return false;
    for (size_t i = 0; i < count; i++) {
        double v;
        if (!value_read(p, property->type, &v, err))
            return false;
    }
    return true;
}

static bool vertex_add(const struct ply_element *e, const double number[PLY_NUMBERS],
                       struct mesh_build *b, struct err *err)
{
    return mesh_build_vertex(b, &number[PLY_X], err) &&
           (!e->has_normal || mesh_build_normal(b, &number[PLY_NX], err)) &&
           (!e->has_uv || mesh_build_uv(b, &number[PLY_U], err)) &&
           (!e->has_color || mesh_build_color(b, &number[PLY_RED], e->white, err));
}

static bool properties_read(struct ply *p, const struct ply_element *e, struct mesh_build *b,
                            struct err *err)
{
    double number[PLY_NUMBERS], ignored;
    for (size_t i = e->property_begin; i < e->property_end; i++) {
        const struct ply_property *property = &p->properties[i];
        const bool used = property->role < PLY_NUMBERS;
        if (property->role == PLY_INDICES
                ? !index_list_read(p, property, e->role == PLY_STRIPS, b, err)
            : property->is_list
                ? !list_skip(p, property, err)
                : !value_read(p, property->type, used ? &number[property->role] : &ignored, err))
            return false;
    }
    switch (e->role) {
    case PLY_VERTEX:
        return vertex_add(e, number, b, err);
    case PLY_FACE:
        return mesh_build_polygon(b, err);
    case PLY_STRIPS:
        return strips_cut(b, err);
    case PLY_OTHER:
        return true;
    }
    __builtin_unreachable();
}

/* The line of a row; empty lines are no rows. */
static bool row_line(struct ply *p, struct err *err)
{
    struct mesh_span look;
    do {
        if (p->file.at == p->file.end)
            return err_set(err, ERR_INPUT, "the file ends too early");
        mesh_ply_line(p);
        look = p->line;
    } while (!mesh_span_token(&look, &(struct mesh_span){0}));
    return true;
}

static bool row_read(struct ply *p, const struct ply_element *e, struct mesh_build *b,
                     struct err *err)
{
    if (p->format != PLY_ASCII)
        return properties_read(p, e, b, err);
    struct mesh_span rest;
    char shown[64];
    if (!row_line(p, err) || !properties_read(p, e, b, err))
        return false;
    if (mesh_span_token(&p->line, &rest))
        return err_set(err, ERR_INPUT, "expected the end of the line, got %s",
                       mesh_span_print(rest, shown));
    return true;
}

static bool element_read(struct ply *p, const struct ply_element *e, struct mesh_build *b,
                         struct err *err)
{
    const size_t room = (bytes_left(p) + 1) / mesh_ply_row_bytes(p, e); /* the last line may lack
                                                                         * its end */
    if (e->count > room)
        return err_set(err, ERR_INPUT,
                       "%.*s: expected at most %zu rows in the %zu bytes left, got %llu",
                       (int)(e->name.end - e->name.at), e->name.at, room, bytes_left(p),
                       (unsigned long long)e->count);
    const char *begin = p->file_begin;
    for (uint64_t i = 0; i < e->count; i++) {
        const size_t at = (size_t)(p->file.at - begin);
        if (row_read(p, e, b, err))
            continue;
        const int name_length = (int)(e->name.end - e->name.at);
        if (p->format == PLY_ASCII)
            return err_at(err, "line %zu: %.*s %llu", p->line_count, name_length, e->name.at,
                          (unsigned long long)i);
        return err_at(err, "byte %zu: %.*s %llu", at, name_length, e->name.at,
                      (unsigned long long)i);
    }
    return true;
}

bool mesh_ply_read(struct mesh_build *b, struct mesh_span file, struct err *err)
{
    struct ply p = {.file = file, .file_begin = file.at};
    if (!mesh_ply_header(&p, err))
        return err_at(err, "line %zu", p.line_count);
    for (size_t i = 0; i < p.element_count; i++)
        if (!element_read(&p, &p.elements[i], b, err))
            return false;
    return true;
}
