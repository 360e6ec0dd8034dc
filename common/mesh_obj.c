/* Wavefront OBJ: vertices, normals, texture coordinates and faces; B. Martin et al., "Object files
 * (.obj)", Alias|Wavefront Advanced Visualizer manual, appendix B1.
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

/* A comment may stand behind a statement. */
static bool word_next(struct mesh_span *line, struct mesh_span *word)
{
    return mesh_span_token(line, word) && *word->at != '#';
}

/* So many numbers, of which those behind the first `least` may be missing. */
static bool numbers_read(struct mesh_span *line, const char *what, size_t least, size_t most,
                         double out[], struct err *err)
{
    struct mesh_span word;
    char shown[64];
    for (size_t i = 0; i < most; i++) {
        if (!word_next(line, &word))
            return i >= least ||
                   err_set(err, ERR_INPUT, "expected %zu %s, got %zu", least, what, i);
        if (!mesh_span_number(word, &out[i]))
            return err_set(err, ERR_INPUT, "expected a number, got %s",
                           mesh_span_print(word, shown));
    }
    return true;
}

/* A color is what three more numbers are; one more is a weight, which only curves have. */
static bool vertex_read(struct mesh_build *b, struct mesh_span line, struct err *err)
{
    double p[3], color[3];
    struct mesh_span word;
    if (!numbers_read(&line, "coordinates", 3, 3, p, err))
        return false;
    if (!mesh_build_vertex(b, p, err))
        return err_at(err, "vertex %zu", mesh_build_vertices(b) + 1);
    size_t more = 0;
    for (struct mesh_span rest = line; word_next(&rest, &word);)
        more++;
    if (more != 3)
        return true;
    return (numbers_read(&line, "colors", 3, 3, color, err) &&
            mesh_build_color(b, color, 1, err)) ||
           err_at(err, "vertex %zu", mesh_build_vertices(b));
}

static size_t normal_count(const struct mesh_build *b)
{
    return b->normals.size / (3 * sizeof(float));
}

static size_t uv_count(const struct mesh_build *b)
{
    return b->uvs.size / (2 * sizeof(float));
}

static bool normal_read(struct mesh_build *b, struct mesh_span line, struct err *err)
{
    double n[3];
    return (numbers_read(&line, "coordinates", 3, 3, n, err) && mesh_build_normal(b, n, err)) ||
           err_at(err, "normal %zu", normal_count(b) + 1);
}

static bool uv_read(struct mesh_build *b, struct mesh_span line, struct err *err)
{
    double uv[2] = {0};
    return (numbers_read(&line, "texture coordinates", 1, 2, uv, err) &&
            mesh_build_uv(b, uv, err)) ||
           err_at(err, "texture coordinate %zu", uv_count(b) + 1);
}

enum { PARTS = 3 }; /* of a corner: vertex, texture coordinate, normal */

#define NO_NUMBER INT64_MAX

/* "7", "7/1", "7//3", "7/1/3". */
static bool corner_cut(struct mesh_span word, int64_t number[PARTS])
{
    number[1] = number[2] = NO_NUMBER;
    for (int i = 0; i < PARTS; i++) {
        const char *slash = memchr(word.at, '/', (size_t)(word.end - word.at));
        const struct mesh_span part = {word.at, slash ? slash : word.end};
        const bool empty = part.at == part.end && i > 0;
        if (!empty && !mesh_span_integer(part, &number[i]))
            return false;
        if (!slash)
            return true;
        word.at = slash + 1;
    }
    return false;
}

/* They count from 1, or from -1 backwards. */
static bool corner_read(struct mesh_build *b, struct mesh_span word, struct err *err)
{
    static const char *const names[PARTS] = {"vertex", "texture coordinate", "normal"};
    const size_t counts[PARTS] = {mesh_build_vertices(b), uv_count(b), normal_count(b)};
    int64_t number[PARTS];
    char shown[64];
    if (!corner_cut(word, number))
        return err_set(err, ERR_INPUT, "expected a corner like 7, 7/1, 7//3 or 7/1/3, got %s",
                       mesh_span_print(word, shown));
    uint32_t of[PARTS] = {MESH_NONE, MESH_NONE, MESH_NONE};
    for (int i = 0; i < PARTS; i++) {
        const int64_t count = (int64_t)counts[i];
        if (number[i] == NO_NUMBER)
            continue;
        const int64_t index = number[i] < 0 ? count + number[i] : number[i] - 1;
        if (index < 0 || index >= count)
            return err_set(err, ERR_INPUT, "expected a %s from 1 to %lld or -%lld to -1, got %lld",
                           names[i], (long long)count, (long long)count, (long long)number[i]);
        of[i] = (uint32_t)index;
    }
    buf_append(&b->polygon, &(struct mesh_corner){of[0], of[1], of[2]}, sizeof(struct mesh_corner));
    return true;
}

static bool face_read(struct mesh_build *b, struct mesh_span line, struct err *err)
{
    struct mesh_span word;
    b->polygon.size = 0;
    while (word_next(&line, &word))
        if (!corner_read(b, word, err))
            return false;
    return mesh_build_polygon(b, err);
}

static bool statement_read(struct mesh_build *b, struct mesh_span line, struct err *err)
{
    /* Known and passed over. Free-form surfaces (curv, surf and what belongs to them) are not among
     * them: a hole in the model must be said. */
    static const char *const passed[] = {
        "vp", "g", "o",   "s",     "mg",       "usemtl",   "mtllib",     "usemap",   "maplib",
        "p",  "l", "lod", "bevel", "c_interp", "d_interp", "shadow_obj", "trace_obj"};
    struct mesh_span word;
    char shown[64];
    if (!mesh_span_token(&line, &word) || *word.at == '#')
        return true;
    if (mesh_span_is(word, "v"))
        return vertex_read(b, line, err);
    if (mesh_span_is(word, "vn"))
        return normal_read(b, line, err);
    if (mesh_span_is(word, "vt"))
        return uv_read(b, line, err);
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
    mesh_build_split(b);
    return true;
}
