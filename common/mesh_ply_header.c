/* SPDX-License-Identifier: MIT */
#include "common/mesh_ply.h"

#include <string.h>

const struct ply_type_name mesh_ply_types[] = {
    [PLY_INT8] = {{"char", "int8"}, 1},        [PLY_UINT8] = {{"uchar", "uint8"}, 1},
    [PLY_INT16] = {{"short", "int16"}, 2},     [PLY_UINT16] = {{"ushort", "uint16"}, 2},
    [PLY_INT32] = {{"int", "int32"}, 4},       [PLY_UINT32] = {{"uint", "uint32"}, 4},
    [PLY_FLOAT32] = {{"float", "float32"}, 4}, [PLY_FLOAT64] = {{"double", "float64"}, 8},
};

void mesh_ply_line(struct ply *p)
{
    const size_t left = (size_t)(p->file.end - p->file.at);
    const char *newline = left ? memchr(p->file.at, '\n', left) : NULL;
    p->line = (struct mesh_span){p->file.at, newline ? newline : p->file.end};
    p->file.at = newline ? newline + 1 : p->file.end;
    p->line_count++;
}

size_t mesh_ply_row_bytes(const struct ply *p, const struct ply_element *e)
{
    size_t bytes = 0;
    for (size_t i = e->property_begin; i < e->property_end; i++) {
        const struct ply_property *property = &p->properties[i];
        const enum ply_type type = property->is_list ? property->count_type : property->type;
        bytes += p->format == PLY_ASCII ? 2 : mesh_ply_types[type].bytes; /* "0 " */
    }
    return bytes;
}

/* The next word of the line in hand, which has to be there. */
static bool word_next(struct ply *p, const char *what, struct mesh_span *word, struct err *err)
{
    if (!mesh_span_token(&p->line, word))
        return err_set(err, ERR_INPUT, "expected %s before the line ends", what);
    if (word->end - word->at > PLY_MAX_WORD)
        return err_set(err, ERR_INPUT, "expected %s of at most %d bytes", what, PLY_MAX_WORD);
    return true;
}

static bool type_next(struct ply *p, enum ply_type *type, struct err *err)
{
    struct mesh_span word;
    char shown[64];
    if (!word_next(p, "a type", &word, err))
        return false;
    for (size_t i = 0; i < countof(mesh_ply_types); i++)
        for (size_t k = 0; k < 2; k++)
            if (mesh_span_is(word, mesh_ply_types[i].names[k])) {
                *type = (enum ply_type)i;
                return true;
            }
    return err_set(err, ERR_INPUT,
                   "expected a type (char, uchar, short, ushort, int, uint, float, double), got %s",
                   mesh_span_print(word, shown));
}

static bool format_read(struct ply *p, struct err *err)
{
    static const char *const names[] = {[PLY_ASCII] = "ascii",
                                        [PLY_LITTLE] = "binary_little_endian",
                                        [PLY_BIG] = "binary_big_endian"};
    struct mesh_span word, version;
    char shown[64];
    if (!word_next(p, "a format", &word, err) || !word_next(p, "a version", &version, err))
        return false;
    if (!mesh_span_is(version, "1.0"))
        return err_set(err, ERR_INPUT, "expected PLY version 1.0, got %s",
                       mesh_span_print(version, shown));
    for (size_t i = 0; i < countof(names); i++)
        if (mesh_span_is(word, names[i])) {
            p->format = (enum ply_format)i;
            return true;
        }
    return err_set(err, ERR_INPUT,
                   "expected the format ascii, binary_little_endian or binary_big_endian, got %s",
                   mesh_span_print(word, shown));
}

static bool element_add(struct ply *p, struct err *err)
{
    struct mesh_span name, number;
    char shown[64];
    int64_t count;
    if (!word_next(p, "an element's name", &name, err) ||
        !word_next(p, "an element's count", &number, err))
        return false;
    if (!mesh_span_integer(number, &count) || count < 0)
        return err_set(err, ERR_INPUT, "expected a count, got %s", mesh_span_print(number, shown));
    if (p->element_count == PLY_MAX_ELEMENTS)
        return err_set(err, ERR_LIMIT, "expected at most %d elements", PLY_MAX_ELEMENTS);
    struct ply_element *e = &p->elements[p->element_count++];
    *e = (struct ply_element){.name = name,
                              .role = PLY_OTHER,
                              .count = (uint64_t)count,
                              .property_begin = p->property_count,
                              .property_end = p->property_count};
    if (mesh_span_is(name, "vertex"))
        e->role = PLY_VERTEX;
    else if (mesh_span_is(name, "face"))
        e->role = PLY_FACE;
    else if (mesh_span_is(name, "tristrips"))
        e->role = PLY_STRIPS;
    return true;
}

static enum ply_property_role role_of(const struct ply_element *e, const struct ply_property *p)
{
    if (e->role == PLY_VERTEX && !p->is_list) {
        if (mesh_span_is(p->name, "x"))
            return PLY_X;
        if (mesh_span_is(p->name, "y"))
            return PLY_Y;
        if (mesh_span_is(p->name, "z"))
            return PLY_Z;
    }
    if ((e->role == PLY_FACE || e->role == PLY_STRIPS) && p->is_list &&
        (mesh_span_is(p->name, "vertex_indices") || mesh_span_is(p->name, "vertex_index")))
        return PLY_INDICES;
    return PLY_PASSED;
}

static bool property_add(struct ply *p, struct err *err)
{
    if (p->element_count == 0)
        return err_set(err, ERR_INPUT, "expected an element before its properties");
    if (p->property_count == PLY_MAX_PROPERTIES)
        return err_set(err, ERR_LIMIT, "expected at most %d properties", PLY_MAX_PROPERTIES);
    struct ply_element *e = &p->elements[p->element_count - 1];
    struct ply_property property = {0};
    struct mesh_span look = p->line, word;
    if (mesh_span_token(&look, &word) && mesh_span_is(word, "list")) {
        p->line = look;
        property.is_list = true;
        if (!type_next(p, &property.count_type, err))
            return false;
        if (property.count_type >= PLY_FLOAT32)
            return err_set(err, ERR_INPUT, "expected a whole type for the count of a list");
    }
    if (!type_next(p, &property.type, err) ||
        !word_next(p, "a property's name", &property.name, err))
        return false;
    property.role = role_of(e, &property);
    p->properties[p->property_count++] = property;
    e->property_end = p->property_count;
    return true;
}

static size_t role_count(const struct ply *p, const struct ply_element *e,
                         enum ply_property_role role)
{
    size_t count = 0;
    for (size_t i = e->property_begin; i < e->property_end; i++)
        count += p->properties[i].role == role;
    return count;
}

static bool element_check(struct ply *p, const struct ply_element *e, struct err *err)
{
    if (e->property_begin == e->property_end)
        return err_set(err, ERR_INPUT, "expected a property in every element");
    switch (e->role) {
    case PLY_VERTEX:
        if (p->vertex_count >= 0)
            return err_set(err, ERR_INPUT, "expected one element \"vertex\", got two");
        p->vertex_count = (double)e->count;
        for (int role = PLY_X; role <= PLY_Z; role++)
            if (role_count(p, e, (enum ply_property_role)role) != 1)
                return err_set(err, ERR_INPUT,
                               "expected x, y and z once each among the properties of a vertex");
        return true;
    case PLY_FACE:
    case PLY_STRIPS:
        if (p->vertex_count < 0)
            return err_set(err, ERR_INPUT, "expected the vertices before the faces");
        if (role_count(p, e, PLY_INDICES) != 1)
            return err_set(err, ERR_INPUT,
                           "expected one list \"vertex_indices\" or \"vertex_index\" in a face");
        return true;
    case PLY_OTHER:
        return true;
    }
    __builtin_unreachable();
}

static bool header_line(struct ply *p, bool *format_seen, bool *end, struct err *err)
{
    struct mesh_span word;
    char shown[64];
    if (!mesh_span_token(&p->line, &word) || mesh_span_is(word, "comment") ||
        mesh_span_is(word, "obj_info"))
        return true;
    if (mesh_span_is(word, "format")) {
        *format_seen = true;
        return format_read(p, err);
    }
    if (mesh_span_is(word, "element"))
        return element_add(p, err);
    if (mesh_span_is(word, "property"))
        return property_add(p, err);
    *end = mesh_span_is(word, "end_header");
    return *end || err_set(err, ERR_INPUT,
                           "expected comment, obj_info, format, element, property or end_header, "
                           "got %s",
                           mesh_span_print(word, shown));
}

bool mesh_ply_header(struct ply *p, struct err *err)
{
    struct mesh_span word;
    bool format_seen = false, end = false;
    mesh_ply_line(p);
    if (!mesh_span_token(&p->line, &word) || !mesh_span_is(word, "ply"))
        return err_set(err, ERR_INPUT, "expected the word \"ply\", this is no PLY file");
    while (!end) {
        if (p->file.at == p->file.end)
            return err_set(err, ERR_INPUT, "expected end_header before the file ends");
        mesh_ply_line(p);
        if (!header_line(p, &format_seen, &end, err))
            return false;
    }
    if (!format_seen)
        return err_set(err, ERR_INPUT, "expected a line \"format ...\" in the header");
    p->vertex_count = -1;
    for (size_t i = 0; i < p->element_count; i++)
        if (!element_check(p, &p->elements[i], err))
            return false;
    return true;
}
