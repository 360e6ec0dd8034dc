/* Wavefront OBJ: vertices and faces; B. Martin et al., "Object files (.obj)", Alias|Wavefront
 * Advanced Visualizer manual, appendix B1.
 * SPDX-License-Identifier: MIT */
#include "common/mesh_build.h"

#include <string.h>

/* A logical line: up to a line's end that no backslash continues. Comments are not continued. */
static struct mesh_span line_next(struct mesh_span *file, size_t *line_count)
{
    struct mesh_span line = {file->at, file->end};
    const bool comment = line.at < line.end && *line.at == '#';
    for (const char *p = line.at; p < line.end; p++) {
        if (*p != '\n')
            continue;
        ++*line_count;
        const char *before = p > line.at && p[-1] == '\r' ? p - 1 : p;
        if (!comment && before > line.at && before[-1] == '\\')
            continue;
        line.end = p;
        file->at = p + 1;
        return line;
    }
    ++*line_count;
    file->at = file->end;
    return line;
}

static bool vertex_read(struct mesh_build *b, struct mesh_span line, struct err *err)
{
    double p[3];
    char shown[64];
    struct mesh_span token;
    for (int k = 0; k < 3; k++) {
        if (!mesh_span_token(&line, &token))
            return err_set(err, ERR_INPUT, "expected 3 coordinates, got %d", k);
        if (!mesh_span_number(token, &p[k]))
            return err_set(err, ERR_INPUT, "expected a number, got %s",
                           mesh_span_print(token, shown));
    }
    /* A weight or a color may follow. */
    return mesh_build_vertex(b, p, err) || err_at(err, "vertex %zu", mesh_build_vertices(b) + 1);
}

/* "7", "7/1", "7//3", "7/1/3", any of them negative: counted back from the last vertex. */
static bool corner_read(struct mesh_build *b, struct mesh_span token, struct err *err)
{
    char shown[64];
    struct mesh_span vertex = token;
    const char *slash = memchr(token.at, '/', (size_t)(token.end - token.at));
    if (slash)
        vertex.end = slash;
    bool good = true;
    size_t slashes = 0;
    for (const char *p = vertex.end; p < token.end; p++) {
        slashes += *p == '/';
        good &= *p == '/' || *p == '-' || (*p >= '0' && *p <= '9');
    }
    int64_t i;
    if (!mesh_span_integer(vertex, &i) || !good || slashes > 2)
        return err_set(err, ERR_INPUT, "expected a corner like 7, 7/1, 7//3 or 7/1/3, got %s",
                       mesh_span_print(token, shown));
    const int64_t count = (int64_t)mesh_build_vertices(b);
    const int64_t index = i < 0 ? count + i : i - 1;
    if (index < 0 || index >= count)
        return err_set(err, ERR_INPUT, "expected a vertex from 1 to %lld or -%lld to -1, got %lld",
                       (long long)count, (long long)count, (long long)i);
    const uint32_t v = (uint32_t)index;
    buf_append(&b->polygon, &v, sizeof v);
    return true;
}

static bool face_read(struct mesh_build *b, struct mesh_span line, struct err *err)
{
    struct mesh_span token;
    b->polygon.size = 0;
    while (mesh_span_token(&line, &token)) {
        if (*token.at == '#')
            break;
        if (!corner_read(b, token, err))
            return false;
    }
    return mesh_build_polygon(b, err);
}

static bool statement_read(struct mesh_build *b, struct mesh_span line, struct err *err)
{
    /* Known and passed over: they change nothing about flat triangles. Free-form surfaces (curv,
     * surf and what belongs to them) are not among them: a hole in the model must be said. */
    static const char *const passed[] = {"vt",       "vn",       "vp",         "g",        "o",
                                         "s",        "mg",       "usemtl",     "mtllib",   "usemap",
                                         "maplib",   "p",        "l",          "lod",      "bevel",
                                         "c_interp", "d_interp", "shadow_obj", "trace_obj"};
    struct mesh_span word;
    char shown[64];
    if (!mesh_span_token(&line, &word) || *word.at == '#')
        return true;
    if (mesh_span_is(word, "v"))
        return vertex_read(b, line, err);
    if (mesh_span_is(word, "f") || mesh_span_is(word, "fo"))
        return face_read(b, line, err);
    for (size_t i = 0; i < countof(passed); i++)
        if (mesh_span_is(word, passed[i]))
            return true;
    return err_set(err, ERR_INPUT,
                   "expected an OBJ statement for polygons (v, f, vt, vn, g, o, s, "
                   "usemtl, mtllib ...), got %s",
                   mesh_span_print(word, shown));
}

bool mesh_obj_read(struct mesh_build *b, struct mesh_span file, struct err *err)
{
    size_t line_count = 0;
    if (file.end - file.at >= 3 && !memcmp(file.at, "\xef\xbb\xbf", 3))
        file.at += 3; /* a byte order mark */
    while (file.at < file.end) {
        const size_t number = line_count + 1;
        if (!statement_read(b, line_next(&file, &line_count), err))
            return err_at(err, "line %zu", number);
    }
    return true;
}
