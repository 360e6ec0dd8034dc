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
    static const struct {
        const char *name;
        enum ply_property_role role;
    } known[] = {{"x", PLY_X},         {"y", PLY_Y},         {"z", PLY_Z},
                 {"nx", PLY_NX},       {"ny", PLY_NY},       {"nz", PLY_NZ},
                 {"s", PLY_U},         {"t", PLY_V},         {"u", PLY_U},
                 {"v", PLY_V},         {"texture_u", PLY_U}, {"texture_v", PLY_V},
                 {"texture_s", PLY_U}, {"texture_t", PLY_V}, {"red", PLY_RED},
                 {"green", PLY_GREEN}, {"blue", PLY_BLUE}};
    if (e->role == PLY_VERTEX && !p->is_list)
        for (size_t i = 0; i < countof(known); i++)
            if (mesh_span_is(p->name, known[i].name))
                return known[i].role;
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

/* Properties that only together mean something: *some are there once each, or none is. */
static bool group_check(const struct ply *p, const struct ply_element *e,
                        enum ply_property_role first, enum ply_property_role last, bool *some)
{
    size_t least = SIZE_MAX, most = 0;
    for (int role = (int)first; role <= (int)last; role++) {
        const size_t count = role_count(p, e, (enum ply_property_role)role);
        least = min_size(least, count);
        most = most > count ? most : count;
    }
    *some = most > 0;
    return most == 0 || (most == 1 && least == 1);
}

/* Bytes and such are sRGB-encoded, floats linear: so say those who write them. */
static bool color_check(const struct ply *p, struct ply_element *e, struct err *err)
{
    enum ply_type type = PLY_FLOAT32;
    size_t same = 0;
    for (size_t i = e->property_begin; i < e->property_end; i++) {
        const enum ply_property_role role = p->properties[i].role;
        if (role < PLY_RED || role > PLY_BLUE)
            continue;
        type = same ? type : p->properties[i].type;
        same += p->properties[i].type == type;
    }
    e->white = type == PLY_UINT8 ? 255 : type == PLY_UINT16 ? 65535 : 0;
    if (same == 3 && (e->white > 0 || type >= PLY_FLOAT32))
        return true;
    return err_set(err, ERR_INPUT,
                   "expected red, green and blue of one type: uchar, ushort, float or double");
}

static bool vertex_check(struct ply *p, struct ply_element *e, struct err *err)
{
    bool some;
    if (p->vertex_count >= 0)
        return err_set(err, ERR_INPUT, "expected one element \"vertex\", got two");
    p->vertex_count = (double)e->count;
    if (!group_check(p, e, PLY_X, PLY_Z, &some) || !some)
        return err_set(err, ERR_INPUT,
                       "expected x, y and z once each among the properties of a vertex");
    if (!group_check(p, e, PLY_NX, PLY_NZ, &e->has_normal))
        return err_set(err, ERR_INPUT, "expected nx, ny and nz once each, or none of them");
    if (!group_check(p, e, PLY_U, PLY_V, &e->has_uv))
        return err_set(err, ERR_INPUT,
                       "expected one pair of texture coordinates (s and t, u and v, texture_u and "
                       "texture_v, texture_s and texture_t), or none");
    if (!group_check(p, e, PLY_RED, PLY_BLUE, &e->has_color))
        return err_set(err, ERR_INPUT, "expected red, green and blue once each, or none of them");
    return !e->has_color || color_check(p, e, err);
}

static bool element_check(struct ply *p, struct ply_element *e, struct err *err)
{
    if (e->property_begin == e->property_end)
        return err_set(err, ERR_INPUT, "expected a property in every element");
    switch (e->role) {
    case PLY_VERTEX:
        return vertex_check(p, e, err);
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
